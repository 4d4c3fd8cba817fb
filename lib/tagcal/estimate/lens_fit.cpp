#include "tagcal/estimate/lens_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Columns of the grids over the image on which the lens is fitted and measured.
// numeric: samples of smooth functions; with twice as many the results move by less than 1 %.
constexpr int kFitColumns = 65, kMeasureColumns = 129;

std::optional<Ray> source_ray(const SourceLens& lens, const Vector2d& pixel) {
  return std::visit([&](const auto& l) { return ray_in_camera(l, pixel); }, lens);
}

std::optional<Vector2d> source_pixel(const SourceLens& lens, const Vector3d& x) {
  return std::visit([&](const auto& l) { return project(l, x); }, lens);
}

SeenRegion whole_image(const ImageSize& size) {
  return SeenRegion(size, ImageGrid{size, 2, 2}.pixels());
}

ImageGrid grid_of(const ImageSize& size, int columns) {
  const double pitch = static_cast<double>(size.width) / (columns - 1);
  return {size, columns, std::max(3, 1 + static_cast<int>(std::lround(size.height / pitch)))};
}

// Nodes of the grid in the region, and points along its border, where differences are largest.
std::vector<Vector2d> pixels_in(const SeenRegion& region, const ImageGrid& grid) {
  std::vector<Vector2d> pixels;
  for (const Vector2d& pixel : grid.pixels())
    if (region.contains(pixel)) pixels.push_back(pixel);
  const double pitch = (grid.pixel(1, 0) - grid.pixel(0, 0)).norm();
  const auto& hull = region.hull();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(edge.norm() / pitch)));
    for (int k = 0; k < parts; ++k)
      pixels.emplace_back(hull[i] + static_cast<double>(k) / parts * edge);
  }
  return pixels;
}

// Pixels of the source and the directions of their rays.
struct Sightings {
  std::vector<Vector2d> pixels;
  std::vector<Vector3d> rays;

  std::size_t size() const { return rays.size(); }
  void add(const Vector2d& pixel, const Vector3d& ray) {
    pixels.push_back(pixel);
    rays.push_back(ray);
  }
};

Sightings sightings(const SourceLens& lens, const std::vector<Vector2d>& pixels) {
  Sightings seen;
  for (const Vector2d& pixel : pixels)
    if (const auto ray = source_ray(lens, pixel)) seen.add(pixel, ray->direction);
  return seen;
}

// Those that a lens of the type can see.
Sightings visible(const Sightings& all, LensType type) {
  if (type != LensType::perspective) return all;
  Sightings some;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all.rays[i].z() > policy::kPerspectiveCosine) some.add(all.pixels[i], all.rays[i]);
  return some;
}

// Residuals (two for each sighting) and their Jacobian by the free parameters.
struct Equations {
  VectorXd residuals;
  MatrixXd jacobian;

  double cost() const { return residuals.squaredNorm(); }
};

// No value if a sighting is outside the domain of the lens.
std::optional<Equations> equations(const Lens& lens, std::span<const FreeParameter> free,
                                   const Sightings& seen) {
  const std::size_t n = seen.size();
  std::vector<Vector2d> pixels(n);
  std::vector<std::uint8_t> valid(n);
  const auto rows = static_cast<Eigen::Index>(2 * n);
  RowMajor jacobian(rows, static_cast<Eigen::Index>(free.size()));
  const ProjectionOutput output{
      pixels, valid, {}, {jacobian.data(), static_cast<std::size_t>(jacobian.size())}};
  if (project_with_jacobians(lens, Pose(), seen.rays, free, output) < n) return std::nullopt;
  Equations result{VectorXd(rows), jacobian};
  for (std::size_t i = 0; i < n; ++i)
    result.residuals.segment<2>(static_cast<Eigen::Index>(2 * i)) = pixels[i] - seen.pixels[i];
  return result;
}

// 1 / norm of each column; 1 for a column of zeros.
VectorXd column_scales(const MatrixXd& jacobian) {
  return jacobian.colwise().norm().transpose().unaryExpr(
      [](double norm) { return norm > 0 ? 1 / norm : 1.0; });
}

struct State {
  std::vector<double> free_values;
  Equations at;
};

std::optional<State> state_of(const Model& model, std::vector<double> values, const ImageSize& size,
                              const Sightings& seen) {
  const auto lens = model.lens(values, size);
  if (!lens) return std::nullopt;
  auto at = equations(*lens, model.free(), seen);
  if (!at) return std::nullopt;
  return State{std::move(values), std::move(*at)};
}

// The sum of squares that rounding makes.
double rounding_cost(const ImageSize& size, const Sightings& seen) {
  constexpr double kRounding = 1e-14;  // numeric: of a pixel, relative to the width of the image
  return std::pow(kRounding * size.width, 2) * static_cast<double>(seen.size());
}

// The step of Levenberg and Marquardt with the damping `lambda` of the scaled columns.
VectorXd damped_step(const Equations& at, const VectorXd& scales, double lambda) {
  const Eigen::Index n = at.jacobian.rows(), k = at.jacobian.cols();
  MatrixXd stacked(n + k, k);
  stacked.topRows(n) = at.jacobian * scales.asDiagonal();
  stacked.bottomRows(k) = std::sqrt(lambda) * MatrixXd::Identity(k, k);
  VectorXd right = VectorXd::Zero(n + k);
  right.head(n) = -at.residuals;
  return scales.asDiagonal() * stacked.householderQr().solve(right).eval();
}

// Descends until a step predicts no decrease that matters. A step out of the domain is one uphill.
void descend(State& state, const Model& model, const ImageSize& size, const Sightings& seen) {
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

// (X / Z, Y / Z), or theta (X, Y) / |(X, Y)| for a fisheye: the image without distortion.
Vector2d undistorted(const Vector3d& ray, LensType type) {
  const Vector2d xy = ray.head<2>();
  if (type == LensType::perspective) return xy / ray.z();
  const double sine = xy.norm();
  return sine > 0 ? Vector2d(std::atan2(sine, ray.z()) / sine * xy) : xy;
}

// The power of s that a radial coefficient stands at, negative for those of the denominator; 0 for
// other parameters.
int radial_power(const FreeParameter& free, LensType type) {
  if (free.kind() != ParameterKind::radial) return 0;
  const int number = free.name[1] - '0';
  return type == LensType::perspective && number > 3 ? 3 - number : number;
}

// f and the coefficients at `powers` (radial_power) that solve m D = f b N by linear least squares,
// with the pixel m from the centre, the undistorted point b, s = |b|^2, and L = N / D of lens.hpp:
// f at power 0, f k for the numerator, k for the denominator.
VectorXd solve_radial(const Sightings& seen, LensType type, const Vector2d& centre,
                      const std::vector<int>& powers) {
  MatrixXd a(static_cast<Eigen::Index>(2 * seen.size()), static_cast<Eigen::Index>(powers.size()));
  VectorXd m(a.rows());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Vector2d b = undistorted(seen.rays[i], type), from_centre = seen.pixels[i] - centre;
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
// the tangential ones are zero.
std::vector<double> linear_start(const Model& model, const Sightings& seen, const Vector2d& centre,
                                 bool radial) {
  std::vector<int> powers = {0};
  for (const FreeParameter& free : model.free())
    if (const int power = radial_power(free, model.lens_type()); radial && power != 0)
      powers.push_back(power);
  const VectorXd solved = solve_radial(seen, model.lens_type(), centre, powers);
  std::vector<double> values;
  for (const FreeParameter& free : model.free()) {
    const int power = radial_power(free, model.lens_type());
    const auto at = std::ranges::find(powers, power);
    const bool is_focal = free.kind() == ParameterKind::focal_length;
    if (free.kind() == ParameterKind::principal_point)
      values.push_back(free.lens_parameters.front() == kCx ? centre.x() : centre.y());
    else if (at == powers.end() || (power == 0 && !is_focal))
      values.push_back(0);
    else
      values.push_back(solved[at - powers.begin()] / (power > 0 ? solved[0] : 1));
  }
  return values;
}

LensType type_of(const Lens& lens) { return static_cast<LensType>(lens.index()); }

// The state of least cost of those reached from the source's own parameters, if its lens is of the
// model's type, from the linear start, and from a lens without distortion. No value if none of
// these sees all.
std::optional<State> fit(const LensFitSource& source, const Model& model, const Sightings& seen) {
  const ImageSize& size = source.camera.image_size;
  const Vector2d centre =
      source_pixel(source.camera.lens, Vector3d::UnitZ()).value_or(image_centre(size));
  std::vector<std::vector<double>> starts = {linear_start(model, seen, centre, true),
                                             linear_start(model, seen, centre, false)};
  const auto* own = std::get_if<Lens>(&source.camera.lens);
  if (own && type_of(*own) == model.lens_type())
    starts.insert(starts.begin(), model.free_values(*own));
  std::optional<State> best;
  for (const std::vector<double>& start : starts) {
    if (best && best->at.cost() <= rounding_cost(size, seen)) break;
    auto state = state_of(model, start, size, seen);
    if (!state) continue;
    descend(*state, model, size, seen);
    if (!best || state->at.cost() < best->at.cost()) best = std::move(state);
  }
  return best;
}

double difference_px(const Lens& lens, const Vector3d& ray, const Vector2d& pixel) {
  const auto projected = project(lens, ray);
  return projected ? (*projected - pixel).norm() : std::numeric_limits<double>::infinity();
}

LensFitDifference difference_over(const Sightings& seen, const Lens& lens) {
  LensFitDifference result;
  double sum = 0, without = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double px = difference_px(lens, seen.rays[i], seen.pixels[i]);
    if (!std::isfinite(px)) {
      ++without;
      continue;
    }
    result.max_px = std::max(result.max_px, px);
    sum += px * px;
  }
  const double count = static_cast<double>(seen.size());
  if (count > without) result.rms_px = std::sqrt(sum / (count - without));
  if (count > 0) result.share_without = without / count;
  return result;
}

MatrixXd difference_grid(const ImageGrid& grid, const SourceLens& source, const Lens& lens) {
  MatrixXd result(grid.rows, grid.columns);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Vector2d pixel = grid.pixel(column, row);
      const auto ray = source_ray(source, pixel);
      result(row, column) = ray ? difference_px(lens, ray->direction, pixel)
                                : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return result;
}

// See the header: dq/dp, with the columns of J_q scaled.
void carry_covariance(LensFit& result, const LensFitSource& source, const State& state,
                      const Sightings& seen) {
  if (source.covariance.size() == 0) return;
  const auto of_source = equations(std::get<Lens>(source.camera.lens), source.free, seen);
  if (!of_source) return;
  const VectorXd scales = column_scales(state.at.jacobian);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> scaled;
  scaled.setThreshold(1e-10);  // numeric: combinations that project alike, to rounding
  scaled.compute(state.at.jacobian * scales.asDiagonal());
  const MatrixXd by_source = scales.asDiagonal() * scaled.solve(of_source->jacobian);
  const MatrixXd carried = by_source * source.covariance * by_source.transpose();
  result.covariance = (carried + carried.transpose()) / 2;
  result.sigmas.assign(parameters(result.camera.lens).size(), 0.0);
  for (std::size_t i = 0; i < result.model->free().size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    for (const int k : result.model->free()[i].lens_parameters)
      result.sigmas[static_cast<std::size_t>(k)] = std::sqrt(result.covariance(at, at));
  }
}

std::string px(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3g px", value);
  return text;
}

std::optional<std::string> refusal_of(const LensFit& result, const LensFitSource& source,
                                      const LensFitOptions& options) {
  const std::string model(result.model->name());
  const std::string where =
      source.seen.hull().empty() ? "the image" : "the part of the image that had corners";
  if (result.seen.share_without > 0)
    return "model " + model + " has no projection for " + percent(result.seen.share_without) +
           " of " + where;
  const double most = options.max_difference_px > 0 ? options.max_difference_px
                                                    : policy::kLargestLensFitDifferencePx;
  if (result.seen.max_px > most)
    return "model " + model + " differs from the lens by up to " + px(result.seen.max_px) +
           " over " + where + ", more than " + px(most);
  return std::nullopt;
}

void check(const LensFitSource& source, const Model& model, const LensFitOptions& options) {
  const auto* own = std::get_if<Lens>(&source.camera.lens);
  if (model.lens_type() == LensType::parallel || (own && type_of(*own) == LensType::parallel))
    throw Error("model: a lens with parallel rays cannot be fitted to another");
  if (!(options.max_difference_px >= 0))
    throw Error("max_difference_px: must be >= 0, got " +
                std::to_string(options.max_difference_px));
  if (source.camera.image_size.width < 1 || source.camera.image_size.height < 1)
    throw Error("image_size: must be > 0, the fit needs to know where the image is");
  if (source.covariance.size() == 0) return;
  const auto k = static_cast<Eigen::Index>(source.free.size());
  if (!own || source.covariance.rows() != k || source.covariance.cols() != k)
    throw Error("covariance: must be " + std::to_string(k) + " x " + std::to_string(k) +
                ", of the free parameters of one of tagcal's lenses");
}

}  // namespace

LensFit fit_lens(const LensFitSource& source, const Model& model, const LensFitOptions& options) {
  check(source, model, options);
  const ImageSize& size = source.camera.image_size;
  const SeenRegion image = whole_image(size);
  const SeenRegion& region = source.seen.hull().empty() ? image : source.seen;
  const SourceLens& lens = source.camera.lens;
  LensFit result;
  result.model = &model;
  result.camera.image_size = size;
  result.grid = grid_of(size, ImageGrid{}.columns);
  const Sightings seen =
      visible(sightings(lens, pixels_in(region, grid_of(size, kFitColumns))), model.lens_type());
  const auto state = 2 * static_cast<int>(seen.size()) >= std::max(1, model.num_free())
                         ? fit(source, model, seen)
                         : std::nullopt;
  if (!state) {
    result.camera.lens = pinhole(1, 1, 0, 0);
    result.refusal = "no lens of model " + std::string(model.name()) + " sees what the lens sees";
    return result;
  }
  result.camera.lens = *model.lens(state->free_values, size);
  const ImageGrid fine = grid_of(size, kMeasureColumns);
  result.seen = difference_over(sightings(lens, pixels_in(region, fine)), result.camera.lens);
  result.image = difference_over(sightings(lens, pixels_in(image, fine)), result.camera.lens);
  result.difference_px = difference_grid(result.grid, lens, result.camera.lens);
  carry_covariance(result, source, *state, seen);
  result.refusal = refusal_of(result, source, options);
  return result;
}

std::vector<FreeParameter> free_parameters(std::string_view model,
                                           const std::map<std::string, double>& fixed) {
  const Model& plain = Model::named(model);
  if (fixed.empty()) return plain.free();
  return HeldModels(fixed, plain.lens_type()).named(model).free();
}

LensFitSource lens_fit_source(const Calibration& calibration) {
  const Camera& camera = *calibration.camera;
  LensFitSource source{{camera.lens, camera.image_size}, {}, {}, calibration.seen};
  if (calibration.covariance.size() == 0) return source;
  source.free = free_parameters(calibration.model, calibration.fixed);
  source.covariance = calibration.covariance;
  return source;
}

}  // namespace tagcal
