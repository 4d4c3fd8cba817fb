#include "tagcal/detect/board_search/tag_count.hpp"

#include <algorithm>

#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {

bool is_sure(const ImageView8& image, const FoundTag& tag, const TagFamily& family) {
  const TagAnswer answer =
      read_tag(image, tag.corners, TagCells(family, tag.id, {.corner_squares = true}));
  return answer.wrong_bits <= DetectOptions().max_hamming &&
         answer.wrong_fixed < policy::kTagMaxWrongFixed;
}

void TagCount::add(const ImageView8& image, const Completion& completion, const TagFamily& family) {
  for (const FoundTag& tag : completion.tags)
    ++(tag.fitted || is_sure(image, tag, family) ? sure : unread);
  unread += static_cast<int>(std::ranges::count_if(
      completion.missing, [](const MissingTag& tag) { return tag.why != WhyNot::outside; }));
}

}  // namespace tagcal::internal
