#pragma once

#include "tagcal/camera/kernels/lens_kernels.hpp"
#include "tagcal/camera/kernels/pack_memory.hpp"

// The rigid part of the chain for a pack of points, and the Jacobian by it. Included by the files
// of kernels only, each of which has its own copy (see lens_kernels.hpp).

namespace tagcal::internal {
namespace {

// The constants of a job, in every lane.
template <typename Pack>
struct PackView {
  explicit PackView(const ViewJob& job) : limit(splat<Pack>(job.limit)) {
    for (int i = 0; i < 9; ++i) rotation[i] = splat<Pack>(job.rotation[i]);
    for (int i = 0; i < 3; ++i) translation[i] = splat<Pack>(job.translation[i]);
    for (int i = 0; i < kMaxLensParameters; ++i) parameters[i] = splat<Pack>(job.parameters[i]);
  }

  PackPoint<Pack> turned(const PackPoint<Pack>& x) const {
    const auto row = [&](int i) {
      return rotation[i] * x.x + rotation[i + 1] * x.y + rotation[i + 2] * x.z;
    };
    return {row(0), row(3), row(6)};
  }

  PackPoint<Pack> moved(const PackPoint<Pack>& x) const {
    return {x.x + translation[0], x.y + translation[1], x.z + translation[2]};
  }

  Pack rotation[9];
  Pack translation[3];
  Pack parameters[kMaxLensParameters];
  Pack limit;
};

// The step is that of `retract`: x_in_camera = exp(omega) R x + t + tau, so a row j of the Jacobian
// by the point becomes (R x) x j by omega, and j by tau.
template <typename Pack>
[[gnu::always_inline]] inline void set_by_pose(const PackPoint<Pack>& turned, const Pack* j,
                                               Pack* columns) {
  columns[0] = turned.y * j[2] - turned.z * j[1];
  columns[1] = turned.z * j[0] - turned.x * j[2];
  columns[2] = turned.x * j[1] - turned.y * j[0];
  for (int i = 0; i < 3; ++i) columns[3 + i] = j[i];
}

}  // namespace
}  // namespace tagcal::internal
