#include "tagcal/estimate/fleet.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>
#include <numbers>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/fleet/robust_start.hpp"
#include "tagcal/estimate/policy/fleet.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Sums over the units within the ellipsoid, with S = T + C.
struct EmSums {
  MatrixXd precision;           // of S^-1
  MatrixXd outer;               // of y y', y = S^-1 (x - mean)
  VectorXd pull;                // of y
  VectorXd spread_information;  // of 1 / S_jj^2
  std::size_t used = 0;
};

EmSums em_sums(const ScaledUnits& units, const Normal& now) {
  const Eigen::Index p = units.num_quantities();
  EmSums sums{MatrixXd::Zero(p, p), MatrixXd::Zero(p, p), VectorXd::Zero(p), VectorXd::Zero(p)};
  const double bound = used_bound(p);
  const MatrixXd one = MatrixXd::Identity(p, p);
  MatrixXd covariance(p, p), inverse(p, p);
  VectorXd residual(p), y(p);
  Eigen::LLT<MatrixXd> llt(p);
  for (Eigen::Index i = 0; i < units.size(); ++i) {
    covariance = now.scatter + units.covariances[static_cast<std::size_t>(i)];
    llt.compute(covariance);
    residual = units.values.col(i) - now.mean;
    y = llt.solve(residual);
    const double squared = residual.dot(y);
    if (!(squared <= bound)) continue;
    inverse = llt.solve(one);
    sums.precision += inverse;
    sums.outer.noalias() += y * y.transpose();
    sums.pull += y;
    sums.spread_information.array() += covariance.diagonal().array().square().inverse();
    ++sums.used;
  }
  return sums;
}

// Continues until the spreads no longer change; `sums` are those of the last step.
Normal continue_em(const ScaledUnits& units, Normal now, EmSums& sums) {
  constexpr int kMostSteps = 50;       // numeric: the start is consistent already
  constexpr double kSmallStep = 1e-3;  // numeric: of the standard deviation of a spread, below
  const double factor = truncation_factor(units.num_quantities());
  for (int step = 0; step < kMostSteps; ++step) {
    const auto used = static_cast<double>(sums.used);
    const double lessened = factor * (used - 1) / used;  // by the truncation and the own mean
    now.mean += Eigen::LLT<MatrixXd>(sums.precision).solve(sums.pull);
    const MatrixXd change =
        now.scatter * (sums.outer / lessened - sums.precision) * now.scatter / used;
    now.scatter += change;
    const auto scale = (2 / sums.spread_information.array()).sqrt();
    const bool is_small = (change.diagonal().array().abs() < kSmallStep * scale).all();
    sums = em_sums(units, now);
    if (is_small) break;
  }
  return now;
}

// In the units of the values again.
void set_estimate(Population& population, const ScaledUnits& units, const Normal& found,
                  const EmSums& sums) {
  const auto scale = units.unit.asDiagonal();
  const VectorXd centre = units.middle + scale * found.mean;
  population.centre.assign(centre.begin(), centre.end());
  const MatrixXd one = MatrixXd::Identity(centre.size(), centre.size());
  population.centre_covariance = scale * Eigen::LLT<MatrixXd>(sums.precision).solve(one) * scale;
  population.scatter = scale * found.scatter * scale;
  population.num_used = sums.used;
  for (Eigen::Index j = 0; j < centre.size(); ++j) {
    const double variance = found.scatter(j, j);
    const double sigma = std::sqrt(2 / sums.spread_information(j));  // of the variance
    population.spread.push_back(units.unit(j) * std::sqrt(variance));
    population.sigma_spread.push_back(units.unit(j) *
                                      (std::sqrt(variance + sigma) - std::sqrt(variance)));
  }
}

void add_findings(Population& population, std::size_t looked_at,
                  std::span<const std::string> names) {
  const double share =
      1 - static_cast<double>(population.num_used) / static_cast<double>(looked_at);
  if (share > policy::kMixedShare)
    add(population.findings, code::population_mixed,
        fmt::format("{:.0f} % of the units are beyond p = 0.001: they are not one normal "
                    "population, and probabilities do not hold. Look at the histograms, and judge "
                    "lots or makes apart.",
                    100 * share));
  std::string unresolved;
  for (std::size_t j = 0; j < population.spread.size(); ++j)
    if (population.spread[j] < 2 * population.sigma_spread[j])
      unresolved += (unresolved.empty() ? "" : ", ") + quantity_name(j, names);
  if (!unresolved.empty())
    add(population.findings, code::spread_unresolved,
        fmt::format("The units differ in {} by no more than the own uncertainties explain.",
                    unresolved));
}

}  // namespace

void check_units(std::span<const UnitValues> units) {
  const std::size_t p = units.empty() ? 0 : units.front().values.size();
  for (std::size_t i = 0; i < units.size(); ++i) {
    const UnitValues& unit = units[i];
    const auto side = static_cast<Eigen::Index>(p);
    if (p == 0 || unit.values.size() != p || unit.covariance.rows() != side ||
        unit.covariance.cols() != side)
      throw Error(fmt::format(
          "unit {}: must have {} values and a {} x {} covariance, got {} and "
          "{} x {}",
          i, p, p, p, unit.values.size(), unit.covariance.rows(), unit.covariance.cols()));
    if (!as_vector(unit.values).allFinite() || !unit.covariance.allFinite() ||
        (unit.covariance.diagonal().array() < 0).any())
      throw Error(fmt::format("unit {}: must have finite values and variances from 0", i));
  }
}

Population estimate_population(std::span<const UnitValues> units,
                               std::span<const std::string> names) {
  check_units(units);
  Population population;
  population.num_units = units.size();
  const std::size_t p = units.empty() ? 1 : units.front().values.size();
  const std::size_t fewest = policy::kFewestUnits + policy::kFewestUnitsPerQuantity * p;
  if (units.size() < fewest) {
    add(population.findings, code::few_units,
        fmt::format("{} units do not determine the spread of {} quantities: give {} or more.",
                    units.size(), p, fewest));
  } else {
    const ScaledUnits all = scaled(units, names);
    const Normal start = start_of(all);
    EmSums sums = em_sums(all, start);
    const Normal found = continue_em(all, start, sums);
    set_estimate(population, all, found, sums);
    add_findings(population, static_cast<std::size_t>(all.size()), names);
  }
  population.status = judge(population.findings);
  return population;
}

double outlying_p() { return std::erfc(policy::kSignificant / std::numbers::sqrt2) / 2; }

UnitDistance unit_distance(const Population& population, const UnitValues& unit) {
  assert(is_answer(population.status) && unit.values.size() == population.centre.size());
  const MatrixXd covariance = population.scatter + unit.covariance + population.centre_covariance;
  const VectorXd unit_of = covariance.diagonal().cwiseSqrt();
  const auto scale = unit_of.cwiseInverse().asDiagonal();
  const VectorXd residual = scale * (as_vector(unit.values) - as_vector(population.centre));
  const Eigen::LLT<MatrixXd> llt(scale * covariance * scale);
  const double p = static_cast<double>(residual.size());
  UnitDistance distance;
  distance.squared = residual.dot(llt.solve(residual));
  // The error of T is that of the usual S, the inverse mean of S^-1.
  const auto used = static_cast<double>(population.num_used);
  const double share = used * llt.solve(scale * population.centre_covariance * scale).trace() / p;
  const double freedom = (used - 1) / (share * share);
  distance.p_value =
      variance_ratio_tail(distance.squared * (freedom - p + 1) / (freedom * p), p, freedom - p + 1);
  Eigen::Index worst = 0;
  residual.cwiseAbs().maxCoeff(&worst);
  distance.quantity = static_cast<std::size_t>(worst);
  distance.in_sigmas = residual(worst);
  return distance;
}

}  // namespace tagcal
