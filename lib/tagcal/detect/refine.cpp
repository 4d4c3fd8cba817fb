#include "tagcal/detect/refine.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

bool has_ascending(const std::vector<double>& lines, std::size_t least) {
  return lines.size() >= least && lines.size() <= kMaxTagLines &&
         std::ranges::is_sorted(lines, std::ranges::less_equal());
}

void check(const TagPattern& pattern) {
  const std::size_t n = pattern.lines.size();
  if (!has_ascending(pattern.lines, 4) || pattern.cells.size() != (n - 1) * (n - 1))
    throw Error(
        "refine_tag: pattern: must have 4 to 24 ascending lines and a cell between each two");
}

void check(const CornerPattern& pattern) {
  for (const std::vector<double>* lines : {&pattern.columns, &pattern.rows})
    if (!has_ascending(*lines, 3) || std::ranges::find(*lines, 0.0) == lines->end())
      throw Error("refine_corner: pattern: must have 3 to 24 ascending lines, one of them at 0");
  if (pattern.cells.size() != (pattern.columns.size() - 1) * (pattern.rows.size() - 1))
    throw Error("refine_corner: pattern: must have a cell between each two lines");
}

void check_camera(const Camera* camera, const ImageSize& size, const std::string& caller) {
  if (camera && camera->image_size != size)
    throw Error(caller + ": camera: its image must have the size of the picture");
}

template <typename T>
TagFit fit_region(const ImageView<T>& image, const TagRegion& region, const TagCorners& start,
                  const TagFitOptions& options, const BorderShift* shift = nullptr) {
  TagFitter fitter(region, start, options, shift);
  return fitter.cut(image) ? fitter.fit() : TagFit();
}

// Fits each corner of a large tag by itself, from pixels of its own.
template <typename T>
TagFit fit_parts(const ImageView<T>& image, const TagPattern& pattern, const TagCorners& start,
                 TagFitOptions options, const BorderShift& shift) {
  options.lens_follows = false;  // these fits are the last ones
  TagFit fit;
  fit.is_by_corner = true;
  fit.shift_px = shift.px;
  for (std::size_t i = 0; i < 4; ++i) {
    TagFit part = fit_region(image, part_of_tag(pattern, start, i), start, options, &shift);
    if (part.status != TagFitStatus::converged) {
      fit.status = part.status;
      return fit;
    }
    fit.corners[i] = part.corners[i];
    fit.covariance_px2 += part.covariance_px2;
    fit.blur_px += part.blur_px / 4;
    fit.black += part.black / 4;
    fit.white += part.white / 4;
    fit.noise_levels = std::hypot(fit.noise_levels, part.noise_levels / 2);
    fit.num_pixels += part.num_pixels;
    fit.iterations = std::max(fit.iterations, part.iterations);
  }
  fit.status = TagFitStatus::converged;
  return fit;
}

// Fits the corners one by one or, if one of them fails, the whole tag; the unknown bends beyond
// third order then count in the covariance. A part about one corner does not tell a shift of the
// borders from the corner's place: the whole tag gives it.
template <typename T>
TagFit fit_strongly_bent(const ImageView<T>& image, const TagPattern& pattern,
                         const TagCorners& start, const TagFitOptions& options) {
  TagFitOptions whole = options;
  whole.is_whole = true;
  const TagRegion region = whole_tag(pattern, start);
  TagFitter fitter(region, start, whole);
  if (!fitter.cut(image)) return {};
  if (const auto shift = fitter.border_shift()) {
    const TagFit parts = fit_parts(image, pattern, start, options, *shift);
    if (parts.status == TagFitStatus::converged) return parts;
  }
  TagFit fit = fitter.fit();
  fit.is_by_corner = true;
  fit.covariance_px2.diagonal().array() +=
      std::pow(policy::kTagNextOrderShare * fitter.third_order_px(), 2);
  return fit;
}

template <typename T>
TagFit fit_tag(const ImageView<T>& image, const TagPattern& pattern, const TagCorners& start,
               const TagFitOptions& options) {
  const double side_px = 2 * mean_half_side(start);
  const bool is_bent = options.bend_sd_per_px > 0 && options.twist_sd_per_px2 > 0 &&
                       !options.camera && !options.is_whole;
  if (is_bent && side_px > policy::kTagMaxWholePx)
    return fit_strongly_bent(image, pattern, start, options);
  const TagRegion region = whole_tag(pattern, start);
  TagFitter fitter(region, start, options);
  if (!fitter.cut(image)) return {};
  TagFit fit = fitter.fit();
  fit.is_by_corner = fitter.is_for_parts();
  return fit.is_by_corner && !options.lens_follows
             ? fit_strongly_bent(image, pattern, fit.corners, options)
             : fit;
}

template <typename T>
TagFit refine(const ImageView<T>& image, const TagPattern& pattern, const TagCorners& start,
              const TagFitOptions& options) {
  check(pattern);
  check_camera(options.camera, image.size(), "refine_tag");
  TagFit fit;
  fit.status = TagFitStatus::out_of_image;
  if (!is_inside(start, image.size(), 0)) return fit;
  fit = fit_tag(image, pattern, start, options);
  // Symmetric to the last bit.
  fit.covariance_px2 = ((fit.covariance_px2 + fit.covariance_px2.transpose()) / 2).eval();
  if (fit.status == TagFitStatus::converged && !is_inside(fit.corners, image.size(), 0))
    fit.status = TagFitStatus::out_of_image;
  return fit;
}

template <typename T>
CornerFit refine(const ImageView<T>& image, const CornerPattern& pattern,
                 const Eigen::Matrix3d& image_from_pattern, const TagFitOptions& options) {
  check(pattern);
  check_camera(options.camera, image.size(), "refine_corner");
  const auto is_in_picture = [&](const Vector2d& at) {
    return is_inside({at, at, at, at}, image.size(), 0);
  };
  CornerFit result;
  const auto [region, start] = about_corner(pattern, image_from_pattern);
  result.status = TagFitStatus::out_of_image;
  if (!is_in_picture(start[0])) return result;
  const TagFit fit = fit_region(image, region, start, options);
  static_cast<PatternFit&>(result) = fit;
  result.corner = fit.corners[0];
  const Eigen::Matrix2d covariance = fit.covariance_px2.topLeftCorner<2, 2>();
  result.covariance_px2 = (covariance + covariance.transpose()) / 2;
  if (fit.status == TagFitStatus::converged && !is_in_picture(result.corner))
    result.status = TagFitStatus::out_of_image;
  return result;
}

}  // namespace

TagFit refine_tag(const ImageView8& image, const TagPattern& pattern,
                  const std::array<Vector2d, 4>& start, const TagFitOptions& options) {
  return refine(image, pattern, start, options);
}

TagFit refine_tag(const ImageView16& image, const TagPattern& pattern,
                  const std::array<Vector2d, 4>& start, const TagFitOptions& options) {
  return refine(image, pattern, start, options);
}

CornerFit refine_corner(const ImageView8& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern, const TagFitOptions& options) {
  return refine(image, pattern, image_from_pattern, options);
}

CornerFit refine_corner(const ImageView16& image, const CornerPattern& pattern,
                        const Eigen::Matrix3d& image_from_pattern, const TagFitOptions& options) {
  return refine(image, pattern, image_from_pattern, options);
}

}  // namespace tagcal
