#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "lenses.hpp"
#include "tagcal/camera/kernels/project_dispatch.hpp"

// Input, output and kernels of batch projection.

namespace tagcal {
using namespace internal;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline bool has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

// All sets of kernels that this processor can run.
inline std::vector<const ProjectKernels*> all_kernels() {
  std::vector<const ProjectKernels*> kernels = {&kPortableKernels};
  if (has_avx2()) kernels.push_back(&kAvx2Kernels);
  if (has_avx2()) kernels.push_back(&fastest_kernels());
  return kernels;
}

// The output of a batch and its memory.
struct Result {
  std::size_t count = 0;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<std::uint8_t> valid;
  std::vector<double> by_pose, by_parameters;

  RowMajor pose_rows(std::size_t i) const {
    return Eigen::Map<const RowMajor>(by_pose.data() + 12 * i, 2, 6);
  }
  RowMajor parameter_rows(std::size_t i) const {
    const std::size_t columns = by_parameters.size() / (2 * pixels.size());
    return Eigen::Map<const RowMajor>(by_parameters.data() + 2 * columns * i, 2,
                                      static_cast<Eigen::Index>(columns));
  }
};

// Initial value of the memory; it stays where nothing is written.
inline constexpr double kUntouched = -12345.0;

inline Result run(const ProjectKernels& kernels, const Lens& lens, const Pose& pose,
                  std::span<const Eigen::Vector3d> points, std::span<const FreeParameter> free = {},
                  bool by_pose = false) {
  Result r;
  const std::size_t n = points.size();
  r.pixels.assign(n, Eigen::Vector2d::Constant(kUntouched));
  r.valid.assign(n, 77);
  r.by_pose.assign(by_pose ? 12 * n : 0, kUntouched);
  r.by_parameters.assign(2 * free.size() * n, kUntouched);
  r.count = project_by(kernels, lens, pose, points, free,
                       {r.pixels, r.valid, r.by_pose, r.by_parameters});
  return r;
}

// One free parameter for each of the lens.
inline std::vector<FreeParameter> every_parameter(const Lens& lens) {
  std::vector<FreeParameter> free;
  for (const std::string_view name : parameter_names(lens))
    free.push_back({name, {static_cast<int>(free.size())}});
  return free;
}

// A lens with only the terms of one of the kernels.
template <typename L>
std::vector<Lens> variants(const L& lens) {
  return {lens};
}
template <>
inline std::vector<Lens> variants(const Perspective& lens) {
  auto p = lens.parameters();
  std::vector<Lens> all = {lens};
  std::fill(p.begin() + 9, p.end(), 0);
  all.push_back(Perspective(p));
  std::fill(p.begin() + 4, p.end(), 0);
  all.push_back(Perspective(p));
  return all;
}

template <typename L>
std::vector<Lens> lenses(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<Lens> all;
  for (int i = 0; i < count; ++i)
    for (const Lens& lens : variants(random_lens<L>(random))) all.push_back(lens);
  return all;
}

// A point that the lens sees or, one in four, anywhere.
inline Eigen::Vector3d some_point(const Lens& lens, Random& random) {
  if (random.index(4) == 0) return {random.normal(), random.normal(), random.normal()};
  return std::visit([&](const auto& l) { return point_inside(l, random); }, lens);
}

inline Pose some_pose(Random& random) {
  return {exp_rotation({random.normal(), random.normal(), random.normal()}),
          {random.normal(), random.normal(), random.normal()}};
}

}  // namespace tagcal
