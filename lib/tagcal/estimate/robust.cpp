#include "tagcal/estimate/robust.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tagcal/estimate/closed_form.hpp"
#include "tagcal/random.hpp"

namespace tagcal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

// 150 samples of four hold one without a wrong corner with p > 0.9999 at 50 % wrong corners.
constexpr int kNumSamples = 150;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The angle between each ray and where the map puts its point.
std::vector<double> angles(const MatrixXd& map, const MatrixXd& points,
                           std::span<const Vector3d> rays) {
  std::vector<double> result(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vector3d mapped = map * points.col(static_cast<Eigen::Index>(i));
    result[i] = std::atan2(rays[i].cross(mapped).norm(), rays[i].dot(mapped));
  }
  return result;
}

std::optional<MatrixXd> map_of(const std::vector<std::size_t>& chosen, const MatrixXd& points,
                               std::span<const Vector3d> rays) {
  MatrixXd some_points(points.rows(), static_cast<Eigen::Index>(chosen.size()));
  std::vector<Vector3d> some_rays;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    some_points.col(static_cast<Eigen::Index>(i)) =
        points.col(static_cast<Eigen::Index>(chosen[i]));
    some_rays.push_back(rays[chosen[i]]);
  }
  return projective_map(some_points, some_rays);
}

// Within 6 robust standard deviations, and what a lens may bend beside it.
std::vector<std::size_t> agreeing(const std::vector<double>& angle, double median_angle) {
  constexpr double kMedianOverSigma = 1.1774;  // of a Rayleigh distribution
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < angle.size(); ++i)
    if (angle[i] <= 6 / kMedianOverSigma * median_angle + 1e-3) chosen.push_back(i);
  return chosen;
}

std::vector<std::size_t> random_sample(Random& random, std::size_t count, std::size_t n) {
  std::vector<std::size_t> chosen;
  while (chosen.size() < count) {
    const std::size_t i = random.index(n);
    if (std::find(chosen.begin(), chosen.end(), i) == chosen.end()) chosen.push_back(i);
  }
  return chosen;
}

}  // namespace

std::optional<Consensus> find_consensus(const MatrixXd& points, std::span<const Vector3d> rays) {
  const std::size_t n = rays.size();
  const std::size_t sample_size = points.rows() == 3 ? 4 : 6;
  if (n < sample_size) return std::nullopt;
  std::vector<double> best;
  double best_median = std::numeric_limits<double>::infinity();
  const auto consider = [&](const std::vector<std::size_t>& chosen) {
    const std::optional<MatrixXd> map = map_of(chosen, points, rays);
    if (!map) return;
    std::vector<double> angle = angles(*map, points, rays);
    const double m = median(angle);
    if (!(m < best_median)) return;
    best_median = m;
    best = std::move(angle);
  };
  std::vector<std::size_t> all(n);
  std::iota(all.begin(), all.end(), 0);
  consider(all);
  // Good data end here: one map fits them all.
  const bool all_agree =
      !best.empty() && best_median < 0.01 && agreeing(best, best_median).size() == n;
  Random random(n);
  for (int i = 0; i < (all_agree ? 0 : kNumSamples); ++i)
    consider(random_sample(random, sample_size, n));
  if (best.empty()) return std::nullopt;
  for (int i = 0; i < 3 && !all_agree; ++i) consider(agreeing(best, best_median));
  Consensus consensus{std::vector<std::uint8_t>(n, 0), best_median};
  for (const std::size_t i : agreeing(best, best_median)) consensus.inlier[i] = 1;
  return consensus;
}

}  // namespace tagcal
