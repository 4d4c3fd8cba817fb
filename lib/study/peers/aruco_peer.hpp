#pragma once

#include <filesystem>
#include <vector>

#include "study/peers/apriltag_peer.hpp"

// OpenCV's aruco with its default settings, if it is installed. Private to study.

namespace tagcal::study {

// False if the build did not find aruco: then no tag is found.
bool has_aruco();

// Tags of the family tag36h11.
std::vector<PeerTag> aruco_tags(const Image8& image, int border_bits);

// The same in a file, as cv::imread reads it.
std::vector<PeerTag> aruco_tags(const std::filesystem::path& file, int border_bits);

}  // namespace tagcal::study
