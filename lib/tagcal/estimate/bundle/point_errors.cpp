#include "tagcal/estimate/bundle/point_errors.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <map>

#include "tagcal/estimate/bundle/shape_columns.hpp"
#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// The points of a target, in the order in which the views show them.
class PointIndex {
 public:
  explicit PointIndex(const Bundle& bundle) {
    for (const ViewProblem& view : bundle.views)
      for (const Correspondence& c : view.correspondences)
        index_.try_emplace(key(c.point), std::ssize(index_));
  }
  Index size() const { return std::ssize(index_); }
  Index of(const Vector3d& point) const { return index_.at(key(point)); }

 private:
  using Key = std::array<double, 3>;
  static Key key(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }
  std::map<Key, Index> index_;
};

// The rows of a view: whitened residuals and their Jacobians by what the view has alone (pose and
// row terms), by the parameters of lens and board, and each by its own point (target frame).
struct RowsByPoint {
  VectorXd residuals;
  MatrixXd by_own;
  VectorXd own_prior;  // information of the prior of what the view has alone
  MatrixXd by_parameters;
  Rows3 by_point;
};

// The Jacobian by the row terms of a view (ViewRowTerms).
MatrixXd by_row_terms(const ViewProblem& view, const ViewRowTerms& terms,
                      const RowMajor6& by_pose) {
  MatrixXd rows(by_pose.rows(), terms.count());
  for (Index i = 0; i < rows.rows() / 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double y = view.correspondences[k].pixel.y() - terms.middle_row;
    if (terms.velocities)
      rows.middleRows<2>(2 * i) = y * by_pose.middleRows<2>(2 * i) * *terms.velocities;
    else if (view.whitening.empty())
      rows.middleRows<2>(2 * i) = y * Matrix2::Identity();
    else
      rows.middleRows<2>(2 * i) = y * view.whitening[k];
  }
  return rows;
}

std::optional<RowsByPoint> rows_of(const Bundle& bundle, std::size_t v, const Lens& lens) {
  ViewProblem buffer;
  const Pose& pose = bundle.camera_from_target[v];
  auto r = reprojection(bundle.corrected(v, buffer), lens, bundle.model->free(), pose);
  if (!r) return std::nullopt;
  const ViewRowTerms terms = bundle.row_prior(v);
  const Index num_rows = r->residuals.size(), k = bundle.model->num_free(), m = terms.count();
  RowsByPoint rows{std::move(r->residuals), MatrixXd(num_rows, 6 + m), VectorXd::Zero(6 + m),
                   MatrixXd(num_rows, bundle.num_parameters()),
                   r->by_pose.rightCols<3>() * pose.rotation_matrix()};
  rows.by_own << r->by_pose, by_row_terms(bundle.views[v], terms, r->by_pose);
  if (m > 0) rows.own_prior.tail(m).setConstant(1 / (terms.sigma * terms.sigma));
  rows.by_parameters.leftCols(k) = r->by_parameters;
  if (!bundle.board) return rows;
  const ViewArrays flat(bundle.views[v]);
  const BoardShapes shapes = bundle.board->shapes(flat.view().points);
  set_shape_columns(shapes.view(), pose, r->by_pose, k, rows.by_parameters);
  return rows;
}

// Sums over the views.
struct PointSums {
  Eigen::Matrix3Xd gradient;                 // D'r, a column each point
  std::vector<Eigen::Matrix3d> information;  // D'D of each point
  MatrixXd cross;                            // B'QD, three columns each point
  MatrixXd alone;                            // the same of single views, squared and summed (lower)
  double absorbed = 0;                       // of the trace of D'D, by poses and row terms
  double squares = 0, freedom = 0;           // of the residuals

  PointSums(Index num_points, Index num_parameters)
      : gradient(Eigen::Matrix3Xd::Zero(3, num_points)),
        information(static_cast<std::size_t>(num_points), Eigen::Matrix3d::Zero()),
        cross(MatrixXd::Zero(num_parameters, 3 * num_points)),
        alone(MatrixXd::Zero(num_parameters, num_parameters)),
        freedom(-static_cast<double>(num_parameters)) {}

  // The part of the variance of B'Qr, for displacements of variance 1, that comes from products of
  // different views.
  MatrixXd common() const {
    MatrixXd sum = -MatrixXd(alone.selfadjointView<Eigen::Lower>());
    sum.noalias() += cross * cross.transpose();
    return sum;
  }

  // False if the view does not determine its pose.
  bool add(const RowsByPoint& rows, const ViewProblem& view, const PointIndex& points) {
    MatrixXd own = rows.by_own.transpose() * rows.by_own;
    own.diagonal() += rows.own_prior;
    const Eigen::LLT<MatrixXd> llt(own);
    if (llt.info() != Eigen::Success) return false;
    const MatrixXd half = llt.matrixL().solve(rows.by_own.transpose());  // |half x|^2 is absorbed
    const MatrixXd rest = rows.by_parameters - half.transpose() * (half * rows.by_parameters);
    MatrixXd of_view(rest.cols(), 3 * static_cast<Index>(view.correspondences.size()));
    for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
      const auto k = static_cast<Index>(i);
      const Index p = points.of(view.correspondences[i].point);
      const Eigen::Matrix<double, 2, 3> d = rows.by_point.middleRows<2>(2 * k);
      gradient.col(p) += d.transpose() * rows.residuals.segment<2>(2 * k);
      information[static_cast<std::size_t>(p)] += d.transpose() * d;
      absorbed += half.middleCols<2>(2 * k).lazyProduct(d).squaredNorm();
      of_view.middleCols<3>(3 * k) = rest.middleRows<2>(2 * k).transpose().lazyProduct(d);
      cross.middleCols<3>(3 * p) += of_view.middleCols<3>(3 * k);
    }
    alone.selfadjointView<Eigen::Lower>().rankUpdate(of_view);
    squares += rows.residuals.squaredNorm();
    freedom += static_cast<double>(rows.residuals.size() - 6);
    return true;
  }
};

// tau^2, or 0 if it is not significant. What poses, row terms, lens and board absorb, they take of
// all displacements alike: tr K^2 is within 1 % then on real data, and K itself would cost far
// more.
double variance_of_displacements(const PointSums& sums, double absorbed) {
  if (!(sums.freedom > 0)) return 0;
  const double noise = sums.squares / sums.freedom;
  double trace = 0, square = 0;
  for (const Eigen::Matrix3d& of_point : sums.information) {
    trace += of_point.trace();
    square += of_point.squaredNorm();
  }
  const double left = trace > 0 ? 1 - absorbed / trace : 0;
  const double excess = sums.gradient.squaredNorm() - noise * left * trace;
  const bool is_seen =
      left > 0 && excess > policy::kSignificant * noise * std::sqrt(2 * left * square);
  return is_seen ? excess / (left * square) : 0;
}

}  // namespace

std::optional<MatrixXd> covariance_of_point_errors(const Bundle& bundle,
                                                   const BundleInformation& information,
                                                   double sigma) {
  const PointIndex points(bundle);
  PointSums sums(points.size(), bundle.num_parameters());
  const Lens lens = bundle.lens();
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto rows = rows_of(bundle, v, lens);
    if (!rows || !sums.add(*rows, bundle.views[v], points)) return std::nullopt;
  }
  const auto inverse = exact_inverse(information.total(sigma));
  if (!inverse) return std::nullopt;
  const double by_parameters = sums.cross.cwiseProduct(*inverse * sums.cross).sum();
  const double variance =
      variance_of_displacements(sums, sums.absorbed + by_parameters / (sigma * sigma));
  if (!(variance > 0)) return std::nullopt;
  // In coordinates in which H is I.
  const MatrixXd root = Eigen::LLT<MatrixXd>(*inverse).matrixL();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(root.transpose() * sums.common() * root);
  const MatrixXd axes = root * eigen.eigenvectors();
  return MatrixXd(variance / std::pow(sigma, 4) * axes *
                  eigen.eigenvalues().cwiseMax(0).asDiagonal() * axes.transpose());
}

}  // namespace tagcal::internal
