#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "worlds.hpp"

// A calibrated camera before new pictures, and changes of it.

namespace tagcal {

inline const Model& kModel = Model::named("opencv5");

// What a calibration of the usual camera knows of it.
inline const MatrixX& usual_covariance() {
  static const MatrixX covariance = [] {
    CalibrateOptions options;
    options.model = "opencv5";
    return calibrate(make_world(opencv5_lens(), 1), options).claim->covariance;
  }();
  return covariance;
}

// A calibration of a true camera, with errors as its covariance says.
inline UncertainCamera calibrated(const Lens& truth, Random& random) {
  static const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{
      Eigen::MatrixXd(usual_covariance())};
  Eigen::VectorXd error(kModel.num_free());
  for (Eigen::Index i = 0; i < error.size(); ++i)
    error[i] = std::sqrt(std::max(0.0, eigen.eigenvalues()[i])) * random.normal();
  error = eigen.eigenvectors() * error;
  std::vector<double> values = kModel.free_values(truth);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += error[static_cast<Eigen::Index>(i)];
  return {&kModel, {*kModel.lens(values, {1280, 800}), {1280, 800}}, usual_covariance()};
}

// The same pictures, with the same noise, by another lens.
inline Dataset taken_by(const Lens& lens, Dataset world) {
  const auto points = points_in_world(world.boards);
  const Camera before = world.truth->camera;
  for (View& view : world.views)
    for (Observation& o : view.observations) {
      const Eigen::Vector3d x = world.truth->camera_from_world.at(view.image) * points.at(o.id);
      o.pixel += *project(lens, x) - *project(before.lens, x);
    }
  return world;
}

// The usual camera after the smallest change of a kind that the pictures of a check show, times a
// factor.
inline Lens changed_lens(const CameraCheck& check, ChangeKind kind, double times) {
  const auto smallest = std::ranges::find(check.detectable, kind, &DetectableChange::kind);
  std::vector<double> values = kModel.free_values(opencv5_lens());
  for (std::size_t j = 0; j < values.size(); ++j) values[j] += times * smallest->step[j];
  return *kModel.lens(values, {1280, 800});
}

}  // namespace tagcal
