#include "tagcal/estimate/bundle/profile_covariance.hpp"

#include <cmath>
#include <vector>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/profile_likelihood.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

// The likelihood of the free parameters of a bundle: the best poses belong to them.
class BundleLikelihood {
 public:
  struct State {
    std::vector<double> free_values;
    std::vector<Pose> poses;
  };
  using Step = VectorXd;
  using Matrix = MatrixXd;
  struct Equations {
    MatrixXd information;
    VectorXd gradient;
    double cost = 0;
  };
  struct Solver {
    bool compute(const MatrixXd& information) {
      inverse = exact_inverse(information);
      return inverse.has_value();
    }
    VectorXd solve(const VectorXd& b) const { return *inverse * b; }

    std::optional<MatrixXd> inverse;
  };

  BundleLikelihood(const Bundle& solved, const BundleInformation& information)
      : bundle_(solved), information_(information) {}

  static int rounds() { return 4; }

  bool at(State& state, Equations& equations) {
    bundle_.free_values = state.free_values;
    bundle_.camera_from_target = state.poses;
    const auto lens = bundle_.model->lens(bundle_.free_values, bundle_.image_size);
    if (!lens) return false;
    equations.cost = 0;
    for (std::size_t v = 0; v < bundle_.views.size(); ++v) {
      const auto refined = refine_view_pose(bundle_.views[v], *lens, state.poses[v]);
      if (!refined) return false;
      state.poses[v] = bundle_.camera_from_target[v] = refined->camera_from_target;
      equations.cost += refined->cost;
    }
    const auto information = bundle_information(bundle_);
    if (!information) return false;
    // A bend of the board is held.
    const Index k = bundle_.model->num_free();
    equations.information = (information->halves[0] + information->halves[1]).topLeftCorner(k, k);
    equations.gradient = (information->gradients[0] + information->gradients[1]).head(k);
    return true;
  }

  State stepped(const State& state, const VectorXd& step) const {
    State next = state;
    Eigen::Map<VectorXd>(next.free_values.data(), step.size()) += step;
    for (std::size_t v = 0; v < next.poses.size(); ++v)
      next.poses[v] =
          retract(state.poses[v], -information_.pose_by_parameters[v].leftCols(step.size()) * step);
    return next;
  }

 private:
  Bundle bundle_;
  const BundleInformation& information_;  // of the solved bundle
};

}  // namespace

MatrixXd profile_covariance(const Bundle& solved, const BundleInformation& information,
                            const MatrixXd& covariance, double sigma) {
  const Index least = least_known_parameter(*solved.model, covariance);
  if (least < 0) return covariance;
  const double sigma_px = std::sqrt(covariance(least, least));
  if (!(sigma_px > policy::kLinearShare * parameters(solved.lens())[0])) return covariance;
  const Index k = covariance.cols();
  const MatrixXd schur = (information.halves[0] + information.halves[1]).topLeftCorner(k, k);
  const BundleLikelihood::State best{solved.free_values, solved.camera_from_target};
  BundleLikelihood likelihood(solved, information);
  ProfileLikelihood<BundleLikelihood> profile(likelihood, best, cost_of(solved), sigma,
                                              schur / (sigma * sigma), covariance);
  const VectorXd function = VectorXd::Unit(k, least) / sigma_px;
  for (const double level : {policy::kProfileBundleSigmas, -policy::kProfileBundleSigmas})
    profile.widen({function, covariance * function}, level, policy::kProfileBundleSigmas);
  return profile.covariance();
}

}  // namespace tagcal::internal
