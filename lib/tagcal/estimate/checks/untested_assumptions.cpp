#include "tagcal/estimate/checks/untested_assumptions.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

// Ratio by which the standard deviation of the focal length grows if the principal point is free,
// with a prior of standard deviation `spread`. `information`: of f, cx, cy, for noise of 1.
double growth_with_free_centre(const Eigen::Matrix3d& information, double spread) {
  Eigen::Matrix2d centre = information.bottomRightCorner<2, 2>();
  centre.diagonal().array() += 1 / (spread * spread);
  const Eigen::Vector2d with_focal = information.bottomLeftCorner<2, 1>();
  const double share = with_focal.dot(centre.inverse() * with_focal) / information(0, 0);
  return 1 / std::sqrt(std::max(1e-12, 1 - share));  // numeric: no division by zero
}

// Largest standard deviation of the projection at infinity over the corners of the image that the
// lens sees.
double worst_corner_px(const UncertainLens& lens, const ImageSize& size,
                       std::span<const Eigen::Vector2d> samples) {
  double worst = 0;
  const ProjectionUncertainty known =
      projection_uncertainty(lens, {size, 2, 2}, samples, kInfinitelyFar);
  for (const double sigma : known.sigma_px.reshaped())
    if (sigma > worst) worst = sigma;
  return worst;
}

}  // namespace

std::optional<std::string> untested_principal_point(const Bundle& solved, double sigma) {
  if (solved.model->name() != "f" || !solved.model->held().empty()) return std::nullopt;
  const Bundle open = with_model(solved, Model::named("f+c"));
  const auto information = bundle_information(open);
  if (!information) return std::nullopt;
  const Eigen::Matrix3d s = (information->halves[0] + information->halves[1]).topLeftCorner<3, 3>();
  const ImageSize& size = solved.image_size;
  const double spread = policy::kCentreSpread * std::hypot(size.width, size.height);
  const Observability seen = observability(open, information, sigma);
  char text[250];
  if (seen.status == Status::ok) {
    if (growth_with_free_centre(s, spread / sigma) < policy::kMuchLargerSd) return std::nullopt;
    const Eigen::Vector3d sd = seen.covariance->parameters.diagonal().cwiseSqrt();
    std::snprintf(text, sizeof text,
                  "the principal point is taken to be the centre of the image, and the views "
                  "determine it to %.2g px only: with model f+c the standard deviation of the "
                  "focal length would be %.2g px, not %.2g px",
                  sd.tail<2>().maxCoeff(), sd[0], sigma / std::sqrt(s(0, 0)));
    return text;
  }
  constexpr double kOffsetPx = 10;
  const double change = kOffsetPx * s.row(0).tail<2>().norm() / s(0, 0);
  std::snprintf(text, sizeof text,
                "the principal point is taken to be the centre of the image, and the views do not "
                "determine it: an error of %g px changes the focal length by up to %.2g px",
                kOffsetPx, change);
  return text;
}

std::optional<std::string> extrapolated_corners(const Bundle& solved, double sigma,
                                                const UncertainLens& lens,
                                                std::span<const Eigen::Vector2d> samples) {
  const double own_px = worst_corner_px(lens, solved.image_size, samples);
  char text[300];
  if (own_px >
      policy::kImageCornerShare * std::hypot(solved.image_size.width, solved.image_size.height)) {
    std::snprintf(
        text, sizeof text,
        "the standard deviation of the projection is %.2g px at the corners of the image: the lens "
        "is extrapolated there",
        own_px);
    return text;
  }
  const Model& usual = lens.model->sibling("opencv5");
  if (lens.model->lens_type() != LensType::perspective ||
      lens.model->num_free() >= usual.num_free())
    return std::nullopt;
  const Bundle larger = with_model(solved, usual);
  const auto covariance = covariance_of(larger, sigma);
  if (!covariance) return std::nullopt;
  const double open_px = worst_corner_px({larger.model, larger.lens(), covariance->parameters},
                                         solved.image_size, samples);
  if (open_px < std::max(policy::kImageCornerPx, policy::kMuchLargerSd * own_px))
    return std::nullopt;
  std::snprintf(text, sizeof text,
                "the views do not show whether the lens has more distortion than model %s: with "
                "model opencv5 the standard deviation of the projection at the corners of the "
                "image is %.2g px, not %.2g px; the lens is extrapolated there",
                std::string(lens.model->name()).c_str(), open_px, own_px);
  return text;
}

}  // namespace tagcal::internal
