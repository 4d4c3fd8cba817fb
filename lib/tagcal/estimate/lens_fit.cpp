#include "tagcal/estimate/lens_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/lens_from_rays.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Columns of the grids over the image on which the lens is fitted and measured.
// numeric: samples of smooth functions; with twice as many the results move by less than 1 %.
constexpr int kFitColumns = 65, kMeasureColumns = 129;

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

Sightings sightings(const Lens& lens, const std::vector<Vector2d>& pixels) {
  Sightings seen;
  for (const Vector2d& pixel : pixels)
    if (const auto ray = ray_in_camera(lens, pixel)) seen.add(pixel, ray->direction);
  return seen;
}

// Those that a lens of the kind can see.
Sightings visible(const Sightings& all, const LensKind& kind) {
  if (kind.reaches_behind) return all;
  Sightings some;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all.rays[i].z() > policy::kPerspectiveCosine) some.add(all.pixels[i], all.rays[i]);
  return some;
}

std::optional<LensFromRays> fit(const LensFitSource& source, const Model& model,
                                const Sightings& seen) {
  const ImageSize& size = source.camera.image_size;
  const Vector2d centre =
      project(source.camera.lens, Vector3d::UnitZ()).value_or(image_centre(size));
  std::vector<std::vector<double>> starts;
  const Lens& own = source.camera.lens;
  if (&kind_of(own) == &model.kind()) starts.push_back(model.free_values(own));
  return lens_from_rays(model, size, seen, centre, std::move(starts));
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

MatrixXd difference_grid(const ImageGrid& grid, const Lens& source, const Lens& lens) {
  MatrixXd result(grid.rows, grid.columns);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Vector2d pixel = grid.pixel(column, row);
      const auto ray = ray_in_camera(source, pixel);
      result(row, column) = ray ? difference_px(lens, ray->direction, pixel)
                                : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return result;
}

// dq/dp if the new parameters are the old ones and further ones: 1 where both set the same
// parameter of the lens. No value if the fitted lens has other values, or lacks a free parameter.
std::optional<MatrixXd> selection(const LensFitSource& source, const Model& model,
                                  const LensFromRays& state) {
  const Lens& own = source.camera.lens;
  if (&kind_of(own) != &model.kind() || state.free_values != model.free_values(own))
    return std::nullopt;
  MatrixXd result = MatrixXd::Zero(model.num_free(), static_cast<Eigen::Index>(source.free.size()));
  for (std::size_t j = 0; j < source.free.size(); ++j) {
    const std::vector<int>& sets = source.free[j].lens_parameters;
    std::size_t found = 0;
    for (std::size_t i = 0; i < model.free().size(); ++i) {
      if (!std::ranges::includes(sets, model.free()[i].lens_parameters)) continue;
      result(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = 1;
      found += model.free()[i].lens_parameters.size();
    }
    if (found != sets.size()) return std::nullopt;
  }
  return result;
}

// dq/dp in general, see the header; with the columns of J_q scaled.
std::optional<MatrixXd> implicit_derivative(const LensFitSource& source, const LensFromRays& state,
                                            const Sightings& seen) {
  const auto of_source = ray_equations(source.camera.lens, source.free, seen);
  if (!of_source) return std::nullopt;
  const VectorXd scales = column_scales(state.at.jacobian);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> scaled;
  scaled.setThreshold(1e-10);  // numeric: combinations that project alike, to rounding
  scaled.compute(state.at.jacobian * scales.asDiagonal());
  return scales.asDiagonal() * scaled.solve(of_source->jacobian);
}

void carry_covariance(LensFit& result, const LensFitSource& source, const LensFromRays& state,
                      const Sightings& seen) {
  if (source.covariance.size() == 0) return;
  auto by_source = selection(source, *result.model, state);
  if (!by_source) by_source = implicit_derivative(source, state, seen);
  if (!by_source) return;
  const MatrixXd carried = *by_source * source.covariance * by_source->transpose();
  result.covariance = (carried + carried.transpose()) / 2;
  result.sigmas = lens_sigmas({result.model, result.camera, result.covariance});
}

std::string px(double value) { return with_digits(value, 3) + " px"; }

std::optional<std::string> refusal_of(const LensFit& result, const LensFitSource& source,
                                      const LensFitOptions& options) {
  const std::string model(result.model->name());
  const std::string where =
      source.seen.hull().empty() ? "the image" : "the part of the image that had corners";
  if (result.seen.share_without > 0)
    return "model " + model + " has no projection for " + percent(result.seen.share_without) +
           " of " + where;
  const double most =
      options.max_difference_px > 0 ? options.max_difference_px : policy::kGoodCornerPx;
  if (result.seen.max_px > most)
    return "model " + model + " differs from the lens by up to " + px(result.seen.max_px) +
           " over " + where + ", more than " + px(most);
  return std::nullopt;
}

void check(const LensFitSource& source, const Model& model, const LensFitOptions& options) {
  if (!model.kind().is_central || !kind_of(source.camera.lens).is_central)
    throw Error("model: a lens with parallel rays cannot be fitted to another");
  if (!(options.max_difference_px >= 0))
    throw Error("max_difference_px: must be >= 0, got " + short_number(options.max_difference_px));
  if (source.camera.image_size.width < 1 || source.camera.image_size.height < 1)
    throw Error("image_size: must be > 0, the fit needs to know where the image is");
  if (source.covariance.size() == 0) return;
  const auto k = static_cast<Eigen::Index>(source.free.size());
  if (source.covariance.rows() != k || source.covariance.cols() != k)
    throw Error("covariance: must be " + std::to_string(k) + " x " + std::to_string(k) +
                ", of the free parameters of the lens");
}

}  // namespace

LensFit fit_lens(const LensFitSource& source, const Model& model, const LensFitOptions& options) {
  check(source, model, options);
  const ImageSize& size = source.camera.image_size;
  const SeenRegion image = whole_image(size);
  const SeenRegion& region = source.seen.hull().empty() ? image : source.seen;
  const Lens& lens = source.camera.lens;
  LensFit result;
  result.model = &model;
  result.camera.image_size = size;
  result.grid = grid_of(size, ImageGrid{}.columns);
  const Sightings seen =
      visible(sightings(lens, pixels_in(region, grid_of(size, kFitColumns))), model.kind());
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
  return HeldModels(fixed, plain.kind()).named(model).free();
}

}  // namespace tagcal
