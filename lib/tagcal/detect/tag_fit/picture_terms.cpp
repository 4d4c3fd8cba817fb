#include "tagcal/detect/tag_fit/picture_terms.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "tagcal/detect/tag_fit/known_tag.hpp"

namespace tagcal::internal {

PictureTerms terms_of_picture(const ImageView8& image, std::vector<TagInPicture> tags) {
  std::ranges::stable_sort(
      tags, {}, [](const TagInPicture& tag) { return order_of_part(shortest_side(tag.corners)); });
  PictureTerms terms;
  terms.processing = processing_of_picture(image, tags);
  terms.print = printed_lines_of_picture(image, tags, terms.processing);
  if (terms.print.is_none()) return terms;
  // Displaced borders look as if the camera had changed the levels: both once more.
  std::deque<TagPattern> patterns;
  std::vector<TagInPicture> printed = tags;
  for (TagInPicture& tag : printed)
    tag.pattern = &patterns.emplace_back(terms.print.printed(*tag.pattern));
  terms.processing = processing_of_picture(image, printed);
  terms.print = printed_lines_of_picture(image, tags, terms.processing, terms.print);
  return terms;
}

std::optional<TagFit> fit_tag_with(const PictureTerms& terms, const ImageView8& image,
                                   const TagPattern& pattern, const Quad& start,
                                   TagFitOptions options, double reach_px) {
  options.processing = terms.processing;
  const auto exact = fit_known_tag(image, pattern, start, options, reach_px);
  if (terms.print.is_none()) return exact;
  const auto printed = fit_known_tag(image, terms.print.printed(pattern), start, options, reach_px);
  const bool is_exact =
      exact && exact->status == TagFitStatus::converged &&
      (!printed || 2 * exact->num_pixels * std::log(printed->noise_levels / exact->noise_levels) >
                       policy::kPrintSure);
  return is_exact ? exact : printed;
}

}  // namespace tagcal::internal
