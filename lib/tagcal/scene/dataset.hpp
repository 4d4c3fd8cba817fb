#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal {

// A corner seen in an image. Pixel (0,0) is the centre of the top-left pixel.
struct Observation {
  CornerId id;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  std::optional<Matrix2> covariance_px2;  // if the detector estimates it
};

// All observations in one image; each corner at most once.
struct View {
  std::string image;
  std::vector<Observation> observations;
};

struct PlacedBoard {
  Board board;
  Pose world_from_board;
};

constexpr const char* kParallelModel = "parallel";  // orthographic or oblique: no candidate model

// The poses of a scene's frames and boards in one view.
struct HierarchyTruth {
  std::map<std::string, Affine> camera_from_frame;  // all frames, the scene's world included
  std::vector<Pose> camera_from_board;              // all boards, in the scene's order
};

// The true camera and poses of a synthetic data set.
struct Truth {
  Camera camera;
  std::string model;  // the smallest model that contains the camera, or kParallelModel
  std::map<std::string, Pose> camera_from_world;    // by image name
  std::map<std::string, HierarchyTruth> hierarchy;  // by image name; empty without frames
  std::map<std::string, Lens> lenses;  // by image name, if they differ from view to view
};

// The data that all commands exchange: boards that are rigid in one world, one camera, its views.
struct Dataset {
  ImageSize image_size;
  std::vector<PlacedBoard> boards;  // ids are unique over all boards
  std::vector<View> views;
  std::optional<Truth> truth;
};

// All points of the boards by id, in world coordinates.
std::map<CornerId, Eigen::Vector3d> points_in_world(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal
