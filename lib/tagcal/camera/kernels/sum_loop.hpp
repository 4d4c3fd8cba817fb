#pragma once

#include "tagcal/camera/kernels/pack_pose.hpp"

// The loop of the normal equations over packs of points, for any lens kernel and pack. Included by
// the files of kernels only, each of which has its own copy (see lens_kernels.hpp).

namespace tagcal::internal {
namespace {

template <typename LensKernel, typename Pack, bool kWithFocal>
class SumLoop {
 public:
  static bool run(const SumJob& job) {
    SumLoop loop(job);
    unsigned long i = 0;
    bool valid = true;
    constexpr unsigned long kSize = Pack::kSize;
    // Two packs at a time: the sums do not fit in registers, so they are fetched half as often.
    for (; i + 2 * kSize <= job.num_points; i += 2 * kSize) {
      Rows rows[2];
      for (unsigned long k = 0; k < 2; ++k) {
        const unsigned long j = i + k * kSize;
        valid &=
            loop.find_rows(job.points + 3 * j, job.pixels + 2 * j, whitening_at(job, j), rows[k]);
      }
      loop.add(rows[0], rows[1]);
    }
    for (; i + kSize <= job.num_points; i += kSize)
      valid &= loop.step(job.points + 3 * i, job.pixels + 2 * i, whitening_at(job, i));
    if constexpr (Pack::kSize > 1)
      if (i < job.num_points) valid &= loop.rest(job, i);
    for (int k = 0; k < kNumSums; k += 4) store_lane_sums(loop.sums_ + k, job.sums + k);
    return valid;
  }

 private:
  static constexpr int kNumColumns = kWithFocal ? 8 : 7;  // the last one is the residual
  static constexpr int kNumSums = kNumColumns * (kNumColumns + 1) / 2;
  static_assert(kNumSums % 4 == 0);

  explicit SumLoop(const SumJob& job) : pose_(job), lens_(job) {
    for (Pack& sum : sums_) sum = Pack(0);
  }

  // [J | r] of a pack; row 0 of u, 1 of v.
  struct Rows {
    Pack of[2][kNumColumns];
  };

  bool step(const double* points, const double* pixels, const double* whitening) {
    Rows rows;
    const bool valid = find_rows(points, pixels, whitening, rows);
    add(rows);
    return valid;
  }

  // Returns true if all points are in the domain.
  bool find_rows(const double* points, const double* pixels, const double* whitening,
                 Rows& result) {
    Pack(&rows)[2][kNumColumns] = result.of;
    PackPoint<Pack> source;
    load_points(points, source.x, source.y, source.z);
    Pack u, v;
    load_pairs(pixels, u, v);
    const PackPoint<Pack> turned = pose_.turned(source);
    const PackImage<Pack> image = LensKernel::project(lens_, pose_.moved(turned), &jacobian_);
    for (int row = 0; row < 2; ++row) set_by_pose(turned, jacobian_.by_point[row], rows[row]);
    if constexpr (kWithFocal) {
      rows[0][6] = lens_.p[kFx] * jacobian_.by_parameters[0][kFx];
      rows[1][6] = lens_.p[kFy] * jacobian_.by_parameters[1][kFy];
    }
    rows[0][kNumColumns - 1] = image.u - u;
    rows[1][kNumColumns - 1] = image.v - v;
    if (whitening) whiten(whitening, kNumColumns, rows[0], rows[1]);
    return all(image.valid);
  }

  void add(const Rows& a) {
    int k = 0;
#pragma GCC unroll 8
    for (int i = 0; i < kNumColumns; ++i)
#pragma GCC unroll 8
      for (int j = i; j < kNumColumns; ++j, ++k)
        sums_[k] = fma(a.of[0][i], a.of[0][j], fma(a.of[1][i], a.of[1][j], sums_[k]));
  }

  void add(const Rows& a, const Rows& b) {
    int k = 0;
#pragma GCC unroll 8
    for (int i = 0; i < kNumColumns; ++i)
#pragma GCC unroll 8
      for (int j = i; j < kNumColumns; ++j, ++k) {
        const Pack of_a = fma(a.of[0][i], a.of[0][j], a.of[1][i] * a.of[1][j]);
        const Pack of_b = fma(b.of[0][i], b.of[0][j], fma(b.of[1][i], b.of[1][j], sums_[k]));
        sums_[k] = of_a + of_b;
      }
  }

  // The last points, fewer than a pack: the pack is filled with copies of the last one, whitened to
  // nothing.
  bool rest(const SumJob& job, unsigned long begin) {
    constexpr unsigned long kSize = Pack::kSize;
    double points[3 * kSize], pixels[2 * kSize], weights[4 * kSize];
    copy_rest<kSize>(job, begin, points, pixels, weights);
    return step(points, pixels, weights);
  }

  const PackPose<Pack> pose_;
  const PackLens<Pack> lens_;
  PackJacobian<Pack> jacobian_;
  Pack sums_[kNumSums];
};

}  // namespace
}  // namespace tagcal::internal
