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

// The sum of squares that rounding makes.
double rounding_cost(const ImageSize& size, const Sightings& seen) {
  constexpr double kRounding = 1e-14;  // numeric: of a pixel, relative to the width of the image
  return std::pow(kRounding * size.width, 2) * static_cast<double>(seen.size());
}

// The free values of a model, by all sightings.
struct RayProblem {
  using State = std::vector<double>;
  const Model& model;
  const ImageSize& size;
  const Sightings& seen;

  std::optional<RayEquations> at(const State& values) const {
    const auto lens = model.lens(values, size);
    return lens ? ray_equations(*lens, model.free(), seen) : std::nullopt;
  }
  static State stepped(State values, const VectorXd& step) {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] += step[static_cast<Eigen::Index>(k)];
    return values;
  }
};

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
  result.cost = result.residuals.squaredNorm();
  return result;
}

// By a decomposition of J itself: J'J would square the condition number of a rational lens.
std::optional<DampedStep<VectorXd>> RayEquations::step(double damping) const {
  const VectorXd scales = column_scales(jacobian);
  const Eigen::Index n = jacobian.rows(), k = jacobian.cols();
  MatrixXd stacked(n + k, k);
  stacked.topRows(n) = jacobian * scales.asDiagonal();
  stacked.bottomRows(k) = std::sqrt(damping) * MatrixXd::Identity(k, k);
  VectorXd right = VectorXd::Zero(n + k);
  right.head(n) = -residuals;
  const VectorXd step = scales.asDiagonal() * stacked.householderQr().solve(right).eval();
  return DampedStep<VectorXd>{step, cost - (residuals + jacobian * step).squaredNorm()};
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
  const RayProblem problem{model, size, seen};
  // numeric: nothing to gain from a billionth of the sum of squares
  const MinimiseRules rules{.flat = 1e-9, .least_decrease = rounding_cost(size, seen)};
  std::optional<LensFromRays> best;
  for (const std::vector<double>& start : starts) {
    if (best && best->at.cost <= rounding_cost(size, seen)) break;
    auto found = minimise(problem, start, rules);
    if (found && (!best || found->at.cost < best->at.cost))
      best = LensFromRays{std::move(found->state), std::move(found->at)};
  }
  return best;
}

}  // namespace tagcal::internal
