#include "tagcal/estimate/pose/view_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Unpacks the upper triangle of [J | r]'[J | r], row by row.
template <int N>
void unpack(const double* sums, NormalEquations<N>& equations) {
  for (int i = 0; i < N; ++i) {
    for (int j = i; j < N; ++j) equations.information(i, j) = *sums++;
    equations.gradient[i] = *sums++;
  }
  equations.cost = *sums;
}

void set_state(const ViewState& state, ViewJob& job) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(job.rotation) = state.rotation;
  Eigen::Map<Eigen::Vector3d>(job.translation) = state.translation;
}

void set_view(const ViewPoints& view, SumJob& job) {
  job.num_points = view.size();
  job.points = view.points.data()->data();
  job.pixels = view.pixels.data()->data();
  job.whitening = view.whitening.empty() ? nullptr : view.whitening.data()->data();
}

}  // namespace

ViewState state_of(const Pose& camera_from_target, double focal_px) {
  return {camera_from_target.rotation_matrix(), camera_from_target.translation(), focal_px};
}

Pose pose_of(const ViewState& state) {
  return {Eigen::Quaterniond(state.rotation).normalized(), state.translation};
}

ViewResiduals::ViewResiduals(const Lens& lens, const ViewPoints& view)
    : view_(view),
      kind_(set_lens(lens, 0, job_)),
      projected_(view.size()),
      valid_(view.size()),
      squares_(view.size()) {
  job_.num_points = view.size();
  job_.points = view.points.data()->data();
  job_.pixels = projected_.data()->data();
  job_.valid = valid_.data();
}

std::span<const double> ViewResiduals::at(const ViewState& state) {
  set_state(state, job_);
  if (state.focal_px > 0) job_.parameters[kFx] = job_.parameters[kFy] = state.focal_px;
  fastest_kernels().pixels[kind_](job_);
  for (std::size_t i = 0; i < view_.size(); ++i) {
    Eigen::Vector2d residual = projected_[i] - view_.pixels[i];
    if (!view_.whitening.empty()) residual = view_.whitening[i] * residual;
    squares_[i] = valid_[i] ? residual.squaredNorm() : std::numeric_limits<double>::infinity();
  }
  return squares_;
}

ViewSums::ViewSums(const Lens& lens, const ViewPoints& view) : kind_(set_lens(lens, 0, job_)) {
  set_view(view, job_);
}

bool ViewSums::at(const ViewState& state, NormalEquations<6>& equations) {
  double sums[28];
  set_state(state, job_);
  job_.sums = sums;
  if (!fastest_kernels().sums_pose[kind_](job_)) return false;
  unpack(sums, equations);
  return std::isfinite(equations.cost);
}

bool ViewSums::at(const ViewState& state, NormalEquations<7>& equations) {
  double sums[36];
  set_state(state, job_);
  job_.parameters[kFx] = job_.parameters[kFy] = state.focal_px;
  job_.sums = sums;
  if (!fastest_kernels().sums_pose_and_focal[kind_](job_)) return false;
  unpack(sums, equations);
  return std::isfinite(equations.cost);
}

ParameterSums::ParameterSums(const ViewPoints& view, std::span<const FreeParameter> free,
                             const ViewShapes& shapes, const ViewRowTerms& row_terms)
    : free_(free), shapes_(shapes), row_terms_(row_terms) {
  set_view(view, job_);
  job_.num_columns = static_cast<int>(free.size());
  job_.shape = shapes.of_points.empty() ? nullptr : shapes.of_points.data()->data();
  job_.row_terms = row_terms.count();
  job_.middle_row = row_terms.middle_row;
}

bool ParameterSums::at(const Lens& lens, const Pose& camera_from_target, MatrixXd& gram) {
  constexpr int kMaxColumns = 6 + kMaxLensParameters + kNumShapes + kMaxRowTerms + 1;
  double sums[kMaxColumns * (kMaxColumns + 1) / 2];
  std::fill_n(job_.columns, kMaxLensParameters, 0u);
  const unsigned wanted = set_columns(free_, parameters(lens).size(), job_.columns);
  const ProjectKernelKind kind = set_lens(lens, wanted, job_);
  set_state(state_of(camera_from_target), job_);
  Eigen::Map<Eigen::Vector3d>(job_.shape_directions[0]) =
      camera_from_target.rotation() * shapes_.normal;
  Eigen::Map<Eigen::Vector3d>(job_.shape_directions[1]) =
      camera_from_target.rotation() * shapes_.across;
  job_.sums = sums;
  if (!fastest_kernels().sums_with_parameters[kind](job_)) return false;
  const Index n =
      6 + static_cast<Index>(free_.size()) + (job_.shape ? kNumShapes : 0) + job_.row_terms + 1;
  all_.resize(n, n);
  const double* sum = sums;
  for (Index i = 0; i < n; ++i)
    for (Index j = i; j < n; ++j) all_(i, j) = *sum++;
  if (!std::isfinite(all_(n - 1, n - 1))) return false;
  if (job_.row_terms == 0) {
    gram = all_;
    return true;
  }
  // By the terms, with their prior.
  const Index m = job_.row_terms, at = n - 1 - m;
  if (row_terms_.velocities) {
    const Matrix6 products = all_.block<6, 6>(at, at).selfadjointView<Eigen::Upper>();
    all_.block(0, at, at, 6) *= *row_terms_.velocities;
    all_.block<6, 6>(at, at) =
        row_terms_.velocities->transpose() * products * *row_terms_.velocities;
    all_.block<6, 1>(at, n - 1) = row_terms_.velocities->transpose() * all_.block<6, 1>(at, n - 1);
  }
  const double weight = 1 / (row_terms_.sigma * row_terms_.sigma);
  const VectorXd start = row_terms_.start.head(m);
  all_.block(at, at, m, m).diagonal().array() += weight;
  all_.block(at, n - 1, m, 1) += weight * start;
  all_(n - 1, n - 1) += weight * start.squaredNorm();
  MatrixXd by_rows(n - m, m);
  by_rows << all_.block(0, at, at, m), all_.block(at, n - 1, m, 1).transpose();
  gram.resize(n - m, n - m);
  gram.topLeftCorner(at, at) = all_.topLeftCorner(at, at);
  gram.topRightCorner(at, 1) = all_.topRightCorner(at, 1);
  gram(at, at) = all_(n - 1, n - 1);
  gram.triangularView<Eigen::Upper>() -=
      by_rows * Eigen::LLT<MatrixXd>(row_information()).solve(by_rows.transpose());
  return true;
}

MatrixXd ParameterSums::row_information() const {
  const Index m = job_.row_terms, at = all_.cols() - 1 - m;
  return all_.block(at, at, m, m).selfadjointView<Eigen::Upper>();
}

Vector6d ParameterSums::row_terms() const {
  const Index m = job_.row_terms, last = all_.cols() - 1;
  Vector6d terms = row_terms_.start;
  if (m > 0)
    terms.head(m) -=
        Eigen::LLT<MatrixXd>(row_information()).solve(all_.block(last - m, last, m, 1));
  return terms;
}

MatrixXd ParameterSums::with_velocity(const Vector6d& terms) const {
  const Index last = all_.cols() - 1, at = last - job_.row_terms;
  MatrixXd columns = MatrixXd::Zero(last + 1, at + 2);
  columns.topLeftCorner(at, at).setIdentity();
  columns.block<6, 1>(at, at) = terms;
  columns.block<6, 1>(at, at + 1) = -row_terms_.start;
  columns(last, at + 1) = 1;
  const MatrixXd all = all_.selfadjointView<Eigen::Upper>();
  return columns.transpose() * all * columns;
}

ParameterSums::RowEquations ParameterSums::row_equations() const {
  const Index m = job_.row_terms, last = all_.cols() - 1, at = last - m;
  const double weight = 1 / (row_terms_.sigma * row_terms_.sigma);
  const VectorXd start = row_terms_.start.head(m);
  const Eigen::Matrix<double, 6, 6> by_pose =
      all_.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
  const MatrixXd cross = all_.block(0, at, 6, m);
  const MatrixXd explained =
      Eigen::LDLT<Eigen::Matrix<double, 6, 6>>(by_pose).solve(cross).transpose();
  RowEquations rows;
  rows.information = row_information() - explained * cross;
  rows.information.diagonal().array() -= weight;
  rows.gradient = all_.block(at, last, m, 1) - weight * start -
                  explained * all_.block<6, 1>(0, last) - rows.information * start;
  return rows;
}

void compressed_rows(const MatrixXd& gram, Index first, MatrixXd& r) {
  constexpr double kRounding = 1e-13;  // numeric: of a pivot, over the square of its column
  const Index n = gram.cols();
  Eigen::VectorXd pivots = gram.diagonal();
  const auto is_rounding = [&](Index i) { return !(pivots[i] > kRounding * gram(i, i)); };
  const auto is_less = [&](Index i, Index j) {
    return pivots[i] * gram(j, j) < pivots[j] * gram(i, i);
  };
  std::vector<Index> columns(static_cast<std::size_t>(n));  // without a row yet
  std::iota(columns.begin(), columns.end(), 0);
  r.setZero(n, n);
  for (Index row = 0; row < n; ++row) {
    const auto last = std::prev(columns.end());
    auto next = columns.begin();
    if (row >= first) next = std::max_element(columns.begin(), last, is_less);
    if (row >= first && is_rounding(*next)) next = last;
    const Index i = *next;
    columns.erase(next);
    if (i == n - 1) {
      r(row, i) = std::sqrt(std::max(0.0, pivots[i]));
      return;
    }
    if (is_rounding(i)) continue;
    r(row, i) = std::sqrt(pivots[i]);
    for (const Index j : columns) {
      const double product = gram(std::min(i, j), std::max(i, j));
      r(row, j) = (product - r.col(i).head(row).dot(r.col(j).head(row))) / r(row, i);
      pivots[j] -= r(row, j) * r(row, j);
    }
  }
}

}  // namespace tagcal::internal
