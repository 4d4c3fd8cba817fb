#pragma once

#include "tagcal/camera/kernels/pack_pose.hpp"

// The loop of batch projection over packs of points, for any lens kernel and pack. Included by the
// files of kernels only, each of which has its own copy (see lens_kernels.hpp).

namespace tagcal::internal {
namespace {

template <typename Pack>
void store_by_pose(const PackPoint<Pack>& turned, const PackJacobian<Pack>& jacobian, double* out) {
  for (int row = 0; row < 2; ++row) {
    Pack columns[6];
    set_by_pose(turned, jacobian.by_point[row], columns);
    store_rows([&](int i) { return columns[i]; }, 6, out + 6 * row, 12);
  }
}

// Indices into PackJacobian of the columns of by_parameters: a single lens parameter has its own
// index, the sums follow behind.
struct ColumnPlan {
  explicit ColumnPlan(const ProjectJob& job) : num_columns(job.num_columns) {
    for (int i = 0; i < num_columns; ++i) {
      const unsigned parameters = job.columns[i];
      const bool is_one = (parameters & (parameters - 1)) == 0;
      index[i] = is_one ? __builtin_ctz(parameters) : kMaxLensParameters + num_sums;
      if (!is_one) sums[num_sums++] = parameters;
    }
  }

  int num_columns;
  int num_sums = 0;
  int index[kMaxLensParameters];
  unsigned sums[kMaxLensParameters];
};

template <typename Pack>
void store_by_parameters(const ColumnPlan& plan, PackJacobian<Pack>& jacobian, double* out) {
  for (int row = 0; row < 2; ++row) {
    Pack* const columns = jacobian.by_parameters[row];
    for (int i = 0; i < plan.num_sums; ++i) {
      Pack sum{};
      for (unsigned left = plan.sums[i]; left != 0; left &= left - 1)
        sum = sum + columns[__builtin_ctz(left)];
      columns[kMaxLensParameters + i] = sum;
    }
    const auto column = [&](int i) { return columns[plan.index[i]]; };
    store_rows(column, plan.num_columns, out + row * plan.num_columns, 2 * plan.num_columns);
  }
}

// The two rows of every point that has no pixel.
template <int kSize>
void spoil_rows(const unsigned char* valid, int num_columns, double* out) {
  for (int lane = 0; lane < kSize; ++lane)
    for (int i = 0; !valid[lane] && i < 2 * num_columns; ++i)
      out[lane * 2 * num_columns + i] = __builtin_nan("");
}

template <typename LensKernel, typename Pack, bool kJacobians>
class ProjectLoop {
 public:
  static void run(const ProjectJob& job) {
    ProjectLoop loop(job);
    unsigned long i = 0;
    for (; i + kSize <= job.num_points; i += kSize) loop.step(job, i);
    if constexpr (kSize > 1)
      if (i < job.num_points) loop.rest(job, i);
  }

 private:
  static constexpr int kSize = kLanes<Pack>;

  explicit ProjectLoop(const ProjectJob& job) : view_(job), plan_(job) {}

  void step(const ProjectJob& job, unsigned long i) {
    PackPoint<Pack> source;
    load_points(job.points + 3 * i, source.x, source.y, source.z);
    const PackPoint<Pack> turned = view_.turned(source);
    const PackImage<Pack> image =
        LensKernel::project(view_.parameters, view_.limit, view_.moved(turned), jacobian());
    const Pack nan = splat<Pack>(__builtin_nan(""));
    store_pixels(image.valid ? image.u : nan, image.valid ? image.v : nan, job.pixels + 2 * i);
    store_valid(image.valid, job.valid + i);
    if constexpr (kJacobians) {
      double* const by_pose = job.by_pose + 12 * i;
      double* const by_parameters = job.by_parameters + width(job) * i;
      if (job.by_pose) store_by_pose(turned, jacobian_, by_pose);
      if (job.by_parameters) store_by_parameters(plan_, jacobian_, by_parameters);
      if (all_set(image.valid)) return;
      if (job.by_pose) spoil_rows<kSize>(job.valid + i, 6, by_pose);
      if (job.by_parameters) spoil_rows<kSize>(job.valid + i, job.num_columns, by_parameters);
    }
  }

  // The last points, fewer than a pack: the same step on a copy, so that a point's result does not
  // depend on its place.
  void rest(const ProjectJob& job, unsigned long begin) {
    double points[3 * kSize] = {}, pixels[2 * kSize], by_pose[12 * kSize];
    double by_parameters[2 * kMaxLensParameters * kSize];
    unsigned char valid[kSize];
    const unsigned long count = job.num_points - begin;
    copy(job.points + 3 * begin, 3 * count, points);
    ProjectJob part = job;
    part.points = points;
    part.pixels = pixels;
    part.valid = valid;
    if (job.by_pose) part.by_pose = by_pose;
    if (job.by_parameters) part.by_parameters = by_parameters;
    step(part, 0);
    copy(pixels, 2 * count, job.pixels + 2 * begin);
    copy(valid, count, job.valid + begin);
    if constexpr (kJacobians) {
      if (job.by_pose) copy(by_pose, 12 * count, job.by_pose + 12 * begin);
      if (job.by_parameters)
        copy(by_parameters, width(job) * count, job.by_parameters + width(job) * begin);
    }
  }

  PackJacobian<Pack>* jacobian() { return kJacobians ? &jacobian_ : nullptr; }

  // Numbers a point in by_parameters.
  static unsigned long width(const ProjectJob& job) {
    return 2 * static_cast<unsigned long>(job.num_columns);
  }

  template <typename T>
  static void copy(const T* from, unsigned long count, T* to) {
    for (unsigned long i = 0; i < count; ++i) to[i] = from[i];
  }

  const PackView<Pack> view_;
  const ColumnPlan plan_;
  PackJacobian<Pack> jacobian_;
};

}  // namespace
}  // namespace tagcal::internal
