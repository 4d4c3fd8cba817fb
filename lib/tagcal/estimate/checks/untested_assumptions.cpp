#include "tagcal/estimate/checks/untested_assumptions.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibration/simpler_model_test.hpp"
#include "tagcal/estimate/calibration/supported_models.hpp"

namespace tagcal::internal {
namespace {

constexpr double kMuchLarger = 1.5;  // a standard deviation than that of the model alone
constexpr double kCornerPx = 0.5;
constexpr double kCornerShare = 0.005;  // of the image's diagonal

// How much larger the standard deviation of the focal length is where the centre is not known but
// by the views and by what cameras have. `information`: of f, cx, cy, for noise of 1.
double with_open_centre(const Eigen::Matrix3d& information, double spread) {
  Eigen::Matrix2d centre = information.bottomRightCorner<2, 2>();
  centre.diagonal().array() += 1 / (spread * spread);
  const Eigen::Vector2d with_focal = information.bottomLeftCorner<2, 1>();
  const double share = with_focal.dot(centre.inverse() * with_focal) / information(0, 0);
  return 1 / std::sqrt(std::max(1e-12, 1 - share));
}

// At the corners of the image, those that the lens sees; at infinity.
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

std::optional<std::string> assumed_centre(const Bundle& solved, double sigma) {
  if (solved.model->name() != "f" || !solved.model->held().empty()) return std::nullopt;
  const Bundle open = with_model(solved, Model::named("f+c"));
  const auto information = bundle_information(open);
  if (!information) return std::nullopt;
  const Eigen::Matrix3d s = information->halves[0] + information->halves[1];
  const ImageSize& size = solved.image_size;
  const double spread = kCentreSpread * std::hypot(size.width, size.height);
  const Observability seen = observability(open, information, sigma);
  char text[250];
  if (seen.status == Status::ok) {
    if (with_open_centre(s, spread / sigma) < kMuchLarger) return std::nullopt;
    const Eigen::Vector3d sd = seen.covariance->parameters.diagonal().cwiseSqrt();
    std::snprintf(text, sizeof text,
                  "the principal point is taken to be the centre of the image, the views hold it "
                  "to %.2g px: were it open, the focal length would be known to %.2g px and not to "
                  "%.2g px",
                  sd.tail<2>().maxCoeff(), sd[0], sigma / std::sqrt(s(0, 0)));
    return text;
  }
  constexpr double kBesidePx = 10;
  const double change = kBesidePx * s.row(0).tail<2>().norm() / s(0, 0);
  std::snprintf(text, sizeof text,
                "the principal point is taken to be the centre of the image, the views do not hold "
                "it: %g px beside it change the focal length by up to %.2g px",
                kBesidePx, change);
  return text;
}

std::optional<std::string> extrapolated_corners(const Bundle& solved, double sigma,
                                                const UncertainLens& lens,
                                                std::span<const Eigen::Vector2d> samples) {
  const double own_px = worst_corner_px(lens, solved.image_size, samples);
  char text[300];
  if (own_px > kCornerShare * std::hypot(solved.image_size.width, solved.image_size.height)) {
    std::snprintf(
        text, sizeof text,
        "the projection at the corners of the image is known to %.2g px only: the lens is "
        "extrapolated there",
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
  if (open_px < std::max(kCornerPx, kMuchLarger * own_px)) return std::nullopt;
  std::snprintf(text, sizeof text,
                "the views do not tell whether the lens has more distortion than that of model "
                "%s: with that of opencv5 its projection at the corners of the image is known to "
                "%.2g px, not to %.2g px, the lens is extrapolated there",
                std::string(lens.model->name()).c_str(), open_px, own_px);
  return text;
}

}  // namespace tagcal::internal
