#include "tagcal/estimate/camera_check/change_test.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "tagcal/estimate/policy/check_policy.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// From the solution of the free fit to the known cameras and a flat board.
VectorXd step_to_known(const FreeFit& fit, const RigLayout& layout, const KnownRig& known) {
  const RigState& state = fit.state;
  const Bundle& first = state.cameras.front();
  VectorXd step = VectorXd::Zero(layout.size + first.num_shapes());
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (const auto at = layout.pose[c])
      step.segment<6>(*at) =
          minus(known.cameras[c].camera_from_rig, state.poses.camera_from_rig[c]);
    const Bundle& bundle = state.cameras[c];
    const auto k = std::ssize(bundle.free_values);
    step.segment(layout.lens[c], k) =
        bundle.known_lens->values - VectorXd::Map(bundle.free_values.data(), k);
  }
  if (first.num_shapes() > 0) step.tail(first.num_shapes()) = -first.shape;
  return step;
}

// The covariance of places, lenses and the shape of the board before the pictures.
MatrixXd known_covariance(const FreeFit& fit, const RigLayout& layout, const KnownRig& known) {
  const RigState& state = fit.state;
  const Bundle& first = state.cameras.front();
  MatrixXd of_rig = MatrixXd::Zero(layout.size, layout.size);
  std::vector<std::pair<Index, Index>> places;  // in the layout, and in the known rig
  const auto add = [&](Index at, Index from, Index count) {
    for (Index i = 0; i < count; ++i) places.emplace_back(at + i, from + i);
  };
  for (std::size_t c = 0; c < state.cameras.size() && known.covariance.size() > 0; ++c) {
    if (layout.pose[c]) add(*layout.pose[c], 6 * static_cast<Index>(c), 6);
    if (state.cameras[c].model == known.cameras[c].camera.model)
      add(layout.lens[c], known.first_of_lens(c), state.cameras[c].model->num_free());
  }
  for (const auto& [i, from_i] : places)
    for (const auto& [j, from_j] : places) of_rig(i, j) = known.covariance(from_i, from_j);
  add_scale(state, layout, 1, of_rig);  // another print of the board, or the same one
  const Index n = layout.size, shapes = first.num_shapes();
  MatrixXd all = MatrixXd::Zero(n + shapes, n + shapes);
  all.topLeftCorner(n, n) = of_rig;
  if (shapes > 0)
    all.bottomRightCorner(shapes, shapes) =
        first.board->prior_sigma.cwiseAbs2().asDiagonal().toDenseMatrix();
  return all;
}

}  // namespace

ChangeTest::ChangeTest(const FreeFit& fit, const KnownRig& known,
                       const BundleInformation& information)
    : freedom_(fit.freedom) {
  const RigLayout layout(fit.state, fit.connected);
  const auto spread = covariance_of(information, 1, 1, overdispersion_of_rig(fit.state));
  const double overdispersion = spread ? spread->overdispersion : 1;
  const MatrixXd data = information.data();
  VectorXd gradient = VectorXd::Zero(data.rows());
  for (const ViewInformation& view : information.views) gradient += view.gradient;
  gradient += data * step_to_known(fit, layout, known);
  // In units of the roots of the diagonal, so that parameters of any scale count alike.
  const VectorXd unit = data.diagonal().cwiseMax(1e-300).cwiseSqrt();  // numeric: no zero
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit.cwiseInverse().asDiagonal() * data *
                                                      unit.cwiseInverse().asDiagonal());
  constexpr double kRank = 1e-11;  // numeric: a few roundings of the sums
  const Index dropped =
      (eigen.eigenvalues().array() <= kRank * eigen.eigenvalues().tail(1)[0]).count();
  const Index rank = data.rows() - dropped;
  const VectorXd roots = eigen.eigenvalues().tail(rank).cwiseSqrt();
  const MatrixXd directions = eigen.eigenvectors().rightCols(rank);
  // A change d of the cameras moves the gradient at the known ones by -S d.
  const MatrixXd by_change = roots.asDiagonal() * directions.transpose() * unit.asDiagonal();
  const VectorXd difference = -(roots.cwiseInverse().asDiagonal() * directions.transpose() *
                                unit.cwiseInverse().asDiagonal() * gradient);
  const MatrixXd covariance =
      overdispersion * MatrixXd::Identity(rank, rank) +
      by_change * known_covariance(fit, layout, known) * by_change.transpose();
  const Eigen::LLT<MatrixXd> llt(covariance);
  by_change_ = llt.matrixL().solve(by_change);
  difference_ = llt.matrixL().solve(difference);
  all_ = explained_by(MatrixXd::Identity(data.rows(), layout.size));
}

ChangeTest::Explained ChangeTest::explained_by(const MatrixXd& basis) const {
  const MatrixXd rows = by_change_ * basis;
  // Columns of one length: what the pictures do not determine has no part in the rank.
  const VectorXd unit = rows.colwise().norm().cwiseMax(1e-300);  // numeric: no zero
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(1e-8);  // numeric: the root of the rounding of the products
  const MatrixXd scaled = rows * unit.cwiseInverse().asDiagonal();
  qr.compute(scaled);
  Explained explained;
  explained.freedom = qr.rank();
  const VectorXd turned = qr.householderQ().transpose() * difference_;
  explained.square = turned.head(qr.rank()).squaredNorm();
  explained.coefficients = unit.cwiseInverse().asDiagonal() * qr.solve(difference_).eval();
  explained.covariance =
      unit.cwiseInverse().asDiagonal() *
      MatrixXd((scaled.transpose() * scaled).completeOrthogonalDecomposition().pseudoInverse()) *
      unit.cwiseInverse().asDiagonal();
  return explained;
}

double ChangeTest::score(double square, Index freedom) const {
  if (freedom <= 0) return -std::numeric_limits<double>::infinity();
  const auto k = static_cast<double>(freedom);
  return variance_ratio_score(square / k, k, freedom_);
}

double ChangeTest::rest(const Explained& part) const {
  return score(std::max(0.0, all_.square - part.square), all_.freedom - part.freedom);
}

VectorXd ChangeTest::least_shown(const MatrixXd& basis, const MatrixXd& rows) const {
  const MatrixXd shown = by_change_ * basis;
  MatrixXd information = shown.transpose() * shown;
  const VectorXd unit = rows.colwise().norm().cwiseMax(1e-300);  // numeric: no zero
  const auto scaled = [&](const MatrixXd& m) {
    return MatrixXd(unit.cwiseInverse().asDiagonal() * m * unit.cwiseInverse().asDiagonal());
  };
  information = scaled(information);
  // So little that only what does not show at all gets its size from it.
  information.diagonal().array() += 1e-12 * information.trace() + 1e-300;  // numeric: see above
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(scaled(rows.transpose() * rows),
                                                                 information);
  const double needed = noncentrality(static_cast<double>(std::max<Index>(1, all_.freedom)),
                                      policy::kCheckQuantile, policy::kCheckQuantile);
  // Eigenvectors v have v' F v = 1.
  return std::sqrt(needed) * unit.cwiseInverse().asDiagonal() * eigen.eigenvectors().rightCols(1);
}

}  // namespace tagcal::internal
