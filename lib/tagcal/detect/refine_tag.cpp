#include "tagcal/detect/refine_tag.hpp"

#include <algorithm>

#include "tagcal/detect/refine_tag_fitter.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

bool is_inside(const TagCorners& corners, const ImageSize& size) {
  return std::ranges::all_of(corners, [&](const Vector2d& corner) {
    return corner.x() >= -0.5 && corner.y() >= -0.5 && corner.x() <= size.width - 0.5 &&
           corner.y() <= size.height - 0.5;
  });
}

void check(const TagPattern& pattern) {
  const std::size_t n = pattern.lines.size();
  if (n < 4 || n > kMaxTagLines || pattern.cells.size() != (n - 1) * (n - 1))
    throw Error("refine_tag: pattern: must have 4 to 24 lines and a cell between each two");
  if (!std::ranges::is_sorted(pattern.lines, std::ranges::less_equal()))
    throw Error("refine_tag: pattern: lines must ascend");
}

template <typename T>
TagFit refine(const Image<T>& image, const TagPattern& pattern, const TagCorners& start,
              const TagFitOptions& options) {
  check(pattern);
  TagFit fit;
  fit.status = TagFitStatus::out_of_image;
  if (!is_inside(start, image.size())) return fit;
  TagFitter fitter(pattern, start, options);
  if (!fitter.cut(image)) return {};
  fit = fitter.fit();
  if (fit.status == TagFitStatus::converged && !is_inside(fit.corners, image.size()))
    fit.status = TagFitStatus::out_of_image;
  return fit;
}

}  // namespace

TagFit refine_tag(const Image8& image, const TagPattern& pattern,
                  const std::array<Vector2d, 4>& start, const TagFitOptions& options) {
  return refine(image, pattern, start, options);
}

TagFit refine_tag(const Image16& image, const TagPattern& pattern,
                  const std::array<Vector2d, 4>& start, const TagFitOptions& options) {
  return refine(image, pattern, start, options);
}

}  // namespace tagcal
