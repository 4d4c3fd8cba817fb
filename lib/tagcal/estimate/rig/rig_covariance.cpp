#include "tagcal/estimate/rig/rig_covariance.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tagcal/estimate/calibration/posterior.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Adds a view's products to those of its instant, [pose of the instant (6) | parameters | shape of
// the board | r].
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
  if (const auto at = layout.board[link.board]) onto.block<6, 6>(0, 6 + *at) = steps.by_board;
  onto.block(6, 6 + layout.lens[camera], k, k).setIdentity();
  if (shapes > 0) onto.block(6 + k, 6 + layout.size, shapes, shapes).setIdentity();
  onto(width - 1, gram.cols() - 1) = 1;
  gram += onto.transpose() * full * onto;
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
  const Index n = layout.size + state.cameras.front().num_shapes();
  information.prior = MatrixXd::Zero(n, n);
  information.prior_gradient = Eigen::VectorXd::Zero(n);
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
    information.prior.block(layout.size, layout.size, shapes, shapes) +=
        square.bottomRightCorner(shapes, shapes);
    information.prior_gradient.segment(layout.size, shapes) += gradient.tail(shapes);
  }
}

// The information of a rig by its parameters and the shape of its board.
std::optional<BundleInformation> rig_information(const RigState& solved, const RigLayout& layout) {
  std::vector<Lens> lenses;
  for (const Bundle& camera : solved.cameras) lenses.push_back(camera.lens());
  const auto by_instant = views_by_instant(solved);
  const Index n = layout.size + solved.cameras.front().num_shapes();
  const std::size_t per_sample = instants_per_sample(by_instant.size(), n);
  BundleInformation information;
  std::size_t number = 0;
  for (const auto& views : by_instant) {
    if (views.empty()) continue;
    MatrixXd gram = MatrixXd::Zero(6 + n + 1, 6 + n + 1);
    for (const auto& [c, v] : views) {
      const Bundle& camera = solved.cameras[c];
      const auto of_view =
          products_of(camera, v, camera.model->free(), lenses[c], camera.camera_from_target[v]);
      if (!of_view) return std::nullopt;
      add_view(solved, layout, c, solved.poses.links[c][v], *of_view, gram);
    }
    const auto eliminated = eliminate_pose(gram);
    if (!eliminated) return std::nullopt;
    add_sample(*eliminated, number++, per_sample, information.views);
  }
  add_priors_of_rig(solved, layout, information);
  return information;
}

// The overdispersion that neighbouring residuals suggest: that of the worst camera.
double overdispersion_of_rig(const RigState& solved) {
  double most = 1;
  for (const Bundle& camera : solved.cameras)
    if (!camera.views.empty()) most = std::max(most, overdispersion_of_neighbours(camera));
  return most;
}

// The information of the first n parameters, with the rest free but for their prior.
MatrixXd without_shape(const MatrixXd& information, const MatrixXd& prior, Index n) {
  const Index shapes = information.cols() - n;
  if (shapes == 0) return information;
  const MatrixXd of_shape =
      information.bottomRightCorner(shapes, shapes) + prior.bottomRightCorner(shapes, shapes);
  const MatrixXd cross = information.topRightCorner(n, shapes);
  return information.topLeftCorner(n, n) - cross * of_shape.ldlt().solve(cross.transpose()).eval();
}

// A root R of the positive part R R' of a symmetric matrix, in units of the roots of the diagonal
// of `unit`, so that parameters of any scale count alike.
MatrixXd root_of(const MatrixXd& matrix, const MatrixXd& unit) {
  const Eigen::VectorXd scale = unit.diagonal().cwiseMax(1e-300).cwiseSqrt();  // numeric: no zero
  const MatrixXd scaled =
      scale.cwiseInverse().asDiagonal() * matrix * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled);
  return scale.asDiagonal() * eigen.eigenvectors() *
         eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

}  // namespace

RigLayout::RigLayout(const RigState& state, const Connected& connected) {
  const auto add = [&](std::vector<std::optional<Index>>& places, bool is_free) {
    places.push_back(is_free ? std::optional(size) : std::nullopt);
    if (is_free) size += 6;
  };
  for (std::size_t c = 0; c < connected.cameras.size(); ++c)
    add(pose, connected.cameras[c] && c != state.poses.reference);
  for (std::size_t b = 0; b < connected.boards.size(); ++b)
    add(board, connected.boards[b] && b != state.poses.first_board);
  for (const Bundle& camera : state.cameras) {
    lens.push_back(size);
    size += camera.model->num_free();
  }
}

// A claim may be singular, if the lens is one of a smaller model: the lens is R_c z, with
// R_c R_c' = claim_c, and z has the information I before the rig.
std::optional<MatrixXd> covariance_of_rig(const RigState& solved, const RigLayout& layout,
                                          const std::vector<MatrixXd>& claims) {
  const auto information = rig_information(solved, layout);
  if (!information) return std::nullopt;
  const auto spread = covariance_of(*information, 1, 1, overdispersion_of_rig(solved));
  if (!spread) return std::nullopt;
  const MatrixXd all = without_shape(information->data(), information->prior, layout.size);
  const Index extrinsics = layout.num_extrinsics();
  MatrixXd more = all, by_z = MatrixXd::Identity(layout.size, layout.size);
  for (std::size_t c = 0; c < solved.cameras.size(); ++c) {
    const Index k = solved.cameras[c].model->num_free(), at = layout.lens[c];
    const auto own = bundle_information(solved.cameras[c]);
    if (!own) return std::nullopt;
    more.block(at, at, k, k) -= without_shape(own->data(), own->prior, k);
    by_z.block(at, at, k, k) = root_of(claims[c], claims[c]);
  }
  const MatrixXd root = by_z.transpose() * root_of(more, all);
  MatrixXd total = root * root.transpose() / spread->overdispersion;
  total.diagonal().tail(layout.size - extrinsics).array() += 1;
  // So little that only what is not determined gets its variance from it.
  total.diagonal().head(extrinsics) +=
      1e-12 * all.diagonal().head(extrinsics);  // numeric: see above
  const auto covariance = exact_inverse(total);
  if (!covariance) return std::nullopt;
  return MatrixXd(by_z * *covariance * by_z.transpose());
}

std::optional<MatrixXd> covariance_of_extrinsics(const RigState& solved, const RigLayout& layout,
                                                 const std::vector<MatrixXd>& claims) {
  auto information = rig_information(solved, layout);
  const Index n = layout.num_extrinsics();
  if (!information || n == 0) return std::nullopt;
  const MatrixXd all = without_shape(information->data(), information->prior, layout.size);
  const auto of_extrinsics = exact_inverse(all.topLeftCorner(n, n));
  if (!of_extrinsics) return std::nullopt;
  for (ViewInformation& sample : information->views) {
    sample.schur = MatrixXd(sample.schur.topLeftCorner(n, n));
    sample.gradient = Eigen::VectorXd(sample.gradient.head(n));
  }
  information->prior = MatrixXd::Zero(n, n);
  information->prior_gradient = Eigen::VectorXd::Zero(n);
  const auto spread = covariance_of(*information, 1, 1, overdispersion_of_rig(solved));
  if (!spread) return std::nullopt;
  MatrixXd covariance = MatrixXd::Zero(layout.size, layout.size);
  covariance.topLeftCorner(n, n) = spread->overdispersion * *of_extrinsics;
  for (std::size_t c = 0; c < solved.cameras.size(); ++c) {
    const Index k = claims[c].cols();
    MatrixXd response = MatrixXd::Zero(layout.size, k);
    response.middleRows(layout.lens[c], k).setIdentity();
    response.topRows(n) = -*of_extrinsics * all.block(0, layout.lens[c], n, k);
    covariance += response * claims[c] * response.transpose();
  }
  return covariance;
}

}  // namespace tagcal::internal
