#pragma once

#include <map>
#include <optional>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// Counts the corners that have a covariance of their own.
struct CornerNoise {
  std::size_t num_known = 0;
  std::size_t num_corners = 0;

  void add(const View& view);
  // True if half of the corners or more have a covariance: then the estimate uses them.
  bool counts() const { return num_known > 0 && 2 * num_known >= num_corners; }
  std::size_t num_assumed() const { return num_corners - num_known; }
};

// Returns a corner's own covariance, or that of policy::kAssumedSigmaPx.
Matrix2 covariance_or_assumed(const Observation& corner);

// Input of estimate_pose for one view.
struct ViewCorrespondences {
  std::vector<CornerId> ids;
  std::vector<Correspondence> correspondences;
  std::vector<int> groups;              // the corners' tags
  std::vector<Matrix2> covariance_px2;  // empty if they are not used
};

// Returns the corners of a view that the target has. Their covariances do not include the errors of
// lens and target, so they are used only if that error is known too
// (CalibrationFile::camera_error_px).
ViewCorrespondences view_correspondences(const View& view,
                                         const std::map<CornerId, Eigen::Vector3d>& target,
                                         const std::optional<double>& camera_error_px);

}  // namespace tagcal::internal
