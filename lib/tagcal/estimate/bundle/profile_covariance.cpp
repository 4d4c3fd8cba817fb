#include "tagcal/estimate/bundle/profile_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tagcal/estimate/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRounds = 4;

double focal_px(const Bundle& bundle) { return parameters(bundle.lens())[0]; }

// Index of the focal length or coordinate of the principal point with the largest variance; -1 if
// none is free.
Index least_known_parameter(const Model& model, const MatrixXd& covariance) {
  Index least = -1;
  for (Index i = 0; i < model.num_free(); ++i) {
    const ParameterKind kind = model.free()[static_cast<std::size_t>(i)].kind();
    const bool is_pinhole =
        kind == ParameterKind::focal_length || kind == ParameterKind::principal_point;
    if (is_pinhole && (least < 0 || covariance(i, i) > covariance(least, least))) least = i;
  }
  return least;
}

// Refines all poses for the lens; false if a view has no pose.
bool refine_poses(Bundle& bundle, double& cost) {
  const Lens lens = bundle.lens();
  cost = 0;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto refined = refine_view_pose(bundle.views[v], lens, bundle.camera_from_target[v]);
    if (!refined) return false;
    bundle.camera_from_target[v] = refined->camera_from_target;
    cost += refined->cost;
  }
  return true;
}

// A point of the profile: its offset from the tangent, and its cost above the minimum.
struct ProfilePoint {
  VectorXd offset;
  double rise = 0;
};

class CurvedProfile {
 public:
  CurvedProfile(const Bundle& solved, const BundleInformation& information,
                const MatrixXd& covariance)
      : solved_(solved), information_(information) {
    least_ = least_known_parameter(*solved.model, covariance);
    if (least_ < 0) return;
    sigma_ = std::sqrt(covariance(least_, least_));
    tangent_ = covariance.col(least_) / sigma_;
    least_cost_ = cost_of(solved);
  }

  double sigma() const { return least_ < 0 ? 0 : sigma_; }
  const VectorXd& tangent() const { return tangent_; }

  // The point at `along` standard deviations of the least known parameter. No value if a point
  // leaves the domain of the lens.
  std::optional<ProfilePoint> at(double along) const {
    const Index k = tangent_.size();
    Bundle bundle = solved_;
    const VectorXd step = along * tangent_;
    for (std::size_t v = 0; v < bundle.views.size(); ++v)
      bundle.camera_from_target[v] = retract(
          solved_.camera_from_target[v], -information_.pose_by_parameters[v].leftCols(k) * step);
    ProfilePoint point{VectorXd::Zero(k), 0};
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Map<VectorXd>(bundle.free_values.data(), k) =
          Eigen::Map<const VectorXd>(solved_.free_values.data(), k) + step + point.offset;
      if (!bundle.model->lens(bundle.free_values, bundle.image_size)) return std::nullopt;
      if (!refine_poses(bundle, point.rise)) return std::nullopt;
      const auto information = bundle_information(bundle);
      if (!information) return std::nullopt;
      minimise_others(*information, point);
    }
    point.rise -= least_cost_;
    return point;
  }

 private:
  // Adds a Gauss-Newton step of all parameters other than the least known one.
  void minimise_others(const BundleInformation& information, ProfilePoint& point) const {
    const Index k = tangent_.size();
    std::vector<Index> others;
    for (Index i = 0; i < k; ++i)
      if (i != least_) others.push_back(i);
    if (others.empty()) return;
    const MatrixXd s = (information.halves[0] + information.halves[1])(others, others);
    const VectorXd gradient = (information.gradients[0] + information.gradients[1])(others);
    const VectorXd scale = s.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd unit = scale.asDiagonal() * s * scale.asDiagonal();
    const VectorXd solution = unit.ldlt().solve(scale.cwiseProduct(gradient));
    const VectorXd step = -scale.cwiseProduct(solution);
    point.offset(others) += step;
    point.rise += gradient.dot(step);
  }

  const Bundle& solved_;
  const BundleInformation& information_;
  Index least_ = -1;
  double sigma_ = 0, least_cost_ = 0;
  VectorXd tangent_;
};

}  // namespace

std::optional<MatrixXd> profile_covariance(const Bundle& solved,
                                           const BundleInformation& information,
                                           const MatrixXd& covariance, double sigma) {
  const CurvedProfile profile(solved, information, covariance);
  if (!(profile.sigma() > policy::kLinearShare * focal_px(solved))) return std::nullopt;
  MatrixXd widened = covariance;
  double slower = 1;  // predicted rise of the cost over the true one
  for (const double along : {-policy::kProfileBundleSigmas, policy::kProfileBundleSigmas}) {
    const auto point = profile.at(along);
    if (!point || !point->offset.allFinite()) return std::nullopt;
    widened += policy::kTangentDistanceWeight * point->offset * point->offset.transpose();
    const double rise = std::max(point->rise, 1e-300);  // numeric: no division by zero
    slower = std::max(slower, along * along * sigma * sigma / rise);
  }
  widened += (slower - 1) * profile.tangent() * profile.tangent().transpose();
  return widened;
}

}  // namespace tagcal::internal
