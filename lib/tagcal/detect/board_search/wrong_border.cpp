#include "tagcal/detect/board_search/wrong_border.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::internal {
namespace {

// numeric: pictures that are searched first, of which all or none have another border.
constexpr std::size_t kProbes = 3;

int other_border(int border_bits) { return 3 - border_bits; }

// The boards with the other border, laid out as a target file would have them.
std::vector<PlacedBoard> with_other_border(const std::vector<PlacedBoard>& boards) {
  std::vector<PlacedBoard> others;
  const auto change = [](auto& kind) {
    if constexpr (requires { kind.border_bits; }) kind.border_bits = other_border(kind.border_bits);
    if constexpr (requires { kind.corner_squares; }) kind.corner_squares = kind.border_bits == 2;
  };
  for (PlacedBoard placed : boards) {
    const auto kind = tag_kind(placed.board);
    if (!kind || checkers(placed.board) ||
        tag_family(kind->family, kind->border_bits).reversed_border)
      continue;
    std::visit(change, placed.board.pattern);
    others.push_back(placed);
  }
  return others;
}

// The searches of one thread, which only count tags: refined sides are accurate enough.
struct OtherSearch {
  std::vector<TagSearch> searches;

  explicit OtherSearch(const std::vector<PlacedBoard>& boards)
      : searches(tag_searches(boards, {.refinement = Refinement::edges})) {}

  int count(const ImageView8& image) {
    TagCount count;
    for (TagSearch& search : searches)
      for (const Completion& completion : search.find(image).completions)
        count.add(image, completion, search.family());
    return count.sure;
  }
};

std::vector<std::size_t> suspicious_pictures(const std::vector<DetectedPicture>& found) {
  std::vector<std::size_t> pictures;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i].num_unread > found[i].num_sure) pictures.push_back(i);
  return pictures;
}

std::vector<std::size_t> evenly_spread(const std::vector<std::size_t>& all, std::size_t n) {
  if (all.size() <= n) return all;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < n; ++i) some.push_back(all[i * (all.size() - 1) / (n - 1)]);
  return some;
}

std::string warning_text(std::size_t shown, std::size_t num_pictures, int border_bits) {
  return fmt::format(
      "the tags in {} of {} pictures have a border of {} bit{}, but the target file says {}: few "
      "of "
      "them are read, and some of these wrongly. Put border_bits: {} into the target file",
      shown, num_pictures, border_bits, border_bits == 1 ? "" : "s", other_border(border_bits),
      border_bits);
}

}  // namespace

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

std::vector<std::string> wrong_border_warnings(const std::vector<ImageSource>& images,
                                               const std::vector<DetectedPicture>& found,
                                               const std::vector<PlacedBoard>& boards,
                                               const DetectOptions& options) {
  const std::vector<std::size_t> suspicious = suspicious_pictures(found);
  const std::vector<PlacedBoard> others = with_other_border(boards);
  if (suspicious.empty() || others.empty()) return {};
  const int threads = threads_of(options.threads);
  std::vector<int> read(images.size(), 0);
  const auto look_at = [&](const std::vector<std::size_t>& pictures) {
    std::vector<OtherSearch> readers;
    const int num_readers = std::clamp(static_cast<int>(pictures.size()), 1, threads);
    for (int i = 0; i < num_readers; ++i) readers.emplace_back(others);
    parallel_for(pictures.size(), readers, [&](OtherSearch& reader, std::size_t i) {
      read[pictures[i]] = reader.count(PictureWithoutMosaic(images[pictures[i]].load()).pixels);
    });
  };
  const auto shows_other = [&](std::size_t i) {
    return shows_other_kind(read[i], found[i].num_sure);
  };
  const std::vector<std::size_t> probes = evenly_spread(suspicious, kProbes);
  look_at(probes);
  if (std::ranges::none_of(probes, shows_other)) return {};
  look_at(suspicious);
  int all_read = 0, all_sure = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    all_read += read[i];
    all_sure += found[i].num_sure;
  }
  if (!shows_other_kind(all_read, all_sure)) return {};
  const auto shown = static_cast<std::size_t>(std::ranges::count_if(suspicious, shows_other));
  return {warning_text(shown, images.size(), tag_kind(others.front().board)->border_bits)};
}

}  // namespace tagcal::internal
