#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/fleet.hpp"
#include "tagcal/estimate/fleet/robust_start.hpp"
#include "tagcal/estimate/policy/fleet.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

// A row each, with a one before the centred covariates, which are divided by `range`.
struct Design {
  Eigen::MatrixXd rows;
  Eigen::VectorXd range;
};

// No value if the covariates do not determine slopes.
std::optional<Design> design_of(const MatrixX& covariates) {
  constexpr double kLeastPart = 1e-9;  // numeric: covariates that differ in rounding only
  const Eigen::Index n = covariates.rows(), q = covariates.cols();
  if (n < q + 1) return std::nullopt;
  Design design{Eigen::MatrixXd::Ones(n, q + 1), Eigen::VectorXd(q)};
  for (Eigen::Index j = 0; j < q; ++j) {
    const Eigen::VectorXd centred = covariates.col(j).array() - covariates.col(j).mean();
    design.range(j) = centred.cwiseAbs().maxCoeff();
    if (!(design.range(j) > kLeastPart * covariates.col(j).cwiseAbs().maxCoeff()))
      return std::nullopt;
    design.rows.col(j + 1) = centred / design.range(j);
  }
  const Eigen::MatrixXd square = design.rows.transpose() * design.rows;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(square, Eigen::EigenvaluesOnly);
  if (!(solver.eigenvalues().minCoeff() > kLeastPart * square.trace())) return std::nullopt;
  return design;
}

// [1, z_1 1, z_2 1, ..] of a calibration, for the constant and then the slopes of each covariate.
Eigen::MatrixXd by_coefficients(const Design& design, Eigen::Index k, Eigen::Index p) {
  const Eigen::Index terms = design.rows.cols();
  Eigen::MatrixXd x(p, p * terms);
  for (Eigen::Index t = 0; t < terms; ++t)
    x.middleCols(t * p, p) = design.rows(k, t) * Eigen::MatrixXd::Identity(p, p);
  return x;
}

// Both sides of the calibration's equations, divided by the Cholesky factor of its covariance.
struct Whitened {
  Eigen::MatrixXd x;
  Eigen::VectorXd y;
};

std::vector<Whitened> whitened(std::span<const UnitValues> calibrations, const Design& design) {
  std::vector<Whitened> all;
  for (std::size_t k = 0; k < calibrations.size(); ++k) {
    const Eigen::VectorXd values = as_vector(calibrations[k].values);
    const Eigen::LLT<Eigen::MatrixXd> llt(calibrations[k].covariance);
    if (llt.info() != Eigen::Success)
      throw Error(fmt::format("calibration {}: its covariance must be positive definite", k));
    const Eigen::MatrixXd x = by_coefficients(design, static_cast<Eigen::Index>(k), values.size());
    all.push_back({llt.matrixL().solve(x), llt.matrixL().solve(values)});
  }
  return all;
}

Trend trend_of(const Eigen::VectorXd& coefficients, const Eigen::MatrixXd& covariance,
               const Design& design, Eigen::Index p) {
  const Eigen::Index q = design.range.size();
  Trend trend{MatrixX(p, q), MatrixX(p, q), {}, {}};
  for (Eigen::Index j = 0; j < q; ++j) {
    const Eigen::VectorXd slopes = coefficients.segment((j + 1) * p, p);
    const Eigen::MatrixXd block = covariance.block((j + 1) * p, (j + 1) * p, p, p);
    trend.slopes.col(j) = slopes / design.range(j);
    trend.sigmas.col(j) = block.diagonal().cwiseSqrt() / design.range(j);
    trend.covariances.emplace_back(block / (design.range(j) * design.range(j)));
    trend.chi_square.push_back(slopes.dot(Eigen::LLT<Eigen::MatrixXd>(block).solve(slopes)));
  }
  return trend;
}

}  // namespace

std::optional<Trend> estimate_trend(std::span<const UnitValues> calibrations,
                                    const MatrixX& covariates) {
  check_units(calibrations);
  if (covariates.rows() != static_cast<Eigen::Index>(calibrations.size()) ||
      !covariates.allFinite())
    throw Error(fmt::format("covariates: must be finite, a row for each of {} calibrations",
                            calibrations.size()));
  const std::optional<Design> design = design_of(covariates);
  if (!design) return std::nullopt;
  const auto p = static_cast<Eigen::Index>(calibrations.front().values.size());
  const std::vector<Whitened> equations = whitened(calibrations, *design);
  const Eigen::Index size = p * design->rows.cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  for (const Whitened& e : equations) {
    normal += e.x.transpose() * e.x;
    right += e.x.transpose() * e.y;
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(normal);
  const Eigen::VectorXd coefficients = llt.solve(right);
  Trend trend =
      trend_of(coefficients, llt.solve(Eigen::MatrixXd::Identity(size, size)), *design, p);
  for (const Whitened& e : equations) trend.scatter += (e.y - e.x * coefficients).squaredNorm();
  trend.scatter_freedom = static_cast<int>(p * (covariates.rows() - covariates.cols() - 1));
  return trend;
}

double repeat_inflation(std::span<const Trend> trends) {
  std::vector<double> ratios;
  for (const Trend& trend : trends)
    if (trend.scatter_freedom > 0)
      ratios.push_back(trend.scatter / chi_square_quantile(trend.scatter_freedom, 0));
  return ratios.size() < policy::kFewestTrends ? 1 : std::max(1.0, median(std::move(ratios)));
}

std::optional<double> trend_p_value(const Trend& trend, std::optional<std::size_t> covariate,
                                    double inflation) {
  if (!covariate && trend.scatter_freedom == 0) return std::nullopt;
  const double freedom = covariate ? static_cast<double>(trend.slopes.rows())
                                   : static_cast<double>(trend.scatter_freedom);
  return chi_square_tail((covariate ? trend.chi_square.at(*covariate) : trend.scatter) / inflation,
                         freedom);
}

}  // namespace tagcal
