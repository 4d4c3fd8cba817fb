#include "tagcal/detect/board_search/completion.hpp"

#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {

std::optional<WhyNot> reason_to_reject(const ImageView8& image, const Quad& quad,
                                       const TagCells& cells, int most_wrong_bits) {
  const TagAnswer answer = read_tag(image, quad, cells);
  if (answer.contrast < policy::kMinContrast) return WhyNot::no_contrast;
  if (answer.wrong_fixed > policy::kTagMaxWrongFixed) return WhyNot::no_border;
  if (answer.wrong_bits > most_wrong_bits) return WhyNot::other_bits;
  return std::nullopt;
}

std::string_view why_not_text(WhyNot why) {
  switch (why) {
    case WhyNot::no_neighbour:
      return "no other tag of its plane was found to predict its place";
    case WhyNot::outside:
      return "outside the picture, or cut by its edge";
    case WhyNot::too_small:
      return "too small: its cells are smaller than a pixel";
    case WhyNot::no_contrast:
      return "the picture has no contrast at its place";
    case WhyNot::no_border:
      return "no black border at its place";
    case WhyNot::other_bits:
      return "the cells at its place do not show its code";
    case WhyNot::no_edges:
      return "its edges cannot be fitted, probably because of blur";
    case WhyNot::no_fit:
      return "read, but its pattern cannot be fitted to the pixels, so its corners are unreliable";
    case WhyNot::alone:
      return "decoded, but no neighbour confirms it: possibly a chance match";
  }
  return "";
}

}  // namespace tagcal::internal
