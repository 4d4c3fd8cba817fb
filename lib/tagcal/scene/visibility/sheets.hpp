#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/print/board_ink.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal::internal {

// A flat, convex, opaque polygon: the paper of a panel, or an occluder.
struct Sheet {
  std::vector<Eigen::Vector3d> corners;
  Eigen::Vector3d normal;  // unit; the corners run counter-clockwise seen from where it points
  std::size_t board = 0;   // index in the scene, of a paper
  std::size_t occluder = 0;
  std::optional<BoardPanel> panel;  // of a paper
};

// All opaque surfaces of a scene. Where several lie in one plane, each lies on those before it: the
// occluders in the order of the scene, then the papers (an occluder is the desk under a board).
// Throws Error if an occluder has fewer than three corners or no area.
std::vector<Sheet> sheets(const Scene& scene, const Pose& target_from_world = Pose());

// "board 0", "occluder 2", or the occluder's own name.
std::string sheet_name(const Scene& scene, const Sheet& sheet);

}  // namespace tagcal::internal
