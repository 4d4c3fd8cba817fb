#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "tagcal/estimate/bundle/flat_board.hpp"
#include "tagcal/estimate/handeye/handeye_chain.hpp"

namespace tagcal::internal {

// The bundle of a hand-eye calibration: both places, all robot poses, one offset of time and
// the scale of the board minimise
//   sum |whitened residuals of the corners|^2 + sum |error of a robot pose|^2 by its noise,
// and the noise itself maximises the likelihood with all of these integrated out (restricted
// maximum likelihood), by Laplace's approximation.

// Standard deviations of a robot's pose per axis.
struct RobotNoise {
  double sigma_rad = 0, sigma_m = 0;

  Vector6d weights() const;
};

struct HandeyeProblem {
  CameraMount mount = CameraMount::hand;
  UncertainCamera camera;  // of poses: the covariance of what they share, without a model
  std::vector<HandeyeSight> sights;
  HandeyeScale scale;
  // Prior of the logarithm of the board's scale: standard deviation about zero.
  double board_scale_sigma = sigma_of_scale(sigma_of_print(Material::paper));
  bool with_time = false;  // the offset is a parameter: sights have velocities
};

struct HandeyeState {
  HandeyePlaces places;
  std::vector<Pose> base_from_hand;  // by sight
  double time_offset_s = 0;
  // The board's lengths as the robot measures them, over those of its file; corners and own poses
  // are in lengths of the file.
  double log_board_scale = 0;
};

// The pose of a view's board in the lengths of its file: all that a picture shows.
Pose camera_from_board(const HandeyeProblem& problem, const HandeyeState& state, std::size_t view);

// The normal equations at a state, without the robot's noise. Parameters that the views share:
// (omega, tau) of mount_from_camera and of holder_from_board; the offset, which keeps a variance of
// 1 and depends on nothing if it is no parameter: the sizes are known when this is compiled; and
// the logarithm of the board's scale.
class HandeyeEquations {
 public:
  // No value if a corner is outside of the lens' domain.
  static std::optional<HandeyeEquations> at(const HandeyeProblem& problem,
                                            const HandeyeState& state);

  // Parameters that all views share: two places of 6 each, offset of time, board's scale.
  static constexpr int kTime = 12, kScale = 13, kShared = 14;
  using Shared = Eigen::Matrix<double, kShared, 1>;
  using SharedSquare = Eigen::Matrix<double, kShared, kShared>;

  struct Solution {
    double objective = 0;  // -2 log of the restricted likelihood, with the prior of the noise
    double cost = 0;       // sum of squares at the state, not after the step
    double decrease = 0;   // of it, by the step
    Shared step;           // of the shared parameters
    SharedSquare covariance;
  };
  // Steps hold the camera's translation in directions of a larger standard deviation.
  void hold_translation(double sigma_m) { held_from_m_ = sigma_m; }
  // No value if the equations are singular.
  std::optional<Solution> solve(const RobotNoise& noise) const;
  HandeyeState stepped(const HandeyeState& state, const RobotNoise& noise,
                       const Shared& step) const;
  // The step of the shared parameters by the lens' free parameters.
  Eigen::MatrixXd response_to_lens(const RobotNoise& noise, const SharedSquare& covariance) const;

 private:
  using SixByShared = Eigen::Matrix<double, 6, kShared>;
  struct OfView {
    Matrix6 information = Matrix6::Zero();  // of the robot's pose, by the corners
    SixByShared by_shared;                  // robot's pose, shared parameters
    Vector6d gradient;
    Vector6d error;  // of the robot's pose
    Vector6d velocity;
    Eigen::MatrixXd by_lens;         // robot's pose, lens
    Eigen::MatrixXd shared_by_lens;  // shared parameters, lens
  };
  void add(const HandeyeProblem& problem, const HandeyeState& state, std::size_t view,
           const Eigen::MatrixXd& gram);
  void add_priors(const HandeyeProblem& problem, const HandeyeState& state);
  SixByShared coupling(const OfView& view, const Vector6d& weights) const;

  std::vector<OfView> views_;
  SharedSquare shared_;     // information of the shared parameters, by corners and priors
  Shared shared_gradient_;  // as `gradient`
  double corners_cost_ = 0;
  double held_from_m_ = std::numeric_limits<double>::infinity();
};

// The noise that maximises the restricted likelihood of the equations, from `start`; and the
// covariance of the logarithms (rad, m).
struct NoiseEstimate {
  RobotNoise noise;
  Eigen::Matrix2d log_covariance = Eigen::Matrix2d::Zero();
};
std::optional<NoiseEstimate> estimate_noise(const HandeyeEquations& equations,
                                            const RobotNoise& start);

// The covariance of the shared parameters at a state, with that of the lens.
std::optional<Eigen::MatrixXd> covariance_at(const HandeyeProblem& problem,
                                             const HandeyeState& state, const RobotNoise& noise);

struct HandeyeMinimum {
  HandeyeState state;
  NoiseEstimate noise = {};
  bool converged = false;
  double objective = 0;             // HandeyeEquations::Solution
  Eigen::MatrixXd covariance = {};  // of the shared parameters, with the lens', not widened
  // Degrees of freedom of that covariance (Satterthwaite 1946), for mount_from_camera.
  double degrees_of_freedom = 0;
};
std::optional<HandeyeMinimum> minimise_bundle(const HandeyeProblem& problem, HandeyeState start,
                                              const RobotNoise& noise);

// The error of a robot's pose at a state (`retract` of what the robot says).
Vector6d robot_error(const HandeyeProblem& problem, const HandeyeState& state, std::size_t view);

}  // namespace tagcal::internal
