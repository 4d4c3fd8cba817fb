#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "poses.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/dataset.hpp"

// Random worlds: cameras, boards, their observations and the truth.

namespace tagcal {

struct WorldOptions {
  int num_views = 20;
  double sigma_px = 0.2;
  double outlier_share = 0;  // of the corners, moved to anywhere in the image
  double min_tilt_deg = 0;   // between the board's normal and the line of sight
  double max_tilt_deg = 50;
  double min_distance_m = 0.8;
  double max_distance_m = 1.4;
};

// A board of 6 x 6 tags of 88 mm, the one of limits.md.
inline Board usual_board() { return make_board(AprilGrid{6, 6, 0.088, 0.3, 0}); }

inline Lens opencv5_lens() {
  return Perspective({900, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0});
}

inline Lens fisheye_lens() { return Fisheye({420, 419, 633, 405, 0.02, -0.01, 0.003, -0.0005}); }

// A pose from which the point `centre` of the board is seen at the given tilt, from a random side.
inline Pose looking_at_board(const Eigen::Vector3d& centre, double tilt_rad, double distance_m,
                             Random& random) {
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d direction = cartesian_from_spherical({1, tilt_rad, azimuth});
  const double roll = random.uniform(0, 2 * std::numbers::pi);
  const Pose camera =
      camera_from_world_looking_at(centre + distance_m * direction, centre,
                                   Eigen::Vector3d(std::cos(roll), std::sin(roll), 0.1));
  return rotation_about_z(random.uniform(-0.5, 0.5)) * camera;
}

inline View observe(const Camera& camera, const Pose& camera_from_world,
                    const std::vector<TargetPoint>& points, const WorldOptions& options,
                    Random& random) {
  View view;
  for (const TargetPoint& point : points) {
    const auto pixel = project(camera.lens, camera_from_world * point.position);
    if (!pixel || !contains(camera.image_size, *pixel)) continue;
    Eigen::Vector2d seen =
        *pixel + options.sigma_px * Eigen::Vector2d(random.normal(), random.normal());
    if (random.uniform() < options.outlier_share)
      seen = {random.uniform(0, camera.image_size.width),
              random.uniform(0, camera.image_size.height)};
    view.observations.push_back({point.id, seen, {}});
  }
  return view;
}

inline Dataset make_world(const Lens& lens, std::uint64_t seed, const WorldOptions& options = {},
                          const Board& board = usual_board()) {
  Random random(seed);
  Dataset dataset;
  dataset.image_size = {1280, 800};
  dataset.boards = {{board, Pose()}};
  dataset.truth = Truth{{lens, dataset.image_size}, "", {}};
  const auto points = target_points(dataset.boards[0].board);
  constexpr double kDegree = std::numbers::pi / 180;
  for (int i = 0; i < options.num_views; ++i) {
    const Eigen::Vector3d centre(0.33 + random.uniform(-0.15, 0.15),
                                 0.33 + random.uniform(-0.15, 0.15), 0);
    const Pose pose = looking_at_board(
        centre, kDegree * random.uniform(options.min_tilt_deg, options.max_tilt_deg),
        random.uniform(options.min_distance_m, options.max_distance_m), random);
    View view = observe(dataset.truth->camera, pose, points, options, random);
    view.image = std::to_string(i) + ".png";
    dataset.truth->camera_from_world[view.image] = pose;
    dataset.views.push_back(view);
  }
  return dataset;
}

// Points about the origin: the corners of a tag, and of the usual board.
inline std::vector<Eigen::Vector3d> tag_points(double side_m) {
  const auto corners = tag_corners({0, side_m, Pose()});
  return {corners.begin(), corners.end()};
}
inline std::vector<Eigen::Vector3d> board_points() {
  std::vector<Eigen::Vector3d> points;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TargetPoint& p : target_points(usual_board())) {
    points.push_back(p.position);
    sum += p.position;
  }
  for (Eigen::Vector3d& p : points) p -= sum / static_cast<double>(points.size());
  return points;
}

// Random points in a box about the origin; a thickness of 0 is a plane.
inline std::vector<Eigen::Vector3d> points_in_box(int count, double half_width_m, double thickness,
                                                  Random& random) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i)
    points.push_back(half_width_m * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1),
                                                    thickness * random.uniform(-1, 1)));
  return points;
}

// A pinhole with square pixels and its principal point in the centre of the image.
inline Lens centred_pinhole(double focal_px, const ImageSize& size = {1280, 800}) {
  const Eigen::Vector2d centre = image_centre(size);
  return pinhole(focal_px, focal_px, centre.x(), centre.y());
}

// The pixels of the points. All must be in the lens' domain (std::bad_optional_access).
inline std::vector<Correspondence> seen_by(const Lens& lens,
                                           const std::vector<Eigen::Vector3d>& points,
                                           const Pose& camera_from_target, double sigma_px,
                                           Random& random) {
  std::vector<Correspondence> result;
  for (const Eigen::Vector3d& p : points)
    result.push_back({p, project(lens, camera_from_target * p).value() +
                             sigma_px * Eigen::Vector2d(random.normal(), random.normal())});
  return result;
}

// Squared errors of a pose, normalised by the covariance that was claimed.
inline double normalised_squared_error(const PoseHypothesis& estimate, const Pose& truth) {
  const Vector6d error = minus(estimate.camera_from_target, truth);
  return error.dot(Eigen::MatrixXd(estimate.covariance).ldlt().solve(error));
}

// Squared errors of the free parameters, normalised by the covariance that was claimed.
inline double normalised_squared_error(const Model& model, const Lens& estimate, const Lens& truth,
                                       const Eigen::MatrixXd& covariance) {
  const auto a = model.free_values(estimate), b = model.free_values(truth);
  const Eigen::VectorXd error = Eigen::Map<const Eigen::VectorXd>(a.data(), model.num_free()) -
                                Eigen::Map<const Eigen::VectorXd>(b.data(), model.num_free());
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace tagcal
