#include "tagcal/estimate/pose/view_equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/camera/kernels/parameter_index.hpp"

namespace tagcal::internal {
namespace {

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
                             const ViewBend& bend)
    : free_(free), normal_(bend.normal) {
  set_view(view, job_);
  job_.num_columns = static_cast<int>(free.size());
  job_.bend = bend.shapes.empty() ? nullptr : bend.shapes.data()->data();
}

bool ParameterSums::at(const Lens& lens, const Pose& camera_from_target, Eigen::MatrixXd& gram) {
  constexpr int kMaxColumns = 6 + kMaxLensParameters + 2 + 1;
  double sums[kMaxColumns * (kMaxColumns + 1) / 2];
  std::fill_n(job_.columns, kMaxLensParameters, 0u);
  const unsigned wanted = set_columns(free_, parameters(lens).size(), job_.columns);
  const ProjectKernelKind kind = set_lens(lens, wanted, job_);
  set_state(state_of(camera_from_target), job_);
  Eigen::Map<Eigen::Vector3d>(job_.bend_direction) = camera_from_target.rotation() * normal_;
  job_.sums = sums;
  if (!fastest_kernels().sums_with_parameters[kind](job_)) return false;
  const Eigen::Index n = num_columns();
  gram.resize(n, n);
  const double* sum = sums;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) gram(i, j) = *sum++;
  return std::isfinite(gram(n - 1, n - 1));
}

void compressed_rows(const Eigen::MatrixXd& gram, Eigen::MatrixXd& r) {
  constexpr double kRounding = 1e-14;  // numeric: rounding of a pivot
  const Eigen::Index n = gram.cols();
  r.setZero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double pivot = gram(i, i) - r.col(i).head(i).squaredNorm();
    if (!(pivot > kRounding * gram(i, i))) continue;
    r(i, i) = std::sqrt(pivot);
    for (Eigen::Index j = i + 1; j < n; ++j)
      r(i, j) = (gram(i, j) - r.col(i).head(i).dot(r.col(j).head(i))) / r(i, i);
  }
}

}  // namespace tagcal::internal
