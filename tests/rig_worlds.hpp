#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "study/tasks/rig_tasks.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "worlds.hpp"

// Random rigs: cameras on one body, a board that moves before them, and the truth.

namespace tagcal {

using study::random_step;

struct RigWorldOptions {
  int num_cameras = 2;
  int num_instants = 30;
  double sigma_px = 0.2;
  bool with_covariances = false;  // of the corners
  double period_s = 0;            // between the stamps of the instants; 0: no stamps
  bool fisheyes = true;           // some of the cameras have one
  bool smooth = false;            // the board moves steadily from instant to instant
  double seen_share = 1;          // of the instants that a camera has a picture of
  std::vector<double> offset;     // by camera, in instants (smooth motion); empty: none
  // A camera that is somewhere else from the middle of the instants on. The truth is its place in
  // most of its views.
  int moved_camera = -1;
  double moved_m = 0.02;
  double turned_share = 0;  // of the views, whose corners have the board's other order
  bool shuffled = false;    // the last camera's pictures are of other instants
};

// The board before the rig at a time in instants: where it is, and how it is turned.
inline std::function<Pose(double)> board_motion(const RigWorldOptions& options,
                                                const Eigen::Vector3d& centre, Random& random) {
  std::vector<Pose> stills;
  for (int i = 0; i < options.num_instants; ++i)
    stills.push_back(looking_at_board(
        centre + Eigen::Vector3d(random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25), 0),
        random.uniform(0, 0.8), random.uniform(0.8, 1.5), random));
  if (!options.smooth)
    return [stills](double t) { return stills[static_cast<std::size_t>(std::lround(t))]; };
  return study::steady_motion(looking_at_board(centre, 0.3, 1.1, random), centre, random);
}

inline Lens random_rig_lens(int kind, Random& random) {
  if (kind != 1) return study::draw_rig_lens(random);
  const double f = random.uniform(800, 1000);
  return Fisheye({0.45 * f, 0.45 * f, 640 + random.uniform(-9, 9), 400 + random.uniform(-9, 9),
                  0.02, -0.01, 0.003, -0.0005});
}

inline RigDataset make_rig_world(std::uint64_t seed, const RigWorldOptions& options = {},
                                 const Board& board = usual_board()) {
  Random random(seed);
  RigDataset rig;
  rig.truth.emplace();
  const auto points = target_points(board);
  const Eigen::Vector3d centre = (points.front().position + points.back().position) / 2;
  const auto rig_from_world = board_motion(options, centre, random);
  WorldOptions corners;
  corners.sigma_px = options.sigma_px;
  rig.instants.resize(static_cast<std::size_t>(options.num_instants));
  for (int c = 0; c < options.num_cameras; ++c) {
    RigCamera camera;
    camera.name = "cam" + std::to_string(c);
    camera.data.image_size = {1280, 800};
    camera.data.boards = {{board, Pose()}};
    const Lens lens =
        random_rig_lens(options.fisheyes && c % 2 == 1 && random.uniform() < 0.3 ? 1 : 0, random);
    camera.data.truth = Truth{{lens, camera.data.image_size}, "", {}};
    const Pose camera_from_rig = c == 0 ? Pose() : retract(Pose(), random_step(random, 0.2, 0.2));
    rig.truth->camera_from_rig.push_back(camera_from_rig);
    rig.truth->time_offset_s.push_back(0);
    const Pose moved = retract(camera_from_rig, random_step(random, 0.02, options.moved_m));
    int num_moved = 0, num_still = 0;
    for (int t = 0; t < options.num_instants; ++t) {
      auto& instant = rig.instants[static_cast<std::size_t>(t)];
      instant.view.resize(static_cast<std::size_t>(options.num_cameras));
      if (random.uniform() > options.seen_share) continue;
      const bool other = options.shuffled && c + 1 == options.num_cameras;
      const int at = other ? (t * 7 + 3) % options.num_instants : t;
      const double offset =
          options.offset.empty() ? 0 : options.offset[static_cast<std::size_t>(c)];
      const bool is_moved = c == options.moved_camera && t >= options.num_instants / 2;
      const Pose& place = is_moved ? moved : camera_from_rig;
      View view = observe({lens, camera.data.image_size}, place * rig_from_world(at + offset),
                          points, corners, random);
      if (view.observations.size() < 8) continue;
      if (random.uniform() < options.turned_share)
        for (Observation& o : view.observations)
          o.id.tag_id = points.front().id.tag_id + points.back().id.tag_id - o.id.tag_id;
      if (options.with_covariances)
        for (Observation& o : view.observations)
          o.covariance_px2 = options.sigma_px * options.sigma_px * Matrix2::Identity();
      ++(is_moved ? num_moved : num_still);
      view.image = std::to_string(t);
      instant.view[static_cast<std::size_t>(c)] = camera.data.views.size();
      camera.data.views.push_back(std::move(view));
      if (options.period_s > 0) camera.times_s.push_back(t * options.period_s);
    }
    if (num_moved > num_still) rig.truth->camera_from_rig.back() = moved;
    rig.cameras.push_back(std::move(camera));
  }
  return rig;
}

// Two cameras back to back before a board each, on a body that turns about `axes` directions.
inline RigDataset back_to_back(int num_axes, std::uint64_t seed, int num_instants = 30,
                               double sigma_px = 0.1) {
  Random random(seed);
  const Board first = make_board(AprilGrid{6, 6, 0.088, 0.3, 0});
  const Board second = make_board(AprilGrid{6, 6, 0.088, 0.3, 100});
  const Pose half_turn(exp_rotation({0, std::numbers::pi, 0}), {0.1, 0.02, 0.15});
  const Pose seen = looking_at_board({0.33, 0.33, 0}, 0.2, 1.0, random);
  // In the frame of the first board; the second one is where the other camera looks at first.
  const std::vector<PlacedBoard> boards = {
      {first, Pose()},
      {second,
       seen.inverse() * half_turn.inverse() * retract(seen, random_step(random, 0.1, 0.05))}};
  RigDataset rig;
  rig.truth.emplace();
  rig.instants.resize(static_cast<std::size_t>(num_instants));
  WorldOptions corners;
  corners.sigma_px = sigma_px;
  std::vector<Pose> rig_from_world;
  for (int t = 0; t < num_instants; ++t) {
    Vector6d step = Vector6d::Zero();
    for (int i = 0; i < num_axes; ++i) step[i] = random.uniform(-0.5, 0.5);
    step.tail<3>() =
        0.15 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (num_axes == 1) step[3] = 0;  // a wheel does not move along its axis
    // About a point before the first camera, so that both boards stay in view.
    rig_from_world.push_back(exp_pose(step) * seen);
  }
  for (std::size_t c = 0; c < 2; ++c) {
    RigCamera camera;
    camera.name = c == 0 ? "front" : "back";
    camera.data.image_size = {1280, 800};
    camera.data.boards = boards;
    const Pose camera_from_rig = c == 0 ? Pose() : half_turn;
    rig.truth->camera_from_rig.push_back(camera_from_rig);
    std::vector<TargetPoint> points = target_points(boards[c].board);
    for (TargetPoint& p : points) p.position = boards[c].world_from_board * p.position;
    for (std::size_t t = 0; t < rig.instants.size(); ++t) {
      View view = observe({opencv5_lens(), camera.data.image_size},
                          camera_from_rig * rig_from_world[t], points, corners, random);
      view.image = std::to_string(t);
      rig.instants[t].view.resize(2);
      if (view.observations.size() < 30) continue;
      rig.instants[t].view[c] = camera.data.views.size();
      camera.data.views.push_back(view);
    }
    rig.cameras.push_back(camera);
  }
  return rig;
}

inline std::string all_sentences(const RigCalibration& answer) {
  std::string all;
  for (const Finding& f : answer.findings) all += f.code + ": " + f.sentence + "\n";
  return all;
}

// The squared error of all extrinsics in units of their joint covariance, over their number.
inline double nees_of_extrinsics(const RigDataset& rig, const RigCalibration& answer,
                                 std::size_t reference = 0) {
  const auto& truth = rig.truth->camera_from_rig;
  std::vector<Vector6d> errors;
  for (std::size_t c = 0; c < answer.cameras.size(); ++c)
    if (c != reference)
      errors.push_back(
          minus(truth[c] * truth[reference].inverse(), answer.cameras[c].camera_from_rig));
  Eigen::VectorXd error(6 * std::ssize(errors));
  for (std::size_t i = 0; i < errors.size(); ++i)
    error.segment<6>(6 * static_cast<Eigen::Index>(i)) = errors[i];
  const Eigen::MatrixXd c = answer.covariance.topLeftCorner(error.size(), error.size());
  return error.dot(c.ldlt().solve(error)) / static_cast<double>(error.size());
}

}  // namespace tagcal
