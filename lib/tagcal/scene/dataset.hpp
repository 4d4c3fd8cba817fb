#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
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

// The true camera and poses of a synthetic data set.
struct Truth {
  Camera camera;
  std::string model;                              // the smallest model that contains the camera
  std::map<std::string, Pose> camera_from_world;  // by image name
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
