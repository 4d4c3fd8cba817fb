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
  std::optional<Matrix2> covariance_px2;  // where the detector knows it
};

// All that was seen in one image. A corner stands in it at most once.
struct View {
  std::string image;
  std::vector<Observation> observations;
};

struct PlacedBoard {
  Board board;
  Pose world_from_board;
};

// What a synthetic data set knows of itself.
struct Truth {
  Camera camera;
  std::string model;                              // the smallest model that holds the camera
  std::map<std::string, Pose> camera_from_world;  // by image name
};

// What travels along the whole chain: boards that hang rigidly in one world, one camera, its views.
struct Dataset {
  ImageSize image_size;
  std::vector<PlacedBoard> boards;  // ids unique over all
  std::vector<View> views;
  std::optional<Truth> truth;
};

// Every point of the boards by its name, in world coordinates.
std::map<CornerId, Eigen::Vector3d> points_in_world(const std::vector<PlacedBoard>& boards);

}  // namespace tagcal
