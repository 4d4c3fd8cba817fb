#pragma once

#include "tagcal/camera/kernels/pack_pose.hpp"

// The loop of the normal equations by pose and free parameters over packs of points, for any lens
// kernel and pack. Included by the files of kernels only, each of which has its own copy (see
// lens_kernels.hpp).

namespace tagcal::internal {
namespace {

template <typename LensKernel, typename Pack>
class ParameterSumLoop {
 public:
  static bool run(const ParameterSumJob& job) {
    ParameterSumLoop loop(job);
    unsigned long i = 0;
    bool valid = true;
    for (; i + Pack::kSize <= job.num_points; i += Pack::kSize)
      valid &= loop.step(job.points + 3 * i, job.pixels + 2 * i, whitening_at(job, i),
                         job.bend ? job.bend + 2 * i : nullptr);
    if constexpr (Pack::kSize > 1)
      if (i < job.num_points) valid &= loop.rest(job, i);
    if (loop.num_rows_ > 0) loop.template add<2>();
    loop.store(job.sums);
    return valid;
  }

 private:
  static constexpr int kMaxColumns = 6 + kMaxLensParameters + 2 + 1;
  static constexpr int kMaxSums = kMaxColumns * (kMaxColumns + 1) / 2;

  explicit ParameterSumLoop(const ParameterSumJob& job)
      : pose_(job),
        lens_(job),
        job_(job),
        first_bend_(6 + job.num_columns),
        num_columns_(first_bend_ + (job.bend ? 2 : 0) + 1) {
    for (int i = 0; i < 3; ++i) bend_direction_[i] = Pack(job.bend_direction[i]);
    for (int k = 0; k < kMaxSums; ++k) sums_[k] = Pack(0);
  }

  // Returns true if all points are in the domain.
  bool step(const double* points, const double* pixels, const double* whitening,
            const double* bend) {
    PackPoint<Pack> source;
    load_points(points, source.x, source.y, source.z);
    Pack u, v;
    load_pairs(pixels, u, v);
    const PackPoint<Pack> turned = pose_.turned(source);
    const PackImage<Pack> image = LensKernel::project(lens_, pose_.moved(turned), &jacobian_);
    Pack* rows[2] = {rows_[num_rows_], rows_[num_rows_ + 1]};
    for (int row = 0; row < 2; ++row) {
      set_by_pose(turned, jacobian_.by_point[row], rows[row]);
      for (int i = 0; i < job_.num_columns; ++i) rows[row][6 + i] = column(row, job_.columns[i]);
      if (bend) set_by_bend(bend, jacobian_.by_point[row], rows[row] + first_bend_);
    }
    rows[0][num_columns_ - 1] = image.u - u;
    rows[1][num_columns_ - 1] = image.v - v;
    if (whitening) whiten(whitening, num_columns_, rows[0], rows[1]);
    num_rows_ += 2;
    if (num_rows_ == kMaxRows) add<kMaxRows>();
    return all(image.valid);
  }

  void set_by_bend(const double* bend, const Pack* by_point, Pack* columns) const {
    const Pack moved = fma(by_point[2], bend_direction_[2],
                           fma(by_point[1], bend_direction_[1], by_point[0] * bend_direction_[0]));
    load_pairs(bend, columns[0], columns[1]);
    columns[0] = columns[0] * moved;
    columns[1] = columns[1] * moved;
  }

  // The sum over the lens parameters that one free parameter sets.
  Pack column(int row, unsigned parameters) const {
    Pack sum = jacobian_.by_parameters[row][__builtin_ctz(parameters)];
    for (unsigned left = parameters & (parameters - 1); left != 0; left &= left - 1)
      sum = sum + jacobian_.by_parameters[row][__builtin_ctz(left)];
    return sum;
  }

  // Adds the products of the collected rows, four rows at once, because the sums are read from and
  // written to memory each time.
  template <int kRows>
  void add() {
    Pack* sum = sums_;
    for (int i = 0; i < num_columns_; ++i)
      for (int j = i; j < num_columns_; ++j, ++sum) {
        Pack s = *sum;
        for (int row = 0; row < kRows; ++row) s = fma(rows_[row][i], rows_[row][j], s);
        *sum = s;
      }
    num_rows_ = 0;
  }

  // The last points, fewer than a pack: the pack is filled with copies of the last one, whitened to
  // nothing.
  bool rest(const ParameterSumJob& job, unsigned long begin) {
    constexpr unsigned long kSize = Pack::kSize;
    double points[3 * kSize], pixels[2 * kSize], weights[4 * kSize], bend[2 * kSize] = {};
    copy_rest<kSize>(job, begin, points, pixels, weights);
    for (unsigned long i = 2 * begin; job.bend && i < 2 * job.num_points; ++i)
      bend[i - 2 * begin] = job.bend[i];
    return step(points, pixels, weights, job.bend ? bend : nullptr);
  }

  void store(double* to) const {
    const int count = num_columns_ * (num_columns_ + 1) / 2;
    for (int k = 0; k < count; k += 4) {
      double four[4];
      store_lane_sums(sums_ + k, four);
      for (int lane = 0; lane < 4 && k + lane < count; ++lane) to[k + lane] = four[lane];
    }
  }

  const PackPose<Pack> pose_;
  const PackLens<Pack> lens_;
  const ParameterSumJob& job_;
  const int first_bend_;
  const int num_columns_;  // the last one is the residual
  Pack bend_direction_[3];
  PackJacobian<Pack> jacobian_;
  static constexpr int kMaxRows = 4;
  int num_rows_ = 0;  // collected
  Pack rows_[kMaxRows][kMaxColumns];
  Pack sums_[kMaxSums + 4];
};

template <typename Pack>
constexpr ParameterSumKernels parameter_sums_for() {
  ParameterSumKernels kernels;
  kernels.of[kPinhole] = ParameterSumLoop<PerspectiveKernel<kPinhole>, Pack>::run;
  kernels.of[kBrownConrady] = ParameterSumLoop<PerspectiveKernel<kBrownConrady>, Pack>::run;
  kernels.of[kRational] = ParameterSumLoop<PerspectiveKernel<kRational>, Pack>::run;
  kernels.of[kFisheye] = ParameterSumLoop<FisheyeKernel, Pack>::run;
  kernels.of[kParallel] = ParameterSumLoop<ParallelKernel, Pack>::run;
  return kernels;
}

}  // namespace
}  // namespace tagcal::internal
