#include "tagcal/estimate/bundle/lens_from_rays.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/kernels/parameter_index.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::optional<LensFromRays> state_of(const Model& model, std::vector<double> values,
                                     const ImageSize& size, const Sightings& seen) {
  const auto lens = model.lens(values, size);
  if (!lens) return std::nullopt;
  auto at = ray_equations(*lens, model.free(), seen);
  if (!at) return std::nullopt;
  return LensFromRays{std::move(values), std::move(*at)};
}

// The sum of squares that rounding makes.
double rounding_cost(const ImageSize& size, const Sightings& seen) {
  constexpr double kRounding = 1e-14;  // numeric: of a pixel, relative to the width of the image
  return std::pow(kRounding * size.width, 2) * static_cast<double>(seen.size());
}

// The step of Levenberg and Marquardt with the damping `lambda` of the scaled columns.
VectorXd damped_step(const RayEquations& at, const VectorXd& scales, double lambda) {
  const Eigen::Index n = at.jacobian.rows(), k = at.jacobian.cols();
  MatrixXd stacked(n + k, k);
  stacked.topRows(n) = at.jacobian * scales.asDiagonal();
  stacked.bottomRows(k) = std::sqrt(lambda) * MatrixXd::Identity(k, k);
  VectorXd right = VectorXd::Zero(n + k);
  right.head(n) = -at.residuals;
  return scales.asDiagonal() * stacked.householderQr().solve(right).eval();
}

// Descends until a step predicts no decrease that matters. A step out of the domain is one uphill.
void descend(LensFromRays& state, const Model& model, const ImageSize& size,
             const Sightings& seen) {
  constexpr int kMostSteps = 200;        // numeric: a limit of work
  constexpr double kMostDamping = 1e10;  // numeric: such a step moves nothing
  constexpr double kFlat = 1e-9;         // numeric: of the sum of squares; nothing to gain
  double lambda = 1e-3;                  // numeric: a start, adapted at each step
  for (int i = 0; i < kMostSteps && lambda < kMostDamping; ++i) {
    const VectorXd step = damped_step(state.at, column_scales(state.at.jacobian), lambda);
    const double predicted =
        state.at.cost() - (state.at.residuals + state.at.jacobian * step).squaredNorm();
    // The decrease by a strongly damped step is small everywhere.
    if (lambda < 1 && predicted <= rounding_cost(size, seen) + kFlat * state.at.cost()) return;
    std::vector<double> values = state.free_values;
    for (std::size_t k = 0; k < values.size(); ++k) values[k] += step[static_cast<Eigen::Index>(k)];
    auto next = state_of(model, std::move(values), size, seen);
    const bool is_lower = next && next->at.cost() < state.at.cost();
    if (is_lower) state = std::move(*next);
    lambda *= is_lower ? 0.1 : 10;  // numeric: as usual
  }
}

// f and the coefficients at `powers` (LensParameter) that solve m D = f b N by linear least
// squares, with the pixel m from the centre, the undistorted point b (the image by the plain lens
// of the kind), s = |b|^2, and L = N / D of lens.hpp: f at power 0, f k for the numerator, k for
// the denominator.
VectorXd solve_radial(const Sightings& seen, const LensKind& kind, const Vector2d& centre,
                      const std::vector<int>& powers) {
  const Lens plain = plain_lens(kind, 1, Vector2d::Zero());
  MatrixXd a(static_cast<Eigen::Index>(2 * seen.size()), static_cast<Eigen::Index>(powers.size()));
  VectorXd m(a.rows());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Vector2d b = project(plain, seen.rays[i]).value_or(Vector2d::Zero());
    const Vector2d from_centre = seen.pixels[i] - centre;
    const auto row = static_cast<Eigen::Index>(2 * i);
    m.segment<2>(row) = from_centre;
    for (std::size_t k = 0; k < powers.size(); ++k)
      a.block<2, 1>(row, static_cast<Eigen::Index>(k)) =
          std::pow(b.squaredNorm(), std::abs(powers[k])) *
          (powers[k] < 0 ? Vector2d(-from_centre) : b);
  }
  const VectorXd scales = column_scales(a);
  return scales.asDiagonal() * (a * scales.asDiagonal()).colPivHouseholderQr().solve(m).eval();
}

// A start: f and, with `radial`, the radial coefficients by linear least squares about the centre;
// the others are those of the plain lens.
std::vector<double> linear_start(const Model& model, const Sightings& seen, const Vector2d& centre,
                                 bool radial) {
  std::vector<int> powers = {0};
  const auto n = static_cast<std::size_t>(model.num_free());
  for (std::size_t i = 0; i < n; ++i)
    if (const int power = model.parameter(i).power; radial && power != 0) powers.push_back(power);
  const VectorXd solved = solve_radial(seen, model.kind(), centre, powers);
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i) {
    const LensParameter& parameter = model.parameter(i);
    const auto at = std::ranges::find(powers, parameter.power);
    const bool is_focal = parameter.role == ParameterRole::focal_length;
    if (parameter.role == ParameterRole::principal_point)
      values.push_back(model.free()[i].lens_parameters.front() == kCx ? centre.x() : centre.y());
    else if (at == powers.end() || (parameter.power == 0 && !is_focal))
      values.push_back(parameter.plain);
    else
      values.push_back(solved[at - powers.begin()] / (parameter.power > 0 ? solved[0] : 1));
  }
  return values;
}

}  // namespace

std::optional<RayEquations> ray_equations(const Lens& lens, std::span<const FreeParameter> free,
                                          const Sightings& seen) {
  const std::size_t n = seen.size();
  std::vector<Vector2d> pixels(n);
  std::vector<std::uint8_t> valid(n);
  const auto rows = static_cast<Eigen::Index>(2 * n);
  RowMajor jacobian(rows, static_cast<Eigen::Index>(free.size()));
  const ProjectionOutput output{
      pixels, valid, {}, {jacobian.data(), static_cast<std::size_t>(jacobian.size())}};
  if (project_with_jacobians(lens, Pose(), seen.rays, free, output) < n) return std::nullopt;
  RayEquations result{VectorXd(rows), jacobian};
  for (std::size_t i = 0; i < n; ++i)
    result.residuals.segment<2>(static_cast<Eigen::Index>(2 * i)) = pixels[i] - seen.pixels[i];
  return result;
}

VectorXd column_scales(const MatrixXd& jacobian) {
  return jacobian.colwise().norm().transpose().unaryExpr(
      [](double norm) { return norm > 0 ? 1 / norm : 1.0; });
}

std::optional<LensFromRays> lens_from_rays(const Model& model, const ImageSize& size,
                                           const Sightings& seen, const Vector2d& centre,
                                           std::vector<std::vector<double>> starts) {
  for (const bool radial : {true, false})
    starts.push_back(linear_start(model, seen, centre, radial));
  std::optional<LensFromRays> best;
  for (const std::vector<double>& start : starts) {
    if (best && best->at.cost() <= rounding_cost(size, seen)) break;
    auto state = state_of(model, start, size, seen);
    if (!state) continue;
    descend(*state, model, size, seen);
    if (!best || state->at.cost() < best->at.cost()) best = std::move(state);
  }
  return best;
}

}  // namespace tagcal::internal
