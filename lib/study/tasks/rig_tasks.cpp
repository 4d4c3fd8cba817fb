#include "study/tasks/rig_tasks.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <numbers>

#include "tagcal/camera/batch.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRigSigmaPx = 0.2;  // of a coordinate: that of a good detector
constexpr ImageSize kRigImage = {1280, 800};
const Vector3d kBoardCentre(0.33, 0.33, 0);
constexpr int kSecondBoard = 200;       // its first tag
constexpr int kGridPoints = 12;         // across
constexpr double kGridSpacingM = 0.06;  // 0.66 m across, as the board of tags

Pose before_the_board(double spread, Random& random) {
  const Vector3d centre =
      kBoardCentre + spread * Vector3d(random.uniform(-0.25, 0.25), random.uniform(-0.25, 0.25), 0);
  const Vector3d direction = cartesian_from_spherical(
      {1, spread * random.uniform(0, 0.8), random.uniform(0, 2 * std::numbers::pi)});
  const double roll = spread * random.uniform(-std::numbers::pi, std::numbers::pi);
  return camera_from_world_looking_at(
      centre + (1.1 + spread * random.uniform(-0.3, 0.4)) * direction, centre,
      Vector3d(std::cos(roll), std::sin(roll), 0.1));
}

Vector6d draw_move(double metres, Random& random) {
  Vector6d move = random_step(random, 0.2 * metres, 0);
  move.tail<3>() =
      metres * Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  return move;
}

// The rig before the world by the time in instants.
std::function<Pose(double)> motion_of(const RigKind& kind, Random& random) {
  if (kind.late != 0) return steady_motion(before_the_board(0.5, random), kBoardCentre, random);
  std::vector<Pose> stills;
  const Pose first = before_the_board(0.25, random);
  for (int t = 0; t < kind.num_instants; ++t) {
    Vector6d step = random_step(random, kind.other_turns, 0.15);
    step[0] = random.uniform(-0.5, 0.5);
    if (kind.other_turns == 0) step[3] = 0;  // a wheel does not move along its axis
    stills.push_back(kind.is_wheel ? exp_pose(step) * first
                                   : before_the_board(kind.spread, random));
  }
  return [stills](double t) { return stills[static_cast<std::size_t>(t)]; };
}

Board regular_grid() {
  Points grid;
  for (int i = 0; i < kGridPoints * kGridPoints; ++i)
    grid.points.push_back(
        {{i, 0}, {kGridSpacingM * (i % kGridPoints), kGridSpacingM * (i / kGridPoints), 0}});
  return make_board(grid);
}

std::vector<PlacedBoard> boards_of(const RigKind& kind, const Pose& second_from_first,
                                   const Pose& first_look, Random& random) {
  const Board first = kind.is_grid ? regular_grid() : make_board(AprilGrid{6, 6, 0.088, 0.3, 0});
  if (!kind.is_wheel) return {{first, Pose()}};
  // The second board stands where the second camera looks at first.
  return {{first, Pose()},
          {make_board(AprilGrid{6, 6, 0.088, 0.3, kSecondBoard}),
           first_look.inverse() * second_from_first.inverse() *
               retract(first_look, random_step(random, 0.1, 0.05))}};
}

View seen_by(const Camera& camera, const Pose& camera_from_world,
             const std::vector<PlacedBoard>& boards, Random& random) {
  View view;
  for (const auto& [id, x] : points_in_world(boards)) {
    const auto pixel = project(camera.lens, camera_from_world * x);
    const Vector2d noise = kRigSigmaPx * Vector2d(random.normal(), random.normal());
    if (pixel && contains(camera.image_size, *pixel))
      view.observations.push_back({id, *pixel + noise, {}});
  }
  return view;
}

// Steps of a point by that of the pose that moves it.
Eigen::Matrix<double, 3, 6> point_by_pose(const Vector3d& turned) {
  Eigen::Matrix<double, 3, 6> by;
  by << -cross_matrix(turned), Eigen::Matrix3d::Identity();
  return by;
}

// The unknowns of rig_information(): places of the cameras, then lenses, then places of the boards,
// but the first ones.
struct Unknowns {
  const std::vector<FreeParameter>& free = Model::named("opencv5").free();
  Index places, of_boards, size;

  explicit Unknowns(const RigTask& task) {
    const auto n = std::ssize(task.rig.cameras);
    places = 6 * (n - 1);
    of_boards = places + of_lens() * n;
    size = of_boards + 6 * (std::ssize(task.rig.cameras.front().data.boards) - 1);
  }
  Index of_lens() const { return std::ssize(free); }
};

// The derivatives of the pixels of a view by the pose of the rig and by the unknowns.
struct ViewRows {
  MatrixXd by_pose, by_all;
};

ViewRows rows_of(const RigTask& task, std::size_t t, std::size_t camera, const Unknowns& unknowns) {
  const Pose &rig_from_world = task.rig_from_world[t],
             &camera_from_rig = task.rig.truth->camera_from_rig[camera];
  const Dataset& data = task.rig.cameras[camera].data;
  const auto& seen = data.views[*task.rig.instants[t].view[camera]].observations;
  const auto points = points_in_world(data.boards);
  std::vector<Vector3d> x;
  for (const Observation& o : seen) x.push_back(rig_from_world * points.at(o.id));
  const auto m = std::ssize(x), k = unknowns.of_lens(), at = static_cast<Index>(camera);
  std::vector<Vector2d> pixels(x.size());
  std::vector<std::uint8_t> valid(x.size());
  using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMajorX by_camera(2 * m, 6), by_free(2 * m, k);
  project_with_jacobians(data.truth->camera.lens, camera_from_rig, x, unknowns.free,
                         {pixels,
                          valid,
                          {by_camera.data(), static_cast<std::size_t>(12 * m)},
                          {by_free.data(), static_cast<std::size_t>(2 * m * k)}});
  ViewRows rows{MatrixXd(2 * m, 6), MatrixXd::Zero(2 * m, unknowns.size)};
  for (Index i = 0; i < m; ++i) {
    const auto p = static_cast<std::size_t>(i);
    // The last three columns are those of the point in the camera.
    const Eigen::Matrix<double, 2, 3> by_x =
        by_camera.block<2, 3>(2 * i, 3) * camera_from_rig.rotation_matrix();
    rows.by_pose.middleRows<2>(2 * i) = by_x * point_by_pose(x[p] - rig_from_world.translation());
    if (seen[p].id.tag_id >= kSecondBoard)
      rows.by_all.block<2, 6>(2 * i, unknowns.of_boards) =
          by_x * rig_from_world.rotation_matrix() *
          point_by_pose(rig_from_world.inverse() * x[p] -
                        data.boards[1].world_from_board.translation());
  }
  if (camera > 0) rows.by_all.middleCols<6>(6 * (at - 1)) = by_camera;
  rows.by_all.middleCols(unknowns.places + k * at, k) = by_free;
  return rows;
}

}  // namespace

Vector6d random_step(Random& random, double rad, double m) {
  Vector6d step;
  for (int i = 0; i < 6; ++i) step[i] = random.uniform(-1, 1) * (i < 3 ? rad : m);
  return step;
}

std::function<Pose(double)> steady_motion(const Pose& middle, const Vector3d& centre,
                                          Random& random) {
  const Pose at_centre({1, 0, 0, 0}, centre);
  std::vector<Vector6d> amplitude, phase, rate;
  for (int k = 0; k < 3; ++k) {
    amplitude.push_back(random_step(random, 0.35, 0.12));
    phase.push_back(random_step(random, std::numbers::pi, std::numbers::pi));
    rate.push_back(random_step(random, 0.35, 0.35));
  }
  return [=](double t) {
    Vector6d step = Vector6d::Zero();
    for (int k = 0; k < 3; ++k)
      step.array() +=
          amplitude[k].array() *
          (rate[k].array() * t + phase[k].array()).unaryExpr([](double x) { return std::sin(x); });
    return middle * at_centre * exp_pose(step) * at_centre.inverse();
  };
}

Lens draw_rig_lens(Random& random) {
  const double f = random.uniform(800, 1000);
  return Perspective({f, f * 1.001, 640 + random.uniform(-9, 9), 400 + random.uniform(-9, 9),
                      random.uniform(-0.2, 0), 0.05, 0, 0, 0});
}

RigTask draw_rig(const RigKind& kind, Random& random) {
  RigTask task{{}, kRigSigmaPx, {}};
  RigDataset& rig = task.rig;
  rig.truth.emplace();
  rig.instants.resize(static_cast<std::size_t>(kind.num_instants));
  const auto rig_from_world = motion_of(kind, random);
  for (int t = 0; t < kind.num_instants; ++t) task.rig_from_world.push_back(rig_from_world(t));
  const Pose half_turn(exp_rotation({0, std::numbers::pi, 0}), {0.1, 0.02, 0.15});
  const std::vector<PlacedBoard> boards =
      boards_of(kind, half_turn, task.rig_from_world.front(), random);
  for (int c = 0; c < kind.num_cameras; ++c) {
    const bool is_last = c + 1 == kind.num_cameras;
    RigCamera camera{"cam" + std::to_string(c), {}, {}};
    camera.data = {kRigImage, boards, {}, Truth{{draw_rig_lens(random), kRigImage}, "", {}}};
    const Pose place = c == 0          ? Pose()
                       : kind.is_wheel ? half_turn
                                       : retract(Pose(), random_step(random, 0.2, 0.2));
    rig.truth->camera_from_rig.push_back(place);
    rig.truth->time_offset_s.push_back(0);
    const Pose other_place = retract(place, draw_move(kind.moved_m, random));
    for (int t = 0; t < kind.num_instants; ++t) {
      Instant& instant = rig.instants[static_cast<std::size_t>(t)];
      instant.view.resize(static_cast<std::size_t>(kind.num_cameras));
      // The last camera sees the board at the first instants together with the others; later alone.
      const bool is_common = t < kind.common * kind.num_instants || (t % 2 == 0) == is_last;
      if (!is_common && !kind.is_wheel) continue;
      const bool is_moved = is_last && kind.moved_m > 0 && 3 * t >= 2 * kind.num_instants;
      View view =
          seen_by(camera.data.truth->camera,
                  (is_moved ? other_place : place) * rig_from_world(t + (is_last ? kind.late : 0)),
                  boards, random);
      if (view.observations.size() < 16) continue;
      view.image = std::to_string(t);
      instant.view[static_cast<std::size_t>(c)] = camera.data.views.size();
      camera.data.views.push_back(std::move(view));
    }
    rig.cameras.push_back(std::move(camera));
  }
  return task;
}

MatrixXd rig_information(const RigTask& task) {
  const Unknowns unknowns(task);
  const Index places = unknowns.places, size = unknowns.size;
  MatrixXd information = MatrixXd::Zero(size, size);
  for (std::size_t t = 0; t < task.rig.instants.size(); ++t) {
    MatrixXd of_pose = MatrixXd::Zero(6, 6), mixed = MatrixXd::Zero(6, size);
    for (std::size_t c = 0; c < task.rig.cameras.size(); ++c) {
      if (!task.rig.instants[t].view[c]) continue;
      const auto [by_pose, by_all] = rows_of(task, t, c, unknowns);
      information += by_all.transpose() * by_all;
      of_pose += by_pose.transpose() * by_pose;
      mixed += by_pose.transpose() * by_all;
    }
    if (!of_pose.isZero()) information -= mixed.transpose() * of_pose.ldlt().solve(mixed);
  }
  information /= task.sigma_px * task.sigma_px;
  const Eigen::FullPivLU<MatrixXd> rest(
      MatrixXd(information.bottomRightCorner(size - places, size - places)));
  if (!rest.isInvertible()) return {};
  return information.topLeftCorner(places, places) -
         information.topRightCorner(places, size - places) *
             rest.solve(information.bottomLeftCorner(size - places, places));
}

Eigen::VectorXd RigAnswer::error(const RigDataset& rig) const {
  Eigen::VectorXd error(camera_from_first.empty() ? 0 : 6 * (std::ssize(camera_from_first) - 1));
  for (Index c = 1; 6 * c <= error.size(); ++c)
    error.segment<6>(6 * (c - 1)) = minus(rig.truth->camera_from_rig[static_cast<std::size_t>(c)],
                                          camera_from_first[static_cast<std::size_t>(c)]);
  return error;
}

}  // namespace tagcal::study
