#include "report/rig_comparison.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/rig_calibration_file.hpp"

namespace tagcal::tools {
namespace {

using CameraPair = std::array<std::size_t, 2>;  // numbers of cameras of a rig

// The steps of second_from_first of several pairs by those of all places of a rig.
MatrixX pairs_by_rig(const KnownRig& rig, std::span<const CameraPair> pairs) {
  MatrixX by = MatrixX::Zero(6 * std::ssize(pairs), rig.covariance.rows());
  for (Eigen::Index p = 0; p < std::ssize(pairs); ++p) {
    const auto [first, second] = pairs[static_cast<std::size_t>(p)];
    const Eigen::Matrix<double, 6, 12> part =
        pair_by_places(rig.cameras[first].camera_from_rig, rig.cameras[second].camera_from_rig);
    by.block<6, 6>(6 * p, 6 * static_cast<Eigen::Index>(first)) = part.leftCols<6>();
    by.block<6, 6>(6 * p, 6 * static_cast<Eigen::Index>(second)) = part.rightCols<6>();
  }
  return by;
}

// The covariance of the steps of all pairs, which are the same two cameras in both rigs; none
// without one of either rig.
std::optional<MatrixX> covariance_of_pairs(const ComparedRig& a, const ComparedRig& b,
                                           std::span<const CameraPair> in_a,
                                           std::span<const CameraPair> in_b) {
  std::optional<MatrixX> sum;
  for (const auto& [rig, pairs] : {std::pair(&a.rig, in_a), std::pair(&b.rig, in_b)}) {
    if (rig->covariance.size() == 0) continue;
    const MatrixX by = pairs_by_rig(*rig, pairs);
    const MatrixX own = by * rig->covariance * by.transpose();
    sum = sum ? MatrixX(*sum + own) : own;
  }
  return sum;
}

std::string names_of(const ComparedRig& rig) {
  return internal::joined(rig.file.cameras, ", ", &FileCamera::name);
}

PlaceDifference difference_of(const ComparedRig& a, const ComparedRig& b,
                              std::span<const SharedCamera> shared, std::size_t first,
                              std::size_t second) {
  const auto from_first = [&](const ComparedRig& rig, std::size_t from, std::size_t to) {
    return rig.rig.cameras[to].camera_from_rig * rig.rig.cameras[from].camera_from_rig.inverse();
  };
  PlaceDifference d{.first = first, .second = second};
  d.a = from_first(a, shared[first].in_a, shared[second].in_a);
  d.b = from_first(b, shared[first].in_b, shared[second].in_b);
  d.step = minus(d.b, d.a);
  const std::vector<CameraPair> in_a = {{shared[first].in_a, shared[second].in_a}};
  const std::vector<CameraPair> in_b = {{shared[first].in_b, shared[second].in_b}};
  if (const auto covariance = covariance_of_pairs(a, b, in_a, in_b)) {
    d.covariance = *covariance;
    d.in_sigmas = step_score(d.step, *covariance);
  }
  return d;
}

}  // namespace

ComparedRig compared_rig(const std::string& name, const CameraFile& file) {
  return {name, file, known_rig(file, name)};
}

std::vector<SharedCamera> shared_cameras(const ComparedRig& a, const ComparedRig& b) {
  const std::vector<FileCamera>&of_a = a.file.cameras, &of_b = b.file.cameras;
  std::vector<SharedCamera> shared;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    for (std::size_t j = 0; j < of_b.size(); ++j)
      if (of_a[i].name == of_b[j].name) shared.push_back({i, j});
  if (shared.empty() && of_a.size() == of_b.size())
    for (std::size_t i = 0; i < of_a.size(); ++i) shared.push_back({i, i});
  if (shared.size() < 2)
    throw Error(fmt::format("{}: must have two cameras or more of {} ({}), got {}", b.name, a.name,
                            names_of(a), names_of(b)));
  return shared;
}

PlacesComparison compare_places(const ComparedRig& a, const ComparedRig& b,
                                std::span<const SharedCamera> shared) {
  PlacesComparison places;
  for (std::size_t i = 0; i < shared.size(); ++i)
    for (std::size_t j = i + 1; j < shared.size(); ++j)
      places.pairs.push_back(difference_of(a, b, shared, i, j));
  // All places: those of the others in the frame of the first shared camera.
  std::vector<CameraPair> in_a, in_b;
  Eigen::VectorXd steps(6 * (std::ssize(shared) - 1));
  for (std::size_t j = 1; j < shared.size(); ++j) {
    in_a.push_back({shared[0].in_a, shared[j].in_a});
    in_b.push_back({shared[0].in_b, shared[j].in_b});
    steps.segment<6>(6 * static_cast<Eigen::Index>(j - 1)) = places.pairs[j - 1].step;
  }
  if (const auto covariance = covariance_of_pairs(a, b, in_a, in_b))
    places.in_sigmas = step_score(steps, *covariance);
  return places;
}

}  // namespace tagcal::tools
