#pragma once

#include <Eigen/Core>
#include <array>
#include <mutex>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/scene/image.hpp"

// AprilTag's own detector. Private to study.

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

}  // namespace tagcal::study
