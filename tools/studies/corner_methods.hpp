#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

// How studies find corners in pictures: the fit of detect(), and detectors of OpenCV.

namespace tagcal {

using ExactCorners = std::map<CornerId, Eigen::Vector2d>;

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

}  // namespace tagcal
