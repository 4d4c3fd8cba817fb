#include "tagcal/estimate/fleet.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/fleet.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The units that take part, in units of the robust scale of each quantity about its median.
struct ScaledUnits {
  VectorXd middle, unit;
  MatrixXd values;  // a column each
  std::vector<MatrixXd> covariances;

  Eigen::Index size() const { return values.cols(); }
  Eigen::Index num_quantities() const { return values.rows(); }
};

struct Normal {
  VectorXd mean;
  MatrixXd scatter;
};

double robust_sigma(const VectorXd& values, double middle) {
  const VectorXd far = (values.array() - middle).abs();
  return median({far.begin(), far.end()}) / 0.6744897502;  // numeric: quartile of a normal variable
}

VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

std::string quantity_name(std::size_t quantity, std::span<const std::string> names) {
  return quantity < names.size() ? names[quantity] : fmt::format("quantity {}", quantity);
}

// The scale of a quantity: the spread of the values or, where that is less, the usual own standard
// deviation.
ScaledUnits scaled(std::span<const UnitValues> units, std::span<const std::string> names) {
  const std::vector<std::size_t> chosen =
      spread_indices(units.size(), std::min(units.size(), policy::kMostUsedUnits));
  const auto n = static_cast<Eigen::Index>(chosen.size());
  const auto p = static_cast<Eigen::Index>(units.front().values.size());
  ScaledUnits all{VectorXd(p), VectorXd(p), MatrixXd(p, n), {}};
  MatrixXd variances(p, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const UnitValues& unit = units[chosen[static_cast<std::size_t>(i)]];
    all.values.col(i) = as_vector(unit.values);
    all.covariances.emplace_back(unit.covariance);
    variances.col(i) = unit.covariance.diagonal();
  }
  for (Eigen::Index j = 0; j < p; ++j) {
    const VectorXd row = all.values.row(j), own = variances.row(j);
    all.middle(j) = median({row.begin(), row.end()});
    all.unit(j) =
        std::max(robust_sigma(row, all.middle(j)), std::sqrt(median({own.begin(), own.end()})));
    if (!(all.unit(j) > 0))
      throw Error(fmt::format("{}: the units neither differ in it nor are uncertain",
                              quantity_name(static_cast<std::size_t>(j), names)));
  }
  const auto scale = all.unit.cwiseInverse().asDiagonal();
  all.values = scale * (all.values.colwise() - all.middle);
  for (MatrixXd& covariance : all.covariances) covariance = scale * covariance * scale;
  return all;
}

// The orthogonalised Gnanadesikan-Kettenring estimate of mean and scatter, own covariances
// included.
Normal ogk(const ScaledUnits& units) {
  const Eigen::Index p = units.num_quantities();
  const auto square_of = [](const VectorXd& v) {
    const double sigma = robust_sigma(v, median({v.begin(), v.end()}));
    return sigma * sigma;
  };
  MatrixXd pairs(p, p);
  for (Eigen::Index j = 0; j < p; ++j) {
    pairs(j, j) = square_of(units.values.row(j));
    for (Eigen::Index k = 0; k < j; ++k)
      pairs(j, k) = (square_of(units.values.row(j) + units.values.row(k)) -
                     square_of(units.values.row(j) - units.values.row(k))) /
                    4;
  }
  const MatrixXd axes = Eigen::SelfAdjointEigenSolver<MatrixXd>(pairs).eigenvectors();
  const MatrixXd turned = axes.transpose() * units.values;
  VectorXd middle(p), variance(p);
  for (Eigen::Index j = 0; j < p; ++j) {
    const VectorXd row = turned.row(j);
    middle(j) = median({row.begin(), row.end()});
    variance(j) = square_of(row);
  }
  const double least = 1e-12 * variance.maxCoeff();  // numeric: a direction without any scatter
  return {axes * middle, axes * variance.cwiseMax(least).asDiagonal() * axes.transpose()};
}

// The factor by which the truncation to p = 0.001 lessens a covariance of p quantities.
double truncation_factor(Eigen::Index p) {
  const auto below = [&](double freedom, double bound) {
    return 1 - chi_square_tail(bound, freedom);
  };
  const auto freedom = static_cast<double>(p);
  const double bound = chi_square_quantile(freedom, policy::kQuantile1e3);
  return below(freedom + 2, bound) / below(freedom, bound);
}

double used_bound(Eigen::Index p) {
  return chi_square_quantile(static_cast<double>(p), policy::kQuantile1e3);
}

// The part of `scatter` that the mean own covariance `own` does not explain. A direction in which
// it explains all keeps the standard deviation of an estimate from n units, from which EM goes on.
MatrixXd less_own(const MatrixXd& scatter, const MatrixXd& own, Eigen::Index n) {
  const Eigen::Index p = scatter.rows();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(own, scatter);
  const VectorXd shares = solver.eigenvalues();  // of the own covariance, of 1
  const double least = std::sqrt(2 / static_cast<double>(n));
  const MatrixXd back = scatter * solver.eigenvectors();  // V' S V = 1, so S = back back'
  return back * (VectorXd::Ones(p) - shares).cwiseMax(least).asDiagonal() * back.transpose();
}

// The moments of the units within the ellipsoid of the robust start.
Normal start_of(const ScaledUnits& units) {
  const Eigen::Index p = units.num_quantities(), n = units.size();
  const Normal rough = ogk(units);
  const MatrixXd centred = units.values.colwise() - rough.mean;
  const VectorXd squares =
      (centred.array() * Eigen::LLT<MatrixXd>(rough.scatter).solve(centred).array())
          .colwise()
          .sum();
  const double unit =
      median({squares.begin(), squares.end()}) / chi_square_quantile(static_cast<double>(p), 0);
  VectorXd sum = VectorXd::Zero(p);
  MatrixXd outer = MatrixXd::Zero(p, p), own = MatrixXd::Zero(p, p);
  double count = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (squares(i) > unit * used_bound(p)) continue;
    sum += centred.col(i);
    outer += centred.col(i) * centred.col(i).transpose();
    own += units.covariances[static_cast<std::size_t>(i)];
    ++count;
  }
  const VectorXd mean = sum / count;
  const MatrixXd scatter = (outer / count - mean * mean.transpose()) / truncation_factor(p);
  return {rough.mean + mean, less_own(scatter, own / count, n)};
}

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
