#pragma once

#include "tagcal/camera/pack_pose.hpp"

// The loop of the normal equations by pose and free parameters over packs of points, for any lens
// kernel and pack. Included by the files of kernels only, each of which has its own copy (see
// lens_kernels.hpp).

namespace tagcal {
namespace {

template <typename LensKernel, typename Pack>
class ParameterSumLoop {
 public:
  static bool run(const ParameterSumJob& job) {
    ParameterSumLoop loop(job);
    unsigned long i = 0;
    bool valid = true;
    for (; i + Pack::kSize <= job.num_points; i += Pack::kSize)
      valid &= loop.step(job.points + 3 * i, job.pixels + 2 * i, whitening_at(job, i));
    if constexpr (Pack::kSize > 1)
      if (i < job.num_points) valid &= loop.rest(job, i);
    loop.store(job.sums);
    return valid;
  }

 private:
  static constexpr int kMaxColumns = 6 + kMaxLensParameters + 1;
  static constexpr int kMaxSums = kMaxColumns * (kMaxColumns + 1) / 2;

  explicit ParameterSumLoop(const ParameterSumJob& job)
      : pose_(job), lens_(job), job_(job), num_columns_(6 + job.num_columns + 1) {
    for (int k = 0; k < kMaxSums; ++k) sums_[k] = Pack(0);
  }

  // Whether all points are in the domain.
  bool step(const double* points, const double* pixels, const double* whitening) {
    PackPoint<Pack> source;
    load_points(points, source.x, source.y, source.z);
    Pack u, v;
    load_pairs(pixels, u, v);
    const PackPoint<Pack> turned = pose_.turned(source);
    const PackImage<Pack> image = LensKernel::project(lens_, pose_.moved(turned), &jacobian_);
    for (int row = 0; row < 2; ++row) {
      set_by_pose(turned, jacobian_.by_point[row], rows_[row]);
      for (int i = 0; i < job_.num_columns; ++i) rows_[row][6 + i] = column(row, job_.columns[i]);
    }
    rows_[0][num_columns_ - 1] = image.u - u;
    rows_[1][num_columns_ - 1] = image.v - v;
    if (whitening) whiten(whitening, num_columns_, rows_[0], rows_[1]);
    add();
    return all(image.valid);
  }

  // The sum over the lens parameters that one free parameter sets.
  Pack column(int row, unsigned parameters) const {
    Pack sum = jacobian_.by_parameters[row][__builtin_ctz(parameters)];
    for (unsigned left = parameters & (parameters - 1); left != 0; left &= left - 1)
      sum = sum + jacobian_.by_parameters[row][__builtin_ctz(left)];
    return sum;
  }

  void add() {
    Pack* sum = sums_;
    for (int i = 0; i < num_columns_; ++i) {
      const Pack first = rows_[0][i], second = rows_[1][i];
      for (int j = i; j < num_columns_; ++j, ++sum)
        *sum = fma(first, rows_[0][j], fma(second, rows_[1][j], *sum));
    }
  }

  // The last points, fewer than a pack: the pack is filled with copies of the last one, whitened to
  // nothing.
  bool rest(const ParameterSumJob& job, unsigned long begin) {
    constexpr unsigned long kSize = Pack::kSize;
    double points[3 * kSize], pixels[2 * kSize], weights[4 * kSize];
    copy_rest<kSize>(job, begin, points, pixels, weights);
    return step(points, pixels, weights);
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
  const int num_columns_;  // the last one is the residual
  PackJacobian<Pack> jacobian_;
  Pack rows_[2][kMaxColumns];
  Pack sums_[kMaxSums + 4];
};

}  // namespace
}  // namespace tagcal
