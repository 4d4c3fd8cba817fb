#include "tagcal/detect/tag_fit/picture_terms.hpp"

#include <algorithm>
#include <deque>

namespace tagcal::internal {
namespace {

constexpr double kLargeSidePx = 45;  // of a tag that is large enough, as a limit of work

}  // namespace

PictureTerms terms_of_picture(const ImageView8& image, std::vector<TagInPicture> tags) {
  // First the smallest of the large tags, which cost least, then the largest of the others.
  std::ranges::stable_sort(tags, {}, [](const TagInPicture& tag) {
    const double side = shortest_side(tag.corners);
    return side >= kLargeSidePx ? side : 1e9 - side;
  });
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
  terms.print = printed_lines_of_picture(image, tags, terms.processing);
  return terms;
}

}  // namespace tagcal::internal
