#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "tagcal/estimate/types.hpp"
#include "tagcal/geometry/pose.hpp"

// Parts that the JSON of several commands has.

namespace tagcal::tools {

nlohmann::ordered_json matrix_json(const Eigen::MatrixXd& matrix);  // a list of rows
nlohmann::ordered_json pose_json(const Pose& pose);                 // {rotation, translation_m}
nlohmann::ordered_json optional_json(const std::optional<double>& value);  // null without one
nlohmann::ordered_json distance_json(double distance_m);  // "infinity" if it is not finite
nlohmann::ordered_json readout_json(const std::optional<Readout>& readout);  // null without one

}  // namespace tagcal::tools
