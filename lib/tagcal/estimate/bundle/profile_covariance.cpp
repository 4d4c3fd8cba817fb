#include "tagcal/estimate/bundle/profile_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kWellHeld = 0.01;  // of the focal length
constexpr double kSigmas = 2;       // to which it is followed
constexpr double kBeside = 3;  // of either side; a parabola is 6.25 times as far off at 5 sigma
constexpr int kRounds = 4;

double focal_px(const Bundle& bundle) { return parameters(bundle.lens())[0]; }

// Of the focal lengths and the principal point; -1: there is none.
Index least_known(const Model& model, const MatrixXd& covariance) {
  Index least = -1;
  for (Index i = 0; i < model.num_free(); ++i) {
    const char kind = model.free()[static_cast<std::size_t>(i)].name[0];
    if ((kind == 'f' || kind == 'c') && (least < 0 || covariance(i, i) > covariance(least, least)))
      least = i;
  }
  return least;
}

// The likeliest poses for the lens; false where a view has none.
bool repose(Bundle& bundle, double& cost) {
  const Lens lens = bundle.lens();
  cost = 0;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    const auto refined = refine_pose(bundle.views[v], lens, bundle.camera_from_target[v]);
    if (!refined) return false;
    bundle.camera_from_target[v] = refined->camera_from_target;
    cost += refined->cost;
  }
  return true;
}

// A point of the valley: beside the tangent, and how much higher than its ground.
struct Point {
  VectorXd beside;
  double rise = 0;
};

class Valley {
 public:
  Valley(const Bundle& solved, const BundleInformation& information, const MatrixXd& covariance)
      : solved_(solved), information_(information) {
    least_ = least_known(*solved.model, covariance);
    if (least_ < 0) return;
    sigma_ = std::sqrt(covariance(least_, least_));
    tangent_ = covariance.col(least_) / sigma_;
    ground_ = cost_of(solved);
  }

  double sigma() const { return least_ < 0 ? 0 : sigma_; }
  const VectorXd& tangent() const { return tangent_; }

  // So many standard deviations along.
  std::optional<Point> at(double along) const {
    const Index k = tangent_.size();
    Bundle bundle = solved_;
    const VectorXd moved = along * tangent_;
    for (std::size_t v = 0; v < bundle.views.size(); ++v)
      bundle.camera_from_target[v] = retract(
          solved_.camera_from_target[v], -information_.pose_by_parameters[v].leftCols(k) * moved);
    Point point{VectorXd::Zero(k), 0};
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Map<VectorXd>(bundle.free_values.data(), k) =
          Eigen::Map<const VectorXd>(solved_.free_values.data(), k) + moved + point.beside;
      if (!bundle.model->lens(bundle.free_values, bundle.image_size)) return std::nullopt;
      if (!repose(bundle, point.rise)) return std::nullopt;
      const auto seen = bundle_information(bundle);
      if (!seen) return std::nullopt;
      step_down(*seen, point);
    }
    point.rise -= ground_;
    return point;
  }

 private:
  // A Gauss-Newton step of all parameters but the one that is followed.
  void step_down(const BundleInformation& seen, Point& point) const {
    const Index k = tangent_.size();
    std::vector<Index> others;
    for (Index i = 0; i < k; ++i)
      if (i != least_) others.push_back(i);
    if (others.empty()) return;
    const MatrixXd s = (seen.halves[0] + seen.halves[1])(others, others);
    const VectorXd gradient = (seen.gradients[0] + seen.gradients[1])(others);
    const VectorXd scale = s.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd unit = scale.asDiagonal() * s * scale.asDiagonal();
    const VectorXd solution = unit.ldlt().solve(scale.cwiseProduct(gradient));
    const VectorXd step = -scale.cwiseProduct(solution);
    point.beside(others) += step;
    point.rise += gradient.dot(step);
  }

  const Bundle& solved_;
  const BundleInformation& information_;
  Index least_ = -1;
  double sigma_ = 0, ground_ = 0;
  VectorXd tangent_;
};

}  // namespace

std::optional<MatrixXd> widened_along_valley(const Bundle& solved,
                                             const BundleInformation& information,
                                             const MatrixXd& covariance, double sigma) {
  const Valley valley(solved, information, covariance);
  if (!(valley.sigma() > kWellHeld * focal_px(solved))) return std::nullopt;
  MatrixXd widened = covariance;
  double slower = 1;
  for (const double along : {-kSigmas, kSigmas}) {
    const auto point = valley.at(along);
    if (!point || !point->beside.allFinite()) return std::nullopt;
    widened += kBeside * point->beside * point->beside.transpose();
    slower = std::max(slower, along * along * sigma * sigma / std::max(point->rise, 1e-300));
  }
  widened += (slower - 1) * valley.tangent() * valley.tangent().transpose();
  return widened;
}

}  // namespace tagcal::internal
