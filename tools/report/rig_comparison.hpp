#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "report/lens_comparison.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/types.hpp"

// Two calibrations of one rig: their lenses, camera by camera, and the places, pair by pair. What
// is compared is b_from_a of two cameras, so the rigs may have different references.

namespace tagcal::tools {

// A file of a rig, and its name.
struct ComparedRig {
  std::string name;
  CameraFile file;
  KnownRig rig;
};

// Throws Error if a camera has no place, no name or no image size.
ComparedRig compared_rig(const std::string& name, const CameraFile& file);

// A camera of both rigs, by number.
struct SharedCamera {
  std::size_t in_a = 0, in_b = 0;
};

// By name; by their order if the rigs have no name in common, but as many cameras. Throws Error if
// fewer than two are shared.
std::vector<SharedCamera> shared_cameras(const ComparedRig& a, const ComparedRig& b);

// The place of the second of two cameras in the frame of the first: that of rig B from that of A,
// as (omega rad, tau m), `minus`.
struct PlaceDifference {
  std::size_t first = 0, second = 0;  // of the shared cameras
  Pose a, b;                          // second_from_first in both rigs
  Vector6d step = Vector6d::Zero();
  std::optional<Matrix6> covariance;  // of the step, if both are right; none without covariances
  std::optional<double> in_sigmas;    // of all six together: a normal score
};

struct PlacesComparison {
  std::vector<PlaceDifference> pairs;
  std::optional<double> in_sigmas;  // of all places together
};

PlacesComparison compare_places(const ComparedRig& a, const ComparedRig& b,
                                std::span<const SharedCamera> shared);

}  // namespace tagcal::tools
