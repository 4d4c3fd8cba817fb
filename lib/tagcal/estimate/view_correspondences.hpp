#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/scene/dataset.hpp"

// From the corners of a view to the input of estimate_pose (pose.hpp), and from lists of points and
// pixels to a data set.

namespace tagcal {

// Input of estimate_pose for one view: one entry per corner in each list that is not empty.
struct ViewCorrespondences {
  std::vector<CornerId> ids;
  std::vector<std::size_t> observations;  // indices in View::observations
  std::vector<Correspondence> correspondences;
  std::vector<int> groups;              // the corners' tags
  std::vector<Matrix2> covariance_px2;  // empty if they are not used

  // The options with these groups and covariances, to which they point: the lists must outlive
  // them. A stated noise (sigma_px > 0) replaces the covariances.
  template <typename Options = PoseOptions>
  Options with_these(Options options = {}) const& {
    options.groups = groups;
    if (options.sigma_px == 0) options.covariance_px2 = covariance_px2;
    return options;
  }
  template <typename Options = PoseOptions>
  Options with_these(Options options = {}) const&& = delete;
};

// The corners of a view that the boards have, in world coordinates (of a single board with
// world_from_board at identity: in its own). Corners without a covariance count with one of 0.5 px
// if half of the view's corners or more have one; otherwise no covariance is used. The corners'
// covariances do not include the errors of lens and target, `camera_error_px` per coordinate
// (CalibrationFile::camera_error_px): without that error they are not used.
ViewCorrespondences view_correspondences(const View& view, const std::vector<PlacedBoard>& boards,
                                         const std::optional<double>& camera_error_px = {});

// The same for points that were gathered before (points_in_world), in their frame.
ViewCorrespondences view_correspondences(const View& view,
                                         const std::map<CornerId, Eigen::Vector3d>& target,
                                         const std::optional<double>& camera_error_px = {});

// The points and pixels alone.
std::vector<Correspondence> correspondences(const View& view,
                                            const std::vector<PlacedBoard>& boards);

// The data set of what each view shows, as cv::calibrateCamera takes it: points in the target's
// frame and their pixels. The points of all views become one board: equal positions are one point,
// and ids count from 0 in the order of their first occurrence. The views have no names. Throws
// Error for a number that is not finite and a point that a view shows twice.
Dataset dataset_from_correspondences(std::span<const std::vector<Correspondence>> views,
                                     const ImageSize& image_size);

}  // namespace tagcal
