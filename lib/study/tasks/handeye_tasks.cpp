#include "study/tasks/handeye_tasks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/handeye/handeye_bundle.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/geometry/viewpoint.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ImageSize kHandeyeImage = {1280, 800};

Vector6d normal_step(Random& random, double rad, double m) {
  Vector6d step;
  for (int i = 0; i < 6; ++i) step[i] = random.normal() * (i < 3 ? rad : m);
  return step;
}

Pose random_place(Random& random, double m) {
  Vector3d axis(random.normal(), random.normal(), random.normal());
  return {exp_rotation(random.uniform(0, std::numbers::pi) * axis.normalized()),
          m * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1))};
}

// The camera before the board: at a distance on a line of sight through the board's middle, turned
// about one axis in space and, by the spread, about the two others.
class CameraPoses {
 public:
  CameraPoses(const HandeyeKind& kind, const Vector3d& centre, Random& random)
      : kind_(kind), centre_(centre) {
    Vector3d axis(random.normal(), random.normal(), random.normal());
    axes_ = rotation_between(Vector3d::UnitX(), axis).toRotationMatrix();
    const double tilt = random.uniform(0, 0.4), side = random.uniform(0, 2 * std::numbers::pi);
    first_ = camera_from_world_looking_at(centre + cartesian_from_spherical({1, tilt, side}),
                                          centre, Vector3d(0.1, 1, 0.05))
                 .rotation();
  }

  Pose draw(Random& random) const {
    const double across = kind_.turn_rad * std::tan(kind_.axis_spread_rad);
    const Vector3d turn = axes_ * Vector3d(kind_.turn_rad * random.normal(),
                                           across * random.normal(), across * random.normal());
    const Eigen::Quaterniond rotation = exp_rotation(turn) * first_;
    const Vector3d board_in_camera(random.uniform(-0.12, 0.12), random.uniform(-0.08, 0.08),
                                   random.uniform(0.5, 1.1));
    return Pose(rotation, board_in_camera) * translation(-centre_);
  }

 private:
  HandeyeKind kind_;
  Vector3d centre_;
  Eigen::Matrix3d axes_;
  Eigen::Quaterniond first_;
};

ViewCorrespondences seen_corners(const Camera& camera, const Pose& camera_from_board,
                                 const std::vector<TargetPoint>& points, const HandeyeKind& kind,
                                 Random& random) {
  ViewCorrespondences seen;
  for (const TargetPoint& point : points) {
    const auto pixel =
        project(camera.lens, camera_from_board * (kind.board_scale * point.position));
    if (!pixel || !contains(camera.image_size, *pixel)) continue;
    seen.ids.push_back(point.id);
    seen.correspondences.push_back(
        {point.position, *pixel + kind.sigma_px * Vector2d(random.normal(), random.normal())});
  }
  return seen;
}

// The lens as a calibration of good views knows it.
UncertainCamera known_camera(const Camera& truth, bool exactly, Random& random) {
  if (exactly) return {nullptr, truth, {}};
  const Model& model = Model::named("f+c");
  const Vector3d sigma(1, 0.7, 0.7);  // px
  const Vector3d error =
      sigma.cwiseProduct(Vector3d(random.normal(), random.normal(), random.normal()));
  const auto values = parameters(truth.lens);
  Camera known = truth;
  known.lens = pinhole(values[0] + error[0], values[1] + error[0], values[2] + error[1],
                       values[3] + error[2]);
  return {&model, known, MatrixX(sigma.cwiseAbs2().asDiagonal())};
}

Pose mistaken(RobotMistake mistake, const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  switch (mistake) {
    case RobotMistake::inverse:
      return pose.inverse();
    case RobotMistake::millimetres:
      return {q, 1e3 * pose.translation()};
    case RobotMistake::quaternion_order:
      return {Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()), pose.translation()};
    default:
      return pose;
  }
}

void add_robot_mistakes(const HandeyeKind& kind, Random& random, std::vector<HandeyeView>& views) {
  for (int i = 0; i < std::min(kind.num_wrong, static_cast<int>(views.size())); ++i) {
    const Vector3d side(random.normal(), random.normal(), random.normal());
    Pose& wrong = views[static_cast<std::size_t>(i)].base_from_hand;
    wrong = translation(kind.wrong_m * side.normalized()) * wrong;
  }
  for (HandeyeView& view : views) view.base_from_hand = mistaken(kind.mistake, view.base_from_hand);
  if (kind.mistake != RobotMistake::shifted) return;
  for (std::size_t i = 0; i + 1 < views.size(); ++i)
    views[i].base_from_hand = views[i + 1].base_from_hand;
  views.pop_back();
}

}  // namespace

HandeyeTask draw_handeye(const HandeyeKind& kind, Random& random) {
  HandeyeTask task;
  task.mount = kind.mount;
  task.robot_sigma_m = kind.robot_sigma_m;
  task.robot_sigma_rad = kind.robot_sigma_rad;
  task.sigma_px = kind.sigma_px;
  task.mount_from_camera = random_place(random, kind.mount == CameraMount::hand ? 0.15 : 1.0);
  task.holder_from_board = random_place(random, kind.mount == CameraMount::hand ? 1.0 : 0.15);
  const std::vector<TargetPoint> points = target_points(make_board(AprilGrid{4, 4, 0.06, 0.3, 0}));
  Vector3d centre = Vector3d::Zero();
  for (const TargetPoint& p : points) centre += p.position / static_cast<double>(points.size());
  const double f = random.uniform(800, 1000);
  const Camera truth{pinhole(f, f, 640 + random.uniform(-9, 9), 400 + random.uniform(-9, 9)),
                     kHandeyeImage};
  task.camera = known_camera(truth, kind.known_lens, random);
  const CameraPoses poses(kind, centre, random);
  constexpr int kTries = 10000;        // a limit of work: most poses see the board
  constexpr std::size_t kFewest = 24;  // corners of a view, of 64
  double distances = 0;
  for (int i = 0; i < kTries && std::ssize(task.views) < kind.num_poses; ++i) {
    const Pose camera_from_board = poses.draw(random);
    // From behind nothing is seen, and from the side little.
    const Vector3d eye = camera_from_board.inverse().translation() - centre;
    if (!(eye.normalized().z() > 0.35)) continue;
    HandeyeView view;
    view.image = std::to_string(task.views.size());
    view.seen = seen_corners(truth, camera_from_board, points, kind, random);
    if (view.seen.ids.size() < kFewest) continue;
    distances += eye.norm();
    const Pose hand = internal::base_from_hand({task.mount_from_camera, task.holder_from_board},
                                               kind.mount, camera_from_board);
    task.base_from_hand.push_back(hand);
    view.base_from_hand =
        retract(hand, normal_step(random, kind.robot_sigma_rad, kind.robot_sigma_m));
    task.views.push_back(std::move(view));
  }
  task.distance_m = distances / static_cast<double>(task.views.size());
  add_robot_mistakes(kind, random, task.views);
  return task;
}

Eigen::MatrixXd handeye_bound(const HandeyeTask& task) {
  constexpr double kLeast = 1e-6;  // m, rad, px: of an exact robot, or exact corners
  internal::HandeyeProblem problem;
  problem.mount = task.mount;
  problem.camera = task.camera;
  problem.scale.distance_m = task.distance_m;
  internal::HandeyeState truth{{task.mount_from_camera, task.holder_from_board}, {}, 0};
  for (std::size_t i = 0; i < task.views.size(); ++i) {
    internal::HandeyeSight sight;
    sight.corners = internal::inlier_view(task.views[i].seen.correspondences, {}, {},
                                          std::max(kLeast, task.sigma_px));
    sight.base_from_hand = task.base_from_hand[i];
    truth.base_from_hand.push_back(task.base_from_hand[i]);
    problem.sights.push_back(std::move(sight));
  }
  const internal::RobotNoise noise{std::max(kLeast, task.robot_sigma_rad),
                                   std::max(kLeast, task.robot_sigma_m)};
  const auto covariance = internal::covariance_at(problem, truth, noise);
  return covariance ? Eigen::MatrixXd(covariance->topLeftCorner<6, 6>()) : Eigen::MatrixXd();
}

}  // namespace tagcal::study
