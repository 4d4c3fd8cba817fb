#pragma once

#include "tagcal/camera/kernels/lens_kernels.hpp"

// The rigid part of the chain for a pack of points, and the Jacobian by it. Included by the files
// of kernels only, each of which has its own copy (see lens_kernels.hpp).

namespace tagcal::internal {
namespace {

template <typename Pack>
struct PackPose {
  explicit PackPose(const ViewJob& job) {
    for (int i = 0; i < 9; ++i) rotation[i] = Pack(job.rotation[i]);
    for (int i = 0; i < 3; ++i) translation[i] = Pack(job.translation[i]);
  }

  PackPoint<Pack> turned(const PackPoint<Pack>& x) const {
    const auto row = [&](int i) {
      return fma(rotation[i + 2], x.z, fma(rotation[i + 1], x.y, rotation[i] * x.x));
    };
    return {row(0), row(3), row(6)};
  }

  PackPoint<Pack> moved(const PackPoint<Pack>& x) const {
    return {x.x + translation[0], x.y + translation[1], x.z + translation[2]};
  }

  Pack rotation[9];
  Pack translation[3];
};

// The step is that of `retract`: x_in_camera = exp(omega) R x + t + tau, so a row j of the Jacobian
// by the point becomes (R x) x j by omega, and j by tau.
template <typename Pack>
[[gnu::always_inline]] inline void set_by_pose(const PackPoint<Pack>& turned, const Pack* j,
                                               Pack* columns) {
  columns[0] = fma(turned.y, j[2], -(turned.z * j[1]));
  columns[1] = fma(turned.z, j[0], -(turned.x * j[2]));
  columns[2] = fma(turned.x, j[1], -(turned.y * j[0]));
  for (int i = 0; i < 3; ++i) columns[3 + i] = j[i];
}

// Returns the whitening of point i, or null if there is none.
inline const double* whitening_at(const SumJob& job, unsigned long i) {
  return job.whitening ? job.whitening + 4 * i : nullptr;
}

// Both rows of a pack by its whitening W: W [u; v].
template <typename Pack>
[[gnu::always_inline]] inline void whiten(const double* whitening, int num_columns, Pack* u,
                                          Pack* v) {
  Pack w[4];
  load_fours(whitening, w);
  for (int i = 0; i < num_columns; ++i) {
    const Pack first = u[i], second = v[i];
    u[i] = fma(w[0], first, w[2] * second);
    v[i] = fma(w[1], first, w[3] * second);
  }
}

// A whole pack of the last points of a job, from `begin` on: filled with copies of the last one,
// whose weights are zero.
template <unsigned long kSize>
void copy_rest(const SumJob& job, unsigned long begin, double* points, double* pixels,
               double* weights) {
  const unsigned long last = job.num_points - 1;
  for (unsigned long lane = 0; lane < kSize; ++lane) {
    const unsigned long from = begin + lane < last ? begin + lane : last;
    const double one = begin + lane <= last ? 1 : 0;
    for (unsigned long k = 0; k < 3; ++k) points[3 * lane + k] = job.points[3 * from + k];
    for (unsigned long k = 0; k < 2; ++k) pixels[2 * lane + k] = job.pixels[2 * from + k];
    for (unsigned long k = 0; k < 4; ++k)
      weights[4 * lane + k] =
          job.whitening ? one * job.whitening[4 * from + k] : (k == 0 || k == 3 ? one : 0);
  }
}

}  // namespace
}  // namespace tagcal::internal
