#include "tagcal/estimate/fleet/robust_start.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/policy/fleet.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

double robust_sigma(const VectorXd& values, double middle) {
  const VectorXd far = (values.array() - middle).abs();
  return median({far.begin(), far.end()}) / 0.6744897502;  // numeric: quartile of a normal variable
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

}  // namespace

std::string quantity_name(std::size_t quantity, std::span<const std::string> names) {
  return quantity < names.size() ? names[quantity] : fmt::format("quantity {}", quantity);
}

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

}  // namespace tagcal::internal
