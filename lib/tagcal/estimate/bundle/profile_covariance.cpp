#include "tagcal/estimate/bundle/profile_covariance.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

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
    const ParameterRole role = model.parameter(static_cast<std::size_t>(i)).role;
    const bool is_pinhole =
        role == ParameterRole::focal_length || role == ParameterRole::principal_point;
    if (is_pinhole && (least < 0 || covariance(i, i) > covariance(least, least))) least = i;
  }
  return least;
}

// Gauss-Newton steps of one pose, lens and board held. False outside of the domain.
bool improve_pose(Bundle& bundle, std::size_t view, const Lens& lens, double& cost) {
  constexpr int kSteps = 4;
  ViewEquations equations(bundle, view, {}, bundle.row_prior(view));
  Pose& pose = bundle.camera_from_target[view];
  MatrixXd gram;
  cost = std::numeric_limits<double>::infinity();
  Pose best = pose;
  for (int i = 0; i <= kSteps; ++i) {
    if (!equations.sums.at(lens, pose, gram)) break;
    const Index last = gram.cols() - 1;
    if (!(gram(last, last) < cost)) break;
    cost = gram(last, last);
    best = pose;
    const Matrix6 information = gram.topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
    const Eigen::Matrix<double, 6, 1> gradient = gram.block<6, 1>(0, last);
    pose = retract(pose, -Eigen::LDLT<Eigen::Matrix<double, 6, 6>>(information).solve(gradient));
  }
  pose = best;
  return std::isfinite(cost);
}

// The likelihood of the parameters of a bundle: the best poses belong to them.
class BundleLikelihood {
 public:
  using State = Bundle;
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

  explicit BundleLikelihood(const BundleInformation& information) : information_(information) {}

  static int rounds() { return 4; }

  bool at(State& state, Equations& equations) {
    const auto lens = state.model->lens(state.free_values, state.image_size);
    if (!lens) return false;
    const double variance = state.sigma * state.sigma;
    equations.cost = variance * prior_of(state).residuals.squaredNorm();
    for (std::size_t v = 0; v < state.views.size(); ++v) {
      double cost = 0;
      if (!improve_pose(state, v, *lens, cost)) return false;
      equations.cost += cost;
    }
    const auto information = bundle_information(state);
    if (!information) return false;
    equations.information = variance * information->total(state.sigma);
    equations.gradient = variance * information->gradient(state.sigma);
    return true;
  }

  State stepped(const State& state, const VectorXd& step) const {
    State next = state;
    const Index k = state.model->num_free();
    Eigen::Map<VectorXd>(next.free_values.data(), k) += step.head(k);
    if (state.board) next.shape += step.tail<4>();
    for (std::size_t v = 0; v < next.views.size(); ++v)
      next.camera_from_target[v] =
          retract(state.camera_from_target[v], -information_.views[v].pose_by_parameters * step);
    return next;
  }

 private:
  const BundleInformation& information_;  // of the solved bundle
};

}  // namespace

MatrixXd profile_covariance(const Bundle& solved, const BundleInformation& information,
                            const MatrixXd& covariance, double sigma) {
  const Index least = least_known_parameter(*solved.model, covariance);
  if (least < 0) return covariance;
  const double sigma_px = std::sqrt(covariance(least, least));
  const Lens lens = solved.lens();
  if (!(sigma_px > policy::kLinearShare * parameters(lens)[0])) return covariance;
  const auto inverse = exact_inverse(covariance);
  if (!inverse) return covariance;
  BundleLikelihood likelihood(information);
  Bundle best = solved;
  BundleLikelihood::Equations here;
  if (!likelihood.at(best, here)) return covariance;
  ProfileLikelihood<BundleLikelihood> profile(likelihood, best, here.cost, sigma, *inverse,
                                              covariance);
  const VectorXd function = VectorXd::Unit(covariance.cols(), least) / sigma_px;
  for (const double level : {policy::kProfileBundleSigmas, -policy::kProfileBundleSigmas})
    profile.widen({function, covariance * function}, level, policy::kProfileBundleSigmas);
  return profile.covariance();
}

}  // namespace tagcal::internal
