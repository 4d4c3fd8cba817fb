#pragma once

#include <map>
#include <optional>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// A view as estimate_pose takes it.
struct ViewCorrespondences {
  std::vector<CornerId> ids;
  std::vector<Correspondence> correspondences;
  std::vector<int> groups;              // the corners' tags
  std::vector<Matrix2> covariance_px2;  // empty where they do not count
};

// The corners of a view that the target has. Their covariances say nothing of the lens and of the
// target: they count where the error of these is known, too (CalibrationFile::camera_error_px).
ViewCorrespondences view_correspondences(const View& view,
                                         const std::map<CornerId, Eigen::Vector3d>& target,
                                         const std::optional<double>& camera_error_px);

}  // namespace tagcal::internal
