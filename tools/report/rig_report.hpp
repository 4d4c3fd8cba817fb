#pragma once

#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/rig_types.hpp"

namespace tagcal::tools {

// Returns the report for a person: the verdict, findings, a row for each camera, the place of each
// camera in that of the reference, and how far the pairs can be trusted.
std::string rig_summary(const RigCalibration& rig, std::size_t reference);

// Parts of it, as the page and hand-eye have them too: "OK, 2 warnings: 2 cameras, .." or "NO
// ANSWER: .."; the place of a camera, "-109.99 +- 0.16" along x, y, z in mm, then its rotation
// (axis times angle) in degrees; what a pair says.
std::string rig_verdict(const RigCalibration& rig);
std::vector<std::string> place_texts(const Pose& camera_from_rig, const Matrix6& covariance);
std::string place_lines(const std::string& title, const Pose& camera_from_rig,
                        const Matrix6& covariance);
std::string baseline_text(const RigPair& pair);         // "110.01 +- 0.16 mm"
std::string depth_text(const DepthUncertainty& depth);  // "at 1 m +- 1.4 mm (0.0076 mm of it ..)"
std::string disagreement_text(const RigPair& pair);     // "0.8 sd"

std::string excess_text(const RigCameraEstimate& camera);

// The pictures of an instant: "000.png", or "left01.jpg, right01.jpg" if the cameras' pictures have
// names of their own.
std::string name_of(const Instant& instant, const RigDataset& data);

// Returns one JSON object (docs/reference/formats.md).
std::string rig_json(const RigDataset& data, const RigCalibration& rig, std::size_t reference);

}  // namespace tagcal::tools
