#pragma once

#include <set>

#include "tagcal/io/formats/lens_numbers.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// tagcal's own calibration file: OpenCV's keys and further ones. Parts of it, which
// calibration_yaml writes with the results of an estimate, and a whole file without them.

namespace tagcal::internal {

// image_width, image_height, camera_matrix, distortion_coefficients. Without a focal length there
// is no camera matrix that another program could read.
std::string camera_yaml(const Camera& camera, std::string_view model);

// fixed, parameter_names, sigmas, covariance_names, covariance, claim_model, claim_names,
// claim_covariance: as far as known.
std::string uncertainty_yaml(const CalibrationFile& calibration);

std::string seen_yaml(const SeenRegion& seen);
// warnings, warning_codes, warning_severities.
std::string findings_yaml(const std::vector<Finding>& findings);

// `image` of a view by number. Views are found by name: one without a name gets its number; throws
// Error if the name is in `names`, to which it is added.
std::string image_line(const std::string& image, std::size_t view, std::set<std::string>& names);
std::string pose_lines(const Pose& pose, std::string_view prefix);

// The key `cameras` of a rig: each with `name`, the keys of a camera's own file and
// camera_from_rig.
std::string cameras_yaml(const std::vector<FileCamera>& cameras);
bool has_rig_keys(const YamlValue& top);
CameraFile read_rig_cameras(const YamlValue& top);

// A file of one camera, or a rig.
FormatOutput write_tagcal(const CameraFile& file);

}  // namespace tagcal::internal
