#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"

// Tags by AprilTag's own detector and by OpenCV's. Private to study.

namespace tagcal::study {

struct PeerTag {
  int id = 0;
  // As tag_corners() orders them; pixel centres at whole numbers.
  std::array<Eigen::Vector2d, 4> corners;
};

// Two threads must not create AprilTag's families at once.
std::mutex& apriltag_family_lock();

// On one thread, at full resolution (quad_decimate 1).
class AprilTagPeer {
 public:
  AprilTagPeer(const std::string& family, int border_bits);

  std::vector<PeerTag> find(const Image8& image, bool refine_edges) const;

 private:
  internal::FamilyHandle family_;
  internal::DetectorHandle detector_;
};

// OpenCV's aruco with its default settings. False if the build did not find it: then no tag is
// found.
bool has_aruco();

// Tags of the family tag36h11.
std::vector<PeerTag> aruco_tags(const Image8& image, int border_bits);

// The same in a file, as cv::imread reads it.
std::vector<PeerTag> aruco_tags(const std::filesystem::path& file, int border_bits);

// The corners of a ChArUco board of the dictionaries DICT_4X4_50 to DICT_7X7_1000, in any order.
std::vector<Eigen::Vector2d> charuco_corners(const Image8& image, const Charuco& board);

}  // namespace tagcal::study
