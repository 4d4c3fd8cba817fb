#pragma once

#include <filesystem>
#include <vector>

#include "study/peers/apriltag_peer.hpp"
#include "tagcal/scene/board.hpp"

// OpenCV's aruco with its default settings, if it is installed. Private to study.

namespace tagcal::study {

// False if the build did not find aruco: then no tag is found.
bool has_aruco();

// Tags of the family tag36h11.
std::vector<PeerTag> aruco_tags(const Image8& image, int border_bits);

// The same in a file, as cv::imread reads it.
std::vector<PeerTag> aruco_tags(const std::filesystem::path& file, int border_bits);

// The corners of a ChArUco board of the dictionaries DICT_4X4_50 to DICT_7X7_1000, in any order.
std::vector<Eigen::Vector2d> charuco_corners(const Image8& image, const Charuco& board);

}  // namespace tagcal::study
