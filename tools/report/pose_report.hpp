#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/pose.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::tools {

// What one view says, with a known or an unknown focal length.
struct PoseReport {
  std::string image;
  std::vector<CornerId> corners;  // that were seen
  Status status = Status::degenerate;
  std::vector<PoseHypothesis> hypotheses;  // to be shown, best first
  std::vector<std::size_t> outliers;       // of the corners

  // Only where they are known.
  std::optional<double> focal_px, sigma_focal_px;
  std::optional<double> prior_focal_px;  // of a pose whose focal length is the caller's
  std::vector<WeakPerspectivePose> weak_perspective;
  std::optional<double> sigma_px;  // none where every corner has its own covariance

  std::vector<std::string> warnings;
};

// The poses of an answer, and those for a prior focal length. Where a solver merely stood without
// an answer is not shown: it would look like one.
PoseReport reported(const PoseEstimate& estimate);
PoseReport reported(const PoseAndFocalEstimate& estimate, const PoseAndFocalOptions& options);

// One JSON object (docs/pose.md). What is not known is null.
std::string pose_json(const std::vector<PoseReport>& views);

// The same for people.
std::string pose_text(const std::vector<PoseReport>& views);

}  // namespace tagcal::tools
