#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "study/harness/study.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

// How studies find corners in pictures: the fit of detect(), and detectors of OpenCV.

namespace tagcal {

using ExactCorners = std::map<CornerId, Eigen::Vector2d>;

// Pictures with their exact corners, each of a scene's views as `tagcal render` renders it.
struct ExactPictures {
  std::vector<ImageSource> sources;
  std::vector<ExactCorners> corners;
};
ExactPictures rendered(const Scene& scene, std::uint64_t seed);

// The corners that a method finds in a picture, and its processor time.
struct FoundCorners {
  View view;
  double ms = 0;
};

FoundCorners corners_by_fit(const Image8& image, const Board& board, const Camera* camera,
                            Refinement refinement = Refinement::fit);

// cv::cornerSubPix from given places, with a window for squares of this side.
std::vector<Eigen::Vector2d> corners_by_sub_pix(const Image8& image,
                                                const std::vector<Eigen::Vector2d>& starts,
                                                double square_px);

// A detector of OpenCV; its corners are in no certain order, none if the board is not found.
struct PeerDetector {
  std::string name;
  std::function<std::vector<Eigen::Vector2d>(const Image8& image)> find;
};

// Those for checkerboards (findChessboardCornersSB last), or for ChArUco boards.
std::vector<PeerDetector> peer_detectors(const Board& board);

// Each corner has the id of the nearest exact one: OpenCV may number a board from another side.
FoundCorners corners_by_peer(const PeerDetector& peer, const Image8& image,
                             const ExactCorners& exact);

// What studies of corners share: exact corners; and the rows of `checkers`, and its pictures in
// files.

ExactCorners corners_of(const std::vector<Observation>& observations);

// The corners of one board in each view by a calibration of all views (fisheye4), or as they were
// found in fewer than three views.
std::vector<ExactCorners> exact_by_calibration(const Dataset& set);

// The columns of a row, and what a line of a table says of its rows: `boards`, the heading of their
// number; and, `with_bound`, the errors beside the bound.
std::vector<std::string> checker_columns();
std::vector<study::Figure> checker_figures(const std::string& boards, bool with_bound);

// A row of the study. A corner is wrong if it is off by more than `wrong_px`; the squares are of
// errors.
study::Values checker_row(const std::string& method, const ExactCorners& exact,
                          const FoundCorners& found, double bound_square, double wrong_px = 0.5);

// For each set of pictures a task of one trial: data sets that `tagcal render` made, folders of
// pictures with a target.yaml, and the files among the inputs, which are one set. `target`: of all
// that have none. Without a truth the exact corners are those of a calibration of all pictures by
// the corners of whichever method has most, and the squares are of held-out residuals: of every
// other corner under a calibration by the others. Throws Error.
std::vector<study::Task> picture_tasks(const std::vector<std::string>& inputs,
                                       const std::string& target);

}  // namespace tagcal
