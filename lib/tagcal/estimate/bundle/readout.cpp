#include "tagcal/estimate/bundle/readout.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/policy/shutter_policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The derivative at time 0 of the polynomial that is 0 there and has these values (Lagrange).
Vector6d derivative(const std::vector<double>& times, const std::vector<Vector6d>& values) {
  Vector6d sum = Vector6d::Zero();
  for (std::size_t j = 0; j < times.size(); ++j) {
    double weight = 1 / times[j];
    for (std::size_t m = 0; m < times.size(); ++m)
      if (m != j) weight *= times[m] / (times[m] - times[j]);
    sum += weight * values[j];
  }
  return sum;
}

// The information of a bundle with the readout as its last parameter.
std::optional<BundleInformation> information_with_readout(
    const Bundle& moving, std::span<const std::optional<Vector6d>> velocities) {
  const Lens lens = moving.lens();
  BundleInformation result;
  for (std::size_t v = 0; v < moving.views.size(); ++v) {
    ViewRowTerms rows = moving.row_prior(v);
    rows.sigma = 1e6;  // numeric: weak enough to leave the sums as they are
    ViewEquations equations(moving, v, moving.model->free(), rows);
    MatrixXd gram;
    if (!equations.sums.at(lens, moving.camera_from_target[v], gram)) return std::nullopt;
    Vector6d by_row = Vector6d::Zero();
    if (velocities[v]) by_row = velocities[v]->cwiseQuotient(moving.twist_unit());
    auto view = eliminate_pose(equations.sums.with_velocity(by_row / moving.image_size.height));
    if (!view) return std::nullopt;
    result.views.push_back(std::move(*view));
  }
  const PriorRows rows = prior_of(moving);
  const Index n = rows.by_parameters.cols();
  result.prior = MatrixXd::Zero(n + 1, n + 1);
  result.prior.topLeftCorner(n, n) = rows.by_parameters.transpose() * rows.by_parameters;
  result.prior_gradient = VectorXd::Zero(n + 1);
  result.prior_gradient.head(n) = rows.by_parameters.transpose() * rows.residuals;
  return result;
}

}  // namespace

std::vector<std::optional<Vector6d>> velocities_in_time(std::span<const double> times_s,
                                                        std::span<const Pose> poses) {
  std::vector<std::size_t> order(times_s.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t v) { return times_s[v]; });
  const auto follows = [&](std::size_t at) {  // the one before it
    const double gap = times_s[order[at]] - times_s[order[at - 1]];
    return gap > 0 && gap <= policy::kNeighbourSeconds;
  };
  std::vector<std::optional<Vector6d>> result(order.size());
  for (std::size_t at = 0; at < order.size(); ++at) {
    std::size_t first = at, last = at;  // up to two neighbours on either side
    while (first > 0 && at - first < 2 && follows(first)) --first;
    while (last + 1 < order.size() && last - at < 2 && follows(last + 1)) ++last;
    if (last - first < 2) continue;
    std::vector<double> seconds;
    std::vector<Vector6d> twists;
    for (std::size_t other = first; other <= last; ++other) {
      if (other == at) continue;
      seconds.push_back(times_s[order[other]] - times_s[order[at]]);
      twists.push_back(log_pose(poses[order[other]] * poses[order[at]].inverse()));
    }
    result[order[at]] = derivative(seconds, twists);
  }
  return result;
}

std::optional<Readout> readout_of(const Bundle& solved, std::span<const double> times_s) {
  Bundle moving = solved;
  if (!moving.is_rolling()) {  // its motion was too small to be found
    moving.rolling_m = median_distance_m(solved);
    moving.row_terms.clear();
  }
  const auto velocities = velocities_in_time(times_s, moving.camera_from_target);
  const auto information = information_with_readout(moving, velocities);
  if (!information || information->views.empty()) return std::nullopt;
  const auto covariance = covariance_of(*information, moving.sigma, moving.sigma, 1);
  const auto inverse = exact_inverse(information->total(moving.sigma));
  if (!covariance || !inverse) return std::nullopt;
  const Index last = inverse->cols() - 1;
  Readout readout{-inverse->row(last).dot(information->gradient(moving.sigma)),
                  std::sqrt(covariance->all(last, last)),
                  static_cast<int>(std::ranges::count_if(
                      velocities, [](const auto& velocity) { return velocity.has_value(); }))};
  readout.is_seen = std::abs(readout.seconds) > policy::kSignificant * readout.sigma_s;
  return readout;
}

}  // namespace tagcal::internal
