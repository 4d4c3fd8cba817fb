#include "real_sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal {

std::vector<RealSet> read_sets(const std::vector<std::string>& folders) {
  std::vector<RealSet> sets;
  for (const std::string& folder : folders) {
    DatasetFolder read = read_dataset(folder);
    for (const std::string& warning : read.warnings)
      fmt::print(stderr, "warning: {}: {}\n", folder, warning);
    if (read.dataset.views.empty()) throw Error(folder + ": has no observations");
    const auto path = std::filesystem::weakly_canonical(folder);
    sets.push_back({path.filename().string(), std::move(read.dataset)});
  }
  return sets;
}

Dataset part_of(const Dataset& set, const std::vector<std::size_t>& views) {
  Dataset part{set.image_size, set.boards, {}, {}};
  for (const std::size_t i : views) part.views.push_back(set.views[i]);
  return part;
}

Calibration calibrate_views(const Dataset& set, const std::vector<std::size_t>& views,
                            const std::string& model) {
  CalibrateOptions options;
  options.model = model;
  return calibrate(part_of(set, views), options);
}

bool has_focal_length(const Calibration& calibration) {
  return is_answer(calibration.status) && calibration.camera &&
         !std::holds_alternative<Parallel>(calibration.camera->lens);
}

std::string outcome(const Calibration& calibration) {
  const bool named = is_answer(calibration.status);  // `weak` too
  return named ? calibration.model : std::string(status_name(calibration.status));
}

Claim claim_of(const Calibration& calibration, std::size_t parameter) {
  return {parameters(calibration.camera->lens)[parameter], calibration.sigmas[parameter]};
}

double z_of(const Claim& a, const Claim& b) {
  const double difference = a.value - b.value;
  return difference == 0 ? 0 : difference / std::hypot(a.sd, b.sd);
}

SeenRegion region_of(const Dataset& set) {
  std::vector<Eigen::Vector2d> pixels;
  for (const View& view : set.views)
    for (const Observation& o : view.observations) pixels.push_back(o.pixel);
  return {set.image_size, pixels};
}

std::optional<ProjectionTest> test_projection(const Calibration& a, const Calibration& b,
                                              const SeenRegion& region) {
  const auto d = lens_difference(*a.camera, *b.camera, region.samples(), kInfinitelyFar);
  if (!d || a.projection.empty() || b.projection.empty()) return std::nullopt;
  const ProjectionUncertainty &of_a = a.projection.front(), &of_b = b.projection.front();
  const double printed = std::hypot(of_a.region_px, of_b.region_px);
  if (std::isinf(printed)) return ProjectionTest{d->rms_px / std::numbers::sqrt2, printed, printed};
  double difference = 0, claim = 0;
  int nodes = 0;
  for (int row = 0; row < d->grid.rows; ++row) {
    for (int column = 0; column < d->grid.columns; ++column) {
      const double sd = std::hypot(of_a.sigma_px(row, column), of_b.sigma_px(row, column));
      if (std::isnan(sd) || !region.contains(d->grid.pixel(column, row))) continue;
      const double length = std::hypot(d->u_px(row, column), d->v_px(row, column));
      if (std::isnan(length)) return std::nullopt;
      difference += length * length / 2;
      claim += sd * sd;
      ++nodes;
    }
  }
  if (nodes == 0) return std::nullopt;
  return ProjectionTest{std::sqrt(difference / nodes), std::sqrt(claim / nodes), printed};
}

}  // namespace tagcal
