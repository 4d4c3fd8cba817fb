#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "tagcal/camera/kernels/projection_rows.hpp"
#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/rig_pairing.hpp"
#include "worlds.hpp"

// Random worlds that a rolling shutter sees.

namespace tagcal {

inline std::vector<CameraVelocity> random_velocities(std::size_t count, double turn_rad_s,
                                                     double move_m_s, Random& random) {
  std::vector<CameraVelocity> velocities(count);
  for (CameraVelocity& v : velocities) {
    for (double& turn : v.turn_rad_s) turn = turn_rad_s * random.normal();
    for (double& move : v.move_m_s) move = move_m_s * random.normal();
  }
  return velocities;
}

// The exact corners of a world's boards from its true poses, each of which is that of a picture's
// middle, while the camera moves with the velocity of the view.
inline Dataset rolling_world(const Dataset& world, const std::vector<CameraVelocity>& velocities,
                             double readout_s, ReadDirection direction = ReadDirection::down) {
  MovingScene scene;
  scene.settings.camera = world.truth->camera;
  scene.settings.num_views = static_cast<int>(world.views.size());
  scene.settings.sensor.shutter.readout_s = readout_s;
  scene.settings.sensor.shutter.direction = direction;
  for (const PlacedBoard& board : world.boards) scene.boards.push_back({kWorldFrame, board});
  scene.velocity = [&](double t) {
    return velocities[static_cast<std::size_t>(
        std::lround(t * static_cast<double>(velocities.size() - 1)))];
  };
  std::vector<Pose> poses;
  for (const View& view : world.views)
    poses.push_back(world.truth->camera_from_world.at(view.image));
  return exact_dataset(scene, poses, nullptr);
}

// A film of the usual board at 30 pictures a second, and the times of its pictures.
struct Film {
  Dataset dataset;
  std::vector<double> times_s;
};

// `pose_at`: the camera's at a time in seconds.
inline Film film_along(const std::function<Pose(double)>& pose_at, double readout_s,
                       ReadDirection direction, int num_views,
                       const std::vector<PlacedBoard>& boards = {{usual_board(), Pose()}}) {
  constexpr double kPeriod = 1.0 / 30;
  MovingScene scene;
  scene.settings.camera = {opencv5_lens(), {1280, 800}};
  scene.settings.num_views = num_views;
  scene.settings.sensor.shutter.readout_s = readout_s;
  scene.settings.sensor.shutter.direction = direction;
  for (const PlacedBoard& board : boards) scene.boards.push_back({kWorldFrame, board});
  scene.period_s = kPeriod;
  scene.settings.path =
      FunctionPath{[=](double share) { return pose_at(share * (num_views - 1) * kPeriod); }, {}};
  Film result{exact_dataset(scene, camera_poses(scene, 1), nullptr), {}};
  for (int i = 0; i < num_views; ++i) result.times_s.push_back(i * kPeriod);
  return result;
}

// A hand's motion: each coordinate is a wave of 0.2 to 0.6 Hz.
inline std::function<Pose(double)> hand_motion(std::uint64_t seed) {
  Random random(seed);
  struct Wave {
    double size, frequency_hz, phase;
    double at(double t) const {
      return size * std::sin(2 * std::numbers::pi * frequency_hz * t + phase);
    }
  };
  std::vector<Wave> waves;  // of the place looked at, the tilts, the distance and the roll
  for (const double size : {0.1, 0.1, 0.6, 0.6, 0.2, 0.3})
    waves.push_back({size, random.uniform(0.2, 0.6), random.uniform(0, 2 * std::numbers::pi)});
  return [waves](double t) {
    const Eigen::Vector3d centre(0.33 + waves[0].at(t), 0.33 + waves[1].at(t), 0);
    const Eigen::Vector3d side(std::tan(waves[2].at(t)), std::tan(waves[3].at(t)), 1);
    const double roll = waves[5].at(t);
    return camera_from_world_looking_at(centre + (1.1 + waves[4].at(t)) * side.normalized(), centre,
                                        Eigen::Vector3d(std::sin(roll), -std::cos(roll), 0));
  };
}

// Half a ring above the board in two seconds, always looking at its middle.
inline Pose ring_motion(double t) {
  const Eigen::Vector3d middle(0.33, 0.33, 0);
  const double angle = std::numbers::pi / 2 * t;
  const Eigen::Vector3d eye =
      middle + Eigen::Vector3d(0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.9);
  return camera_from_world_looking_at(eye, middle, Eigen::Vector3d::UnitZ());
}

// Half a ring in which the camera also rises and falls, by 0.2 m at 0.5 Hz, from a random phase on.
inline std::function<Pose(double)> rising_ring(std::uint64_t seed) {
  const double phase = Random(seed).uniform(0, 2 * std::numbers::pi);
  return [phase](double t) {
    const Eigen::Vector3d middle(0.33, 0.33, 0);
    const double angle = std::numbers::pi / 2 * t;
    const Eigen::Vector3d eye =
        middle + Eigen::Vector3d(0.6 * std::cos(angle), 0.6 * std::sin(angle),
                                 0.9 + 0.2 * std::sin(std::numbers::pi * t + phase));
    return camera_from_world_looking_at(eye, middle, Eigen::Vector3d::UnitZ());
  };
}

inline Film film(std::uint64_t seed, double readout_s, ReadDirection direction, int num_views) {
  return film_along(hand_motion(seed), readout_s, direction, num_views);
}

inline Film ring_film(double readout_s, int num_views) {
  return film_along(ring_motion, readout_s, ReadDirection::down, num_views);
}

inline Dataset with_noise(Dataset dataset, double sigma_px, std::uint64_t seed) {
  for (std::size_t v = 0; v < dataset.views.size(); ++v) {
    Random random(seed, v);
    for (Observation& o : dataset.views[v].observations)
      o.pixel += sigma_px * Eigen::Vector2d(random.normal(), random.normal());
  }
  return dataset;
}

// The films of two cameras on one body that moves so, the second one to the right of the first,
// with their times.
inline RigDataset rig_film(const std::function<Pose(double)>& first_at, double readout_s,
                           int num_views,
                           const std::vector<PlacedBoard>& boards = {{usual_board(), Pose()}}) {
  const Pose place(exp_rotation({0.02, -0.1, 0.01}), {-0.11, 0.005, 0.01});
  RigDataset rig;
  rig.truth = RigTruth{{Pose(), place}, {0, 0}};
  for (const Pose& camera_from_rig : rig.truth->camera_from_rig) {
    Film seen = film_along([=](double t) { return camera_from_rig * first_at(t); }, readout_s,
                           ReadDirection::down, num_views, boards);
    rig.cameras.push_back({"cam" + std::to_string(rig.cameras.size()), std::move(seen.dataset),
                           std::move(seen.times_s)});
  }
  rig.instants = pair_by_index(rig.cameras);
  return rig;
}

inline RigDataset with_noise(RigDataset rig, double sigma_px, std::uint64_t seed) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    rig.cameras[c].data = with_noise(std::move(rig.cameras[c].data), sigma_px, seed + 1000003 * c);
  return rig;
}

// Each view displaces its pixels by its own smooth field, which has no preferred direction: an
// affine one and a bow, of `size_px` along each axis at the border of the image.
inline Dataset with_fields(Dataset dataset, double size_px, std::uint64_t seed) {
  const Eigen::Vector2d centre = image_centre(dataset.image_size);
  for (std::size_t v = 0; v < dataset.views.size(); ++v) {
    Random random(seed, v);
    Eigen::Matrix<double, 2, 5> field;
    for (double& coefficient : field.reshaped()) coefficient = size_px * random.normal();
    for (Observation& o : dataset.views[v].observations) {
      const Eigen::Vector2d x = (o.pixel - centre) / centre.x();
      o.pixel += field * (Eigen::Matrix<double, 5, 1>() << x.x(), x.y(), x.x() * x.x(),
                          x.x() * x.y(), x.y() * x.y())
                             .finished();
    }
  }
  return dataset;
}

// What velocities of a camera show in a world of a global shutter.
class MotionEffect {
 public:
  // Velocities whose standard deviations are `unit`: rad, and m, along each axis during the
  // readout.
  MotionEffect(const Dataset& still, const Vector6d& unit) {
    const auto points = points_in_world(still.boards);
    const Eigen::Vector2d centre = image_centre(still.image_size);
    for (const View& view : still.views) {
      const Pose& pose = still.truth->camera_from_world.at(view.image);
      std::vector<Eigen::Vector3d> seen;
      for (const Observation& o : view.observations) seen.push_back(points.at(o.id));
      const auto rows = internal::projection_rows(still.truth->camera.lens, pose, seen, {});
      const Eigen::MatrixXd by_pose = rows->by_pose;
      const Eigen::MatrixXd by_motion =
          by_pose * internal::step_from_twist(pose) * unit.asDiagonal();
      squares_ += by_motion.squaredNorm();
      count_ += static_cast<double>(seen.size());
      Eigen::MatrixXd effects(by_pose.rows(), 12);  // by row and by column
      for (Eigen::Index i = 0; i < by_pose.rows(); ++i) {
        const auto& pixel = view.observations[static_cast<std::size_t>(i / 2)].pixel;
        const Eigen::Vector2d x = (pixel - centre) / still.image_size.height;
        effects.row(i) << x.y() * by_motion.row(i), x.x() * by_motion.row(i);
      }
      const Eigen::MatrixXd cross = by_pose.transpose() * effects;
      const Eigen::MatrixXd information =
          effects.transpose() * effects -
          cross.transpose() * (by_pose.transpose() * by_pose).ldlt().solve(cross);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
      // Rounding leaves values below 0.
      roots_.push_back(eigen.eigenvectors() *
                       eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
                       eigen.eigenvectors().transpose());
    }
  }

  // The motion of a corner in the image during the readout, root mean square.
  double motion_px() const { return std::sqrt(squares_ / count_); }

  // The expected logarithm of the likelihood ratio of velocities of `scale` times the unit against
  // effects by row and by column of one size, the most likely one: the divergence of Kullback and
  // Leibler for a known lens, free poses and known noise.
  double expected_log_ratio(double scale, double sigma_px) const {
    double least = std::numeric_limits<double>::infinity();
    for (double share = 1; share > 0.3; share *= 0.9)
      least = std::min(least, divergence(scale / sigma_px, share * scale / sigma_px));
    return least;
  }

  // The scale at which that logarithm is z^2 / 2, as for a normal variable that is off by z
  // standard deviations.
  double scale_at(double z, double sigma_px) const {
    double low = 1e-3, high = 1e3;
    for (int i = 0; i < 20; ++i) {
      const double middle = std::sqrt(low * high);
      (expected_log_ratio(middle, sigma_px) < z * z / 2 ? low : high) = middle;
    }
    return low;
  }

 private:
  double divergence(double by_row, double by_both) const {
    double sum = 0;
    for (const Eigen::MatrixXd& root : roots_) {
      const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(12, 12);
      const Eigen::MatrixXd of_rows = root.leftCols(6);
      const Eigen::MatrixXd true_one = identity + by_row * by_row * of_rows * of_rows.transpose();
      const Eigen::MatrixXd other = identity + by_both * by_both * root * root.transpose();
      const Eigen::LLT<Eigen::MatrixXd> llt(other);
      const auto log_volume = [](const Eigen::LLT<Eigen::MatrixXd>& l) {
        return 2 * l.matrixLLT().diagonal().array().log().sum();
      };
      sum += (llt.solve(true_one).trace() - 12 + log_volume(llt) -
              log_volume(Eigen::LLT<Eigen::MatrixXd>(true_one))) /
             2;
    }
    return sum;
  }

  double squares_ = 0, count_ = 0;
  std::vector<Eigen::MatrixXd> roots_;
};

}  // namespace tagcal
