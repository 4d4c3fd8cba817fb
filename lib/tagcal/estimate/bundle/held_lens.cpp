#include "tagcal/estimate/bundle/held_lens.hpp"

#include <Eigen/LU>

#include "tagcal/estimate/bundle/covariance.hpp"

namespace tagcal::internal {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// The parameters' step for one of the logarithm of the focal length.
VectorXd by_log_focal(const UncertainCamera& camera) {
  const std::vector<double> values = camera.model->free_values(camera.camera.lens);
  VectorXd step = VectorXd::Zero(camera.num_free());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (camera.model->parameter(i).role == ParameterRole::focal_length)
      step[static_cast<Index>(i)] = values[i];
  return step;
}

}  // namespace

std::optional<LensResponse> lens_response(const ViewProblem& view, const UncertainCamera& camera,
                                          const Pose& camera_from_target, bool free_focal) {
  const auto of_view =
      information_of(view, camera.camera.lens, *camera.model, camera_from_target, {});
  if (!of_view) return std::nullopt;
  if (!free_focal)
    return LensResponse{-of_view->pose_by_parameters, of_view->schur, of_view->gradient};
  // The focal length is the first of the parameters to be eliminated after the pose.
  const VectorXd focal = by_log_focal(camera);
  const VectorXd column = of_view->schur * focal;
  const double information = focal.dot(column);
  if (!(information > 0)) return std::nullopt;
  const Index k = camera.num_free();
  const MatrixXd focal_by_lens = -column.transpose() / information;
  const MatrixXd lens_by_lens = MatrixXd::Identity(k, k) + focal * focal_by_lens;
  LensResponse response;
  response.by_lens.resize(7, k);
  response.by_lens << -of_view->pose_by_parameters * lens_by_lens, focal_by_lens;
  response.information = of_view->schur * lens_by_lens;
  response.gradient = lens_by_lens.transpose() * of_view->gradient;
  return response;
}

MatrixXd learned_covariance(const LensResponse& response, const MatrixXd& prior) {
  // The inverse of prior^-1 + information, for a singular prior as well.
  const Index k = prior.rows();
  const MatrixXd covariance =
      (MatrixXd::Identity(k, k) + prior * response.information).partialPivLu().solve(prior);
  const VectorXd mean = -covariance * response.gradient;
  return (covariance + covariance.transpose()) / 2 + mean * mean.transpose();
}

}  // namespace tagcal::internal
