#include "tagcal/estimate/assumed.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "tagcal/estimate/doubt.hpp"
#include "tagcal/estimate/observability.hpp"

namespace tagcal {
namespace {

// Of the image's diagonal: cameras have their principal points some per cent beside the centre.
constexpr double kCentreSpread = 0.02;
constexpr double kMuchLarger = 1.5;  // a standard deviation than that of the model alone
constexpr double kCornerPx = 0.5;

// How much larger the standard deviation of the focal length is where the centre is not known but
// by the views and by what cameras have. `information`: of f, cx, cy, for noise of 1.
double with_open_centre(const Eigen::Matrix3d& information, double spread) {
  Eigen::Matrix2d centre = information.bottomRightCorner<2, 2>();
  centre.diagonal().array() += 1 / (spread * spread);
  const Eigen::Vector2d with_focal = information.bottomLeftCorner<2, 1>();
  const double share = with_focal.dot(centre.inverse() * with_focal) / information(0, 0);
  return 1 / std::sqrt(std::max(1e-12, 1 - share));
}

struct Step {
  std::string_view model, larger, coefficient;
};

const Step* next_coefficient(std::string_view model) {
  static constexpr std::array<Step, 5> kSteps = {{{"f", "radial1", "k1"},
                                                  {"f+c", "radial1", "k1"},
                                                  {"pinhole", "radial1", "k1"},
                                                  {"radial1", "radial2", "k2"},
                                                  {"radial2", "opencv5", "k3"}}};
  for (const Step& step : kSteps)
    if (step.model == model) return &step;
  return nullptr;
}

// At the worst corner of the image that both lenses see.
struct AtCorners {
  double own_px = 0, open_px = 0;
};

AtCorners at_corners(const UncertainLens& own, const UncertainLens& open, const ImageSize& size,
                     std::span<const Eigen::Vector2d> samples) {
  const ImageGrid corners{size, 2, 2};
  const Eigen::MatrixXd a = projection_uncertainty(own, corners, samples, kInfinitelyFar).sigma_px;
  const Eigen::MatrixXd b = projection_uncertainty(open, corners, samples, kInfinitelyFar).sigma_px;
  AtCorners worst;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    if (b.reshaped()[i] > worst.open_px && std::isfinite(a.reshaped()[i]))
      worst = {a.reshaped()[i], b.reshaped()[i]};
  return worst;
}

}  // namespace

std::optional<std::string> assumed_centre(const Bundle& solved, double sigma) {
  if (solved.model->name() != "f") return std::nullopt;
  const Bundle open = with_model(solved, Model::named("f+c"));
  const auto information = bundle_information(open);
  if (!information) return std::nullopt;
  const Eigen::Matrix3d s = information->halves[0] + information->halves[1];
  const ImageSize& size = solved.image_size;
  const double spread = kCentreSpread * std::hypot(size.width, size.height);
  const bool held = observability(open, information, sigma).status == Status::ok;
  if (held && with_open_centre(s, spread / sigma) < kMuchLarger) return std::nullopt;
  constexpr double kBesidePx = 10;
  const double change = kBesidePx * s.row(0).tail<2>().norm() / s(0, 0);
  char text[200];
  std::snprintf(text, sizeof text,
                "the principal point is taken to be the centre of the image, the views %s: %g px "
                "beside it change the focal length by up to %.2g px",
                held ? "hold it loosely only" : "do not hold it", kBesidePx, change);
  return text;
}

std::optional<std::string> assumed_coefficient(const Bundle& solved, double sigma,
                                               const UncertainLens& lens,
                                               std::span<const Eigen::Vector2d> samples) {
  const Step* step = next_coefficient(solved.model->name());
  if (!step) return std::nullopt;
  const Bundle larger = with_model(solved, Model::named(step->larger));
  const auto covariance = covariance_of(larger, sigma);
  if (!covariance) return std::nullopt;
  const AtCorners worst = at_corners(lens, {larger.model, larger.lens(), covariance->parameters},
                                     solved.image_size, samples);
  if (worst.open_px < std::max(kCornerPx, kMuchLarger * worst.own_px)) return std::nullopt;
  char text[200];
  std::snprintf(text, sizeof text,
                "the views do not tell whether the lens has a %s: if it may, its projection at the "
                "corners of the image is known to %.2g px and not to %.2g px, the lens is "
                "extrapolated there",
                std::string(step->coefficient).c_str(), worst.open_px, worst.own_px);
  return text;
}

}  // namespace tagcal
