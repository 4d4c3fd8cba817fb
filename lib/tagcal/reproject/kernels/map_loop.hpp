#pragma once

#include "tagcal/camera/kernels/lens_kernels.hpp"
#include "tagcal/reproject/kernels/reproject_kernels.hpp"

// The pixels of a row of points on a line, for any lens kernel and pack. Included by the files of
// kernels only, each of which has its own copy.

namespace tagcal::internal {
namespace {

inline double first_lanes(double) { return 0; }
inline void store_as_floats(float* to, double value) { *to = static_cast<float>(value); }

#ifdef __AVX2__
inline Doubles first_lanes(Doubles) { return Doubles{0, 1, 2, 3}; }
inline void store_as_floats(float* to, Doubles values) {
  _mm_storeu_ps(to, _mm256_cvtpd_ps(values));
}
#endif

template <typename LensKernel, typename Pack>
struct MapLoop {
  static void run(const MapRowJob& job) {
    const MapLoop loop(job);
    constexpr unsigned long kSize = kLanes<Pack>;
    unsigned long i = 0;
    for (; i + kSize <= job.num_points; i += kSize) loop.step(job, i, job.x + i, job.y + i);
    if (i == job.num_points) return;
    float x[kSize], y[kSize];
    loop.step(job, i, x, y);
    for (unsigned long lane = 0; i + lane < job.num_points; ++lane) {
      job.x[i + lane] = x[lane];
      job.y[i + lane] = y[lane];
    }
  }

 private:
  explicit MapLoop(const MapRowJob& job) : limit(splat<Pack>(job.limit)) {
    for (int i = 0; i < kMaxLensParameters; ++i) parameters[i] = splat<Pack>(job.parameters[i]);
  }

  void step(const MapRowJob& job, unsigned long i, float* x, float* y) const {
    const Pack index = first_lanes(Pack{}) + static_cast<double>(job.first + static_cast<long>(i));
    const PackPoint<Pack> point = {job.start[0] + index * job.step[0],
                                   job.start[1] + index * job.step[1],
                                   job.start[2] + index * job.step[2]};
    const PackImage<Pack> image =
        LensKernel::project(parameters, limit, point, static_cast<PackJacobian<Pack>*>(nullptr));
    const Pack nowhere = splat<Pack>(static_cast<double>(kNowhere));
    store_as_floats(x, image.valid ? image.u : nowhere);
    store_as_floats(y, image.valid ? image.v : nowhere);
  }

  Pack parameters[kMaxLensParameters];
  Pack limit;
};

}  // namespace
}  // namespace tagcal::internal
