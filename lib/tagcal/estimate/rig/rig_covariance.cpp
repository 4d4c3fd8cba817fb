#include "tagcal/estimate/rig/rig_covariance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/calibration/posterior.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Adds a view's products to those of its instant, [pose of the instant (6) | parameters | r].
void add_view(const RigState& state, const RigLayout& layout, std::size_t camera,
              const LinkedPoses::Link& link, const MatrixXd& view_gram, MatrixXd& gram) {
  const Bundle& bundle = state.cameras[camera];
  const Index k = bundle.model->num_free(), shapes = bundle.num_shapes();
  const Index width = 6 + k + shapes + 1;
  const MatrixXd full = view_gram.selfadjointView<Eigen::Upper>();
  const LinkedSteps steps(state.poses, camera, link);
  MatrixXd onto = MatrixXd::Zero(width, gram.cols());
  onto.topLeftCorner<6, 6>() = steps.by_instant;
  if (layout.pose[camera]) onto.block<6, 6>(0, 6 + *layout.pose[camera]) = steps.by_camera;
  onto.block(6, 6 + layout.lens[camera], k, k).setIdentity();
  if (shapes > 0) onto.block(6 + k, 6 + *layout.shape, shapes, shapes).setIdentity();
  onto(width - 1, gram.cols() - 1) = 1;
  gram += onto.transpose() * full * onto;
}

MatrixXd gram_of_view(const Bundle& bundle, std::size_t view, const Lens& lens) {
  ViewEquations equations(bundle, view, bundle.model->free(), bundle.row_prior());
  MatrixXd gram;
  if (!equations.sums.at(lens, bundle.camera_from_target[view], gram)) gram.resize(0, 0);
  return gram;
}

// Views by instant of the linked poses: (camera, view).
std::vector<std::vector<std::pair<std::size_t, std::size_t>>> views_by_instant(
    const RigState& state) {
  std::vector<std::vector<std::pair<std::size_t, std::size_t>>> views(
      state.poses.rig_from_world.size());
  for (std::size_t c = 0; c < state.cameras.size(); ++c)
    for (std::size_t v = 0; v < state.poses.links[c].size(); ++v)
      views[state.poses.links[c][v].instant].emplace_back(c, v);
  return views;
}

// Instants that count as one sample together, so that samples times the cube of the parameters stay
// bounded: a limit of work.
std::size_t instants_per_sample(std::size_t num_instants, Index num_parameters) {
  constexpr double kMostWork = 4e9;      // numeric: a limit of work
  constexpr double kFewestSamples = 20;  // numeric: a limit of work
  const double most = std::max(kFewestSamples, kMostWork / std::pow(num_parameters, 3));
  return static_cast<std::size_t>(std::ceil(static_cast<double>(num_instants) / most));
}

void add_sample(const ViewInformation& instant, std::size_t number, std::size_t per_sample,
                std::vector<ViewInformation>& samples) {
  if (number % per_sample == 0) {
    samples.push_back({instant.schur, instant.gradient, {}, {}});
    return;
  }
  samples.back().schur += instant.schur;
  samples.back().gradient += instant.gradient;
}

void add_priors_of_rig(const RigState& state, const RigLayout& layout,
                       BundleInformation& information) {
  information.prior = MatrixXd::Zero(layout.size, layout.size);
  information.prior_gradient = Eigen::VectorXd::Zero(layout.size);
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const Bundle& bundle = state.cameras[c];
    const Index k = bundle.model->num_free();
    const PriorRows rows = c == 0 ? prior_of(bundle) : prior_of_lens(bundle);
    const MatrixXd square = rows.by_parameters.transpose() * rows.by_parameters;
    const Eigen::VectorXd gradient = rows.by_parameters.transpose() * rows.residuals;
    information.prior.block(layout.lens[c], layout.lens[c], k, k) += square.topLeftCorner(k, k);
    information.prior_gradient.segment(layout.lens[c], k) += gradient.head(k);
    const Index shapes = c == 0 ? bundle.num_shapes() : 0;
    if (shapes == 0) continue;
    information.prior.block(*layout.shape, *layout.shape, shapes, shapes) +=
        square.bottomRightCorner(shapes, shapes);
    information.prior_gradient.segment(*layout.shape, shapes) += gradient.tail(shapes);
  }
}

}  // namespace

RigLayout::RigLayout(const RigState& state, const std::vector<std::uint8_t>& is_connected) {
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    pose.emplace_back();
    if (c == state.poses.reference || !is_connected[c]) continue;
    pose.back() = size;
    size += 6;
  }
  for (const Bundle& camera : state.cameras) {
    lens.push_back(size);
    size += camera.model->num_free();
  }
  if (!state.cameras.front().board) return;
  shape = size;
  size += state.cameras.front().num_shapes();
}

std::optional<BundleInformation> rig_information(const RigState& solved, const RigLayout& layout) {
  std::vector<Lens> lenses;
  for (const Bundle& camera : solved.cameras) lenses.push_back(camera.lens());
  const auto by_instant = views_by_instant(solved);
  const std::size_t per_sample = instants_per_sample(by_instant.size(), layout.size);
  BundleInformation information;
  std::size_t number = 0;
  for (const auto& views : by_instant) {
    if (views.empty()) continue;
    MatrixXd gram = MatrixXd::Zero(6 + layout.size + 1, 6 + layout.size + 1);
    for (const auto& [c, v] : views) {
      const MatrixXd of_view = gram_of_view(solved.cameras[c], v, lenses[c]);
      if (of_view.size() == 0) return std::nullopt;
      add_view(solved, layout, c, solved.poses.links[c][v], of_view, gram);
    }
    const auto eliminated = eliminate_pose(gram);
    if (!eliminated) return std::nullopt;
    add_sample(*eliminated, number++, per_sample, information.views);
  }
  add_priors_of_rig(solved, layout, information);
  return information;
}

double overdispersion_of_rig(const RigState& solved) {
  double most = 1;
  for (const Bundle& camera : solved.cameras)
    if (!camera.views.empty()) most = std::max(most, overdispersion_of_neighbours(camera));
  return most;
}

MatrixXd excess_of(const MatrixXd& claim, const MatrixXd& own) {
  if (claim.size() == 0) return claim;
  // In units of the claim's standard deviations, so that parameters of any scale count alike.
  const Eigen::VectorXd unit = claim.diagonal().cwiseMax(1e-300).cwiseSqrt();  // numeric: no zero
  const MatrixXd scaled =
      unit.cwiseInverse().asDiagonal() * (claim - own) * unit.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  const MatrixXd root = unit.asDiagonal() * eigen.eigenvectors() *
                        eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  return root * root.transpose();
}

void add_claim(MatrixXd& covariance, const RigLayout& layout, const MatrixXd& information,
               std::size_t camera, const MatrixXd& excess) {
  const Index k = excess.cols(), extrinsics = layout.lens.front();
  if (k == 0) return;
  MatrixXd response = MatrixXd::Zero(layout.size, k);
  response.middleRows(layout.lens[camera], k).setIdentity();
  if (extrinsics > 0)
    if (const auto inverse = exact_inverse(information.topLeftCorner(extrinsics, extrinsics)))
      response.topRows(extrinsics) =
          -*inverse * information.block(0, layout.lens[camera], extrinsics, k);
  covariance += response * excess * response.transpose();
}

}  // namespace tagcal::internal
