#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/estimate/handeye.hpp"
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

// The poses of views as files (docs/tasks/pose.md).

struct PosesAsked {
  bool has_camera = false;   // all views are of one known camera
  bool are_of_tags = false;  // a picture has several
};

// Throws Error if the ending of `out` is none of .csv, .json, .tum and .mcap, if its format cannot
// hold such poses, and as check_text_writable.
void check_pose_file(const std::string& out, const PosesAsked& asked);

// Writes the poses, and says so. A table has a line for each view, two for an ambiguous one, with
// the camera in the target's frame, and empty fields of a view without an answer. Paths (.tum,
// .mcap) have the likelier pose of an ambiguous view. `camera`: a camera's file, or "".
void write_poses(const std::string& out, const std::string& camera,
                 const std::vector<PoseReport>& views);

// The poses of a file that `tagcal pose --json` wrote (docs/tasks/pose.md), without those of the
// robot: views without an answer have none, ambiguous ones two. Throws Error, with the key: another
// file, a pose without a covariance.
std::vector<HandeyeView> read_pose_file(const std::string& file);

}  // namespace tagcal::tools
