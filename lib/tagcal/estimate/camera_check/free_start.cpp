#include "tagcal/estimate/camera_check/free_start.hpp"

#include "tagcal/estimate/calibration/model_error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/check_policy.hpp"
#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/estimate/pose/robust_pose.hpp"

namespace tagcal::internal {
std::vector<WholeView> whole_views(const CalibrationInput& input, const Camera& camera,
                                   std::vector<Finding>& findings) {
  std::vector<WholeView> views;
  for (const CalibrationView& prepared : input.views) {
    const std::span<const Correspondence> corners(prepared.problem.correspondences.data(),
                                                  prepared.problem.correspondences.size());
    const RobustPose<6> pose = fit_pose_robustly<6>(corners, camera.lens, {});
    if (!pose.fit || pose.fit->poses.size() != 1) {
      add(findings, code::view_unusable,
          prepared.name() + (pose.fit ? ": not used, it fits two poses"
                                      : ": not used, its corners agree on no pose"));
      continue;
    }
    WholeView& view = views.emplace_back();
    view.index = prepared.index;
    view.pose = pose.camera_from_target();
    view.corners.assign(corners.begin(), corners.end());
    view.inlier.assign(corners.size(), 1);
    for (const std::size_t i : pose.outliers) view.inlier[i] = 0;
    for (std::size_t i = 0; i < corners.size(); ++i)
      view.covariance_px2.push_back(input.whitened ? covariance_of(prepared.problem.whitening[i])
                                                   : Matrix2(Matrix2::Identity()));
  }
  return views;
}

Bundle free_bundle(const UncertainCamera& known, const Dataset& data) {
  Bundle bundle;
  const bool has_model = known.model && known.model->contains(known.camera);
  bundle.model = has_model ? known.model : &full_model(known.camera.lens);
  bundle.image_size = known.camera.image_size;
  bundle.free_values = bundle.model->free_values(known.camera.lens);
  bundle.board = flat_board(data);
  bundle.known_lens =
      KnownLens{Eigen::VectorXd::Map(bundle.free_values.data(), std::ssize(bundle.free_values)),
                lens_prior(*bundle.model, bundle.free_values, bundle.image_size).by_parameters /
                    policy::kChangeShare};
  return bundle;
}

}  // namespace tagcal::internal
