#include "tagcal/estimate/rig/rig_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "tagcal/estimate/bundle/repeated_poses.hpp"
#include "tagcal/estimate/calibration/posterior.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// The products of an instant's rows by its pose: A'A, and A'[B | r] with the rows B by the
// parameters of the rig.
struct PoseProducts {
  Matrix6 by_pose = Matrix6::Zero();
  MatrixXd cross;

  explicit PoseProducts(Index num_parameters) : cross(MatrixXd::Zero(6, num_parameters + 1)) {}
};

// Adds a view's products, [pose (6) | parameters | shape of the board | r], to those of its instant
// and to the sums over instants.
void add_view(const RigState& state, const RigLayout& layout, std::size_t camera,
              const LinkedPoses::Link& link, const MatrixXd& view_gram, PoseProducts& pose,
              ViewInformation& sum) {
  const Bundle& bundle = state.cameras[camera];
  const Index k = bundle.model->num_free(), shapes = bundle.num_shapes();
  const LinkedSteps steps(state.poses, camera, link);
  // The parameters that the view depends on, of [instant (6) | rig | r], and its rows by them.
  std::vector<Index> places;
  MatrixXd onto = MatrixXd::Zero(view_gram.rows(), 18 + k + shapes + 1);
  const auto add = [&](Index at, Index count) {
    for (Index i = 0; i < count; ++i) places.push_back(at + i);
  };
  const auto add_pose = [&](Index at, const Matrix6& by) {
    onto.block<6, 6>(0, std::ssize(places)) = by;
    add(at, 6);
  };
  add_pose(0, steps.by_instant);
  if (layout.pose[camera]) add_pose(6 + *layout.pose[camera], steps.by_camera);
  if (const auto at = layout.board[link.board]) add_pose(6 + *at, steps.by_board);
  onto.block(6, std::ssize(places), k + shapes + 1, k + shapes + 1).setIdentity();
  add(6 + layout.lens[camera], k);
  add(6 + layout.size, shapes);
  add(6 + sum.schur.cols(), 1);
  const MatrixXd full = view_gram.selfadjointView<Eigen::Upper>();
  const MatrixXd products = onto.transpose() * full * onto;
  for (std::size_t j = 6; j + 1 < places.size(); ++j) {
    const Index column = static_cast<Index>(j);
    for (std::size_t i = 6; i + 1 < places.size(); ++i)
      sum.schur(places[i] - 6, places[j] - 6) += products(static_cast<Index>(i), column);
    sum.gradient[places[j] - 6] += products(column, std::ssize(places) - 1);
  }
  pose.by_pose += products.topLeftCorner<6, 6>();
  for (std::size_t j = 6; j < places.size(); ++j)
    pose.cross.col(places[j] - 6) += products.block<6, 1>(0, static_cast<Index>(j));
}

// Takes the part of the instant's pose from the sums: B'A (A'A)^-1 A'B. False if the views do not
// determine the pose. (`eliminate_pose` would cost the cube of the rig's parameters.)
bool eliminate(const PoseProducts& pose, ViewInformation& sum) {
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(Eigen::Matrix<double, 6, 6>(pose.by_pose));
  if (llt.info() != Eigen::Success) return false;
  const MatrixXd rows = llt.matrixL().solve(pose.cross);
  const Index n = sum.schur.cols();
  sum.schur.noalias() -= rows.leftCols(n).transpose() * rows.leftCols(n);
  sum.gradient.noalias() -= rows.leftCols(n).transpose() * rows.col(n);
  return true;
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

// Poses that count as one sample together, so that samples times the cube of the parameters stay
// bounded: a limit of work.
std::size_t poses_per_sample(std::size_t num_poses, Index num_parameters) {
  constexpr double kMostWork = 1e9;      // numeric: a limit of work
  constexpr double kFewestSamples = 20;  // numeric: a limit of work
  const double most = std::max(kFewestSamples, kMostWork / std::pow(num_parameters, 3));
  return static_cast<std::size_t>(std::ceil(static_cast<double>(num_poses) / most));
}

// Numbers of the poses of the rig by instant: instants are of one pose if they are so for each
// camera. Instants without views have that of another one.
std::vector<std::size_t> poses_of_instants(
    const RigState& state,
    const std::vector<std::vector<std::pair<std::size_t, std::size_t>>>& by_instant) {
  std::vector<std::vector<std::size_t>> pose_of_view;
  for (const Bundle& camera : state.cameras) pose_of_view.push_back(pose_numbers(camera));
  std::map<std::vector<std::pair<std::size_t, std::size_t>>, std::size_t> number_of;
  std::vector<std::size_t> numbers;
  for (const auto& views : by_instant) {
    std::vector<std::pair<std::size_t, std::size_t>> poses;
    for (const auto& [c, v] : views) poses.emplace_back(c, pose_of_view[c][v]);
    numbers.push_back(
        views.empty() ? 0 : number_of.emplace(std::move(poses), number_of.size()).first->second);
  }
  return numbers;
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

// Products of rows by parameters, without priors: J'J and J'r.
struct Products {
  MatrixXd information;
  Eigen::VectorXd gradient;
};

// Those of the first n parameters, with the rest, the shape of the board, free but for its prior.
Products without_shape(const BundleInformation& information, Index n) {
  Products all{information.data(), Eigen::VectorXd::Zero(information.prior.rows())};
  for (const ViewInformation& view : information.views) all.gradient += view.gradient;
  const Index shapes = all.information.cols() - n;
  if (shapes == 0) return all;
  const Eigen::LDLT<MatrixXd> of_shape(all.information.bottomRightCorner(shapes, shapes) +
                                       information.prior.bottomRightCorner(shapes, shapes));
  const MatrixXd cross = all.information.topRightCorner(n, shapes);
  return {all.information.topLeftCorner(n, n) - cross * of_shape.solve(cross.transpose()).eval(),
          all.gradient.head(n) - cross * of_shape.solve(all.gradient.tail(shapes) +
                                                        information.prior_gradient.tail(shapes))};
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

// 0 for measured points and for several boards, whose places are measured.
double sigma_of_board(const RigState& state) {
  const Bundle& bundle = state.cameras.front();
  if (!bundle.board) return 0;
  return sigma_of_scale(bundle.board->prior_sigma[3], bundle.shape[3]);
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

std::optional<BundleInformation> rig_information(const RigState& solved, const RigLayout& layout) {
  std::vector<Lens> lenses;
  for (const Bundle& camera : solved.cameras) lenses.push_back(camera.lens());
  const auto by_instant = views_by_instant(solved);
  const Index n = layout.size + solved.cameras.front().num_shapes();
  const std::vector<std::size_t> pose_of_instant = poses_of_instants(solved, by_instant);
  const std::size_t per_sample = poses_per_sample(num_poses(pose_of_instant), n);
  BundleInformation information;
  information.views.resize((num_poses(pose_of_instant) + per_sample - 1) / per_sample,
                           {MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), {}, {}});
  for (std::size_t i = 0; i < by_instant.size(); ++i) {
    const auto& views = by_instant[i];
    if (views.empty()) continue;
    ViewInformation& sample = information.views[pose_of_instant[i] / per_sample];
    PoseProducts pose(n);
    for (const auto& [c, v] : views) {
      const Bundle& camera = solved.cameras[c];
      const auto of_view =
          products_of(camera, v, camera.model->free(), lenses[c], camera.camera_from_target[v]);
      if (!of_view) return std::nullopt;
      add_view(solved, layout, c, solved.poses.links[c][v], *of_view, pose, sample);
    }
    if (!eliminate(pose, sample)) return std::nullopt;
  }
  add_priors_of_rig(solved, layout, information);
  return information;
}

double overdispersion_of_rig(const RigState& solved) {
  double most = 1;
  for (const Bundle& camera : solved.cameras)
    if (!camera.views.empty())
      most = std::max(most, expected_overdispersion(camera, pose_numbers(camera)));
  return most;
}

// A claim may be singular, if the lens is one of a smaller model: the lens is a_c + R_c z, with
// R_c R_c' = K_c, and z has the information I before the rig.
std::optional<RigClaim> claim_of_rig(const RigState& solved, const RigLayout& layout,
                                     const std::vector<LensClaim>& claims, double strain) {
  const auto information = rig_information(solved, layout);
  if (!information) return std::nullopt;
  const auto spread = covariance_of(*information, 1, 1, overdispersion_of_rig(solved));
  if (!spread) return std::nullopt;
  const double phi = std::max(spread->overdispersion, strain);
  const Products all = without_shape(*information, layout.size);
  Products more = all;
  MatrixXd by_z = MatrixXd::Identity(layout.size, layout.size);
  Eigen::VectorXd to_answer = Eigen::VectorXd::Zero(layout.size);
  for (std::size_t c = 0; c < solved.cameras.size(); ++c) {
    const Bundle& camera = solved.cameras[c];
    const Index k = camera.model->num_free(), at = layout.lens[c];
    const auto own = bundle_information(camera);
    if (!own) return std::nullopt;
    const Products of_own = without_shape(*own, k);
    more.information.block(at, at, k, k) -= of_own.information;
    more.gradient.segment(at, k) -= of_own.gradient;
    by_z.block(at, at, k, k) = root_of(claims[c].covariance, claims[c].covariance);
    to_answer.segment(at, k) =
        claims[c].answer - Eigen::VectorXd::Map(camera.free_values.data(), k);
  }
  const MatrixXd root = root_of(more.information, all.information);
  const MatrixXd root_by_z = by_z.transpose() * root;
  const Index extrinsics = layout.num_extrinsics();
  MatrixXd total = root_by_z * root_by_z.transpose() / phi;
  total.diagonal().tail(layout.size - extrinsics).array() += 1;
  // So little that only what is not determined gets its variance from it.
  total.diagonal().head(extrinsics) +=
      1e-12 * all.information.diagonal().head(extrinsics);  // numeric: see above
  const auto covariance = exact_inverse(total);
  if (!covariance) return std::nullopt;
  const Eigen::VectorXd gradient = root * (root.transpose() * to_answer) + more.gradient;
  const Eigen::VectorXd z = -*covariance * (by_z.transpose() * gradient) / phi;
  return RigClaim{to_answer + by_z * z, by_z * *covariance * by_z.transpose()};
}

std::optional<MatrixXd> covariance_of_extrinsics(const RigState& solved, const RigLayout& layout,
                                                 const std::vector<LensClaim>& claims,
                                                 double strain) {
  auto information = rig_information(solved, layout);
  const Index n = layout.num_extrinsics();
  if (!information || n == 0) return std::nullopt;
  const MatrixXd all = without_shape(*information, layout.size).information;
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
  covariance.topLeftCorner(n, n) = std::max(spread->overdispersion, strain) * *of_extrinsics;
  for (std::size_t c = 0; c < solved.cameras.size(); ++c) {
    const Index k = claims[c].covariance.cols();
    MatrixXd response = MatrixXd::Zero(layout.size, k);
    response.middleRows(layout.lens[c], k).setIdentity();
    response.topRows(n) = -*of_extrinsics * all.block(0, layout.lens[c], n, k);
    covariance += response * claims[c].covariance * response.transpose();
  }
  return covariance;
}

void add_scale(const RigState& state, const RigLayout& layout, double times, MatrixXd& covariance) {
  Eigen::VectorXd by_scale = Eigen::VectorXd::Zero(layout.size);
  for (std::size_t c = 0; c < state.cameras.size(); ++c)
    if (const auto at = layout.pose[c])
      by_scale.segment<3>(*at + 3) = state.poses.camera_from_rig[c].translation();
  by_scale *= sigma_of_board(state);
  covariance += times * by_scale * by_scale.transpose();
}

}  // namespace tagcal::internal
