#pragma once

#include <optional>
#include <vector>

#include "tagcal/estimate/check_types.hpp"
#include "tagcal/scene/rig.hpp"
#include "tagcal/uncertainty/known_rig.hpp"

// Is a calibration still valid? New pictures of a board against a camera, or a rig, that was
// calibrated before.

namespace tagcal {

// Tests if pictures agree with a camera: the likelihood ratio of the camera as it is known, with
// its covariance, against a camera whose lens is free; poses and the shape of the board are free in
// both. With S and g the information and the gradient of the pictures by the lens, poses and the
// noise of the corners eliminated (covariance.hpp), d the step from the free camera to the known
// one, C its covariance and phi the overdispersion of the views,
//   T = (g + S d)' (phi S + S C S)^+ (g + S d)
// is a chi-square of k = rank S degrees of freedom, a score test (Rao, Proc. Camb. Phil. Soc. 44,
// 1948) whose noise is that of the residuals of the free camera; so larger residuals are no
// change, and F takes the place of chi-square / k. The smallest change d that is found with the
// probability `power` has a non-centrality d' S (phi S + S C S)^+ S d that gives it.
// A camera without a covariance is taken as exact, and a finding says so. Throws Error for another
// image size, a parallel lens, or a limit that is not above 0.
CameraCheck check_camera(const Dataset& dataset, const UncertainCamera& known,
                         const CheckOptions& options = {});

// The same for the cameras of a rig and their places, by its instants. Throws Error also for
// another number of cameras, and a covariance that does not fit the rig.
CameraCheck check_rig(const RigDataset& dataset, const KnownRig& known,
                      const CheckOptions& options = {});

// The check of the pictures that a known camera is used for: a warning if their residuals
// contradict it beyond p = 0.0001, with the numbers of the check. No value otherwise, and for few
// corners.
std::optional<Finding> contradiction_of_camera(const Dataset& pictures,
                                               const UncertainCamera& known,
                                               std::size_t num_threads = 1);

// The same for a single view.
std::optional<Finding> contradiction_of_camera(const View& view,
                                               const std::vector<PlacedBoard>& boards,
                                               const UncertainCamera& known);

}  // namespace tagcal
