#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::tools {

// The pose of one view, with a known or an unknown focal length.
struct PoseReport {
  std::string image;
  std::optional<double> time_s;   // of the picture, as Input::times_s
  std::vector<CornerId> corners;  // observed
  Status status = Status::degenerate;
  std::vector<PoseHypothesis> hypotheses;  // to be shown, best first
  std::vector<std::size_t> outliers;       // of the corners

  // Empty if unknown.
  std::optional<double> focal_px, sigma_focal_px;
  std::optional<double> prior_focal_px;  // the caller's focal length of the pose
  std::vector<WeakPerspectivePose> weak_perspective;
  std::optional<double> sigma_px;  // none where every corner has its own covariance

  std::vector<Finding> findings;
  std::vector<std::string> cameras;  // of a rig, that take part; the pose is that of its frame
};

// Copies the poses of an answer and those for a prior focal length. The solver's last state without
// an answer is not shown, because it would look like an answer.
PoseReport reported(const PoseEstimate& estimate);
PoseReport reported(const PoseAndFocalEstimate& estimate, const PoseAndFocalOptions& options);

// Says what is wrong in the target file; there is no answer if corners are numbered by it.
void report_mistakes(const std::vector<TargetMistake>& mistakes, PoseReport& report);

// Returns the quaternion with w >= 0, so that equal poses look equal.
Eigen::Quaterniond shown_rotation(const Pose& pose);

// Returns one JSON object (docs/tasks/pose.md). Unknown values are null.
std::string pose_json(const std::vector<PoseReport>& views);

// Returns the report for a person: for each view the verdict, warnings, where the camera is,
// rejected corners; `verbose`: also the rotation and the noise.
std::string pose_text(const std::vector<PoseReport>& views, bool verbose);

}  // namespace tagcal::tools
