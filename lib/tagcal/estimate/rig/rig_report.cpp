#include "tagcal/estimate/rig/rig_report.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/spread_indices.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostEpipolarInstants = 100;  // numeric: a limit of work
constexpr double kDepths[] = {1, 3, 10, 30};        // numeric: metres, as users ask for them

// A corner of a view, and its ray under the camera's lens.
struct SeenRay {
  Eigen::Vector2d pixel;
  std::optional<Vector3d> ray;
};

// The solved rig with what its pairs have in common.
struct RigOfPairs {
  const SolvedRig& solved;
  const RigLayout& layout;
  const MatrixXd& covariance;
  MatrixXd inverse_of_lenses;  // of the covariance of their parameters, where it is regular
  std::vector<std::vector<std::vector<std::size_t>>> views;              // by camera and instant
  std::vector<std::map<std::size_t, std::map<CornerId, SeenRay>>> rays;  // by camera and view

  explicit RigOfPairs(const SolvedRig& rig)
      : solved(rig),
        layout(rig.layout),
        covariance(rig.covariance),
        rays(rig.data->cameras.size()) {
    const Index lenses = layout.size - layout.num_extrinsics();
    const MatrixXd of_lenses = covariance.bottomRightCorner(lenses, lenses);
    if (lenses > 0)  // none if all are exact
      inverse_of_lenses = of_lenses.completeOrthogonalDecomposition().pseudoInverse();
    for (std::size_t c = 0; c < rays.size(); ++c) views.push_back(rig.state->views_at(c));
  }

  const std::map<CornerId, SeenRay>& rays_of(std::size_t camera, std::size_t view,
                                             const Lens& lens) {
    const auto [found, is_new] = rays[camera].try_emplace(view);
    if (!is_new) return found->second;
    const std::size_t index = solved.state->index_of_view[camera][view];
    for (const Observation& o : solved.data->cameras[camera].data.views[index].observations) {
      const auto ray = ray_in_camera(lens, o.pixel);
      found->second[o.id] = {o.pixel, ray ? std::optional(ray->direction) : std::nullopt};
    }
    return found->second;
  }
};

// A pair of cameras as functions of the parameters of the rig.
struct PairModel {
  RigOfPairs& rig;
  const RigCameraEstimate &a, &b;
  std::size_t index_a, index_b;

  Pose b_from_a() const { return b.camera_from_rig * a.camera_from_rig.inverse(); }

  // Steps of b_from_a by all parameters of the rig (6 x n).
  MatrixXd by_parameters() const {
    const auto by = pair_by_places(a.camera_from_rig, b.camera_from_rig);
    MatrixXd all = MatrixXd::Zero(6, rig.layout.size);
    if (const auto at = rig.layout.pose[index_a]) all.middleCols<6>(*at) = by.leftCols<6>();
    if (const auto at = rig.layout.pose[index_b]) all.middleCols<6>(*at) = by.rightCols<6>();
    return all;
  }
};

// The derivative of a function of a lens by its free parameters, by central differences.
template <typename Function>
MatrixXd by_lens(const UncertainCamera& camera, const Function& of_lens) {
  if (!camera.model) return MatrixXd(of_lens(camera.camera.lens).size(), 0);
  const std::vector<double> values = camera.model->free_values(camera.camera.lens);
  MatrixXd by(of_lens(camera.camera.lens).size(), std::ssize(values));
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double h = 1e-6 * std::max(1.0, std::abs(values[k]));  // numeric: between both roundings
    const auto at = [&](double value) {
      std::vector<double> moved = values;
      moved[k] = value;
      return of_lens(*camera.model->lens(moved, camera.camera.image_size));
    };
    by.col(static_cast<Index>(k)) = (at(values[k] + h) - at(values[k] - h)) / (2 * h);
  }
  return by;
}

// The uncertainty of the depth of a point at `distance` on the axis of the first camera, as its
// second pixel tells it. No value if the second camera does not see the point.
std::optional<DepthUncertainty> depth_uncertainty(const PairModel& pair, double distance) {
  const Pose b_from_a = pair.b_from_a();
  const Vector3d axis = Vector3d::UnitZ(), point = b_from_a * Vector3d(distance * axis);
  PointJacobian by_point;
  const auto pixel =
      std::visit([&](const auto& lens) { return lens.project(point, &by_point, nullptr); },
                 pair.b.camera.camera.lens);
  const auto centre = project(pair.a.camera.camera.lens, Vector3d(distance * axis));
  if (!pixel || !centre) return std::nullopt;
  const Eigen::Vector2d by_depth = by_point * (b_from_a.rotation() * axis);
  if (!(by_depth.squaredNorm() > 0)) return std::nullopt;
  MatrixXd by_point_in_b(3, pair.rig.layout.size);
  by_point_in_b = pair.by_parameters().bottomRows<3>() -
                  cross_matrix(b_from_a.rotation() * Vector3d(distance * axis)) *
                      pair.by_parameters().topRows<3>();
  MatrixXd of_pixel = by_point * by_point_in_b;
  const auto add = [&](std::size_t camera, const MatrixXd& by) {
    if (by.cols() > 0) of_pixel.middleCols(pair.rig.layout.lens[camera], by.cols()) += by;
  };
  add(pair.index_b, by_lens(pair.b.camera, [&](const Lens& lens) {
        return project(lens, point).value_or(*pixel);
      }));
  add(pair.index_a, by_lens(pair.a.camera, [&](const Lens& lens) -> Eigen::Vector2d {
        const auto ray = ray_in_camera(lens, *centre);
        const Vector3d direction = ray ? ray->direction : axis;
        return by_point * (b_from_a.rotation() * Vector3d(distance * direction));
      }));
  const VectorXd depth = -of_pixel.transpose() * by_depth / by_depth.squaredNorm();
  const VectorXd with_all = pair.rig.covariance * depth;
  const double all = std::max(0.0, depth.dot(with_all));
  // The part that would vanish if the lenses were known.
  const VectorXd with_lenses = with_all.tail(pair.rig.inverse_of_lenses.cols());
  const double part = with_lenses.dot(pair.rig.inverse_of_lenses * with_lenses);
  return DepthUncertainty{distance, std::sqrt(all), std::sqrt(std::clamp(part, 0.0, all))};
}

// Corners that both cameras see at an instant: the sum of their squared distances from the epipolar
// curves.
void add_epipolar(const PairModel& pair, std::size_t view_a, std::size_t view_b, RigPair& result,
                  double& sum) {
  const Lens& lens_b = pair.b.camera.camera.lens;
  const auto& in_a = pair.rig.rays_of(pair.index_a, view_a, pair.a.camera.camera.lens);
  for (const auto& [id, b] : pair.rig.rays_of(pair.index_b, view_b, lens_b)) {
    const auto a = in_a.find(id);
    if (a == in_a.end() || !a->second.ray || !b.ray) continue;
    const Vector3d normal = result.b_from_a.translation()
                                .cross(result.b_from_a.rotation() * *a->second.ray)
                                .normalized();
    // The nearest ray of the epipolar plane, and its pixel.
    const Vector3d on_plane = *b.ray - normal * normal.dot(*b.ray);
    const auto pixel = project(lens_b, on_plane);
    if (!pixel) continue;
    sum += (*pixel - b.pixel).squaredNorm();
    ++result.num_corners;
  }
}

RigPair report_pair(const PairModel& pair) {
  RigPair result;
  result.a = pair.index_a;
  result.b = pair.index_b;
  result.b_from_a = pair.b_from_a();
  result.covariance = covariance_of_pair(pair.rig.solved, pair.index_a, pair.index_b);
  const Vector3d t = result.b_from_a.translation();
  result.baseline_m = t.norm();
  const Eigen::Matrix3d of_t = result.covariance.bottomRightCorner<3, 3>();
  if (result.baseline_m > 0)
    result.sigma_baseline_m = std::sqrt(std::max(0.0, t.dot(of_t * t))) / result.baseline_m;
  const auto &of_a = pair.rig.views[pair.index_a], &of_b = pair.rig.views[pair.index_b];
  std::vector<std::size_t> common;
  for (std::size_t i = 0; i < of_a.size(); ++i)
    if (!of_a[i].empty() && !of_b[i].empty()) common.push_back(i);
  result.num_instants = static_cast<int>(common.size());
  double sum = 0;
  for (const std::size_t i : spread_indices(common.size(), kMostEpipolarInstants))
    for (const std::size_t a : of_a[common[i]])
      for (const std::size_t b : of_b[common[i]]) add_epipolar(pair, a, b, result, sum);
  if (result.num_corners > 0) result.epipolar_px = std::sqrt(sum / result.num_corners);
  for (const double distance : kDepths)
    if (const auto depth = depth_uncertainty(pair, distance)) result.depths.push_back(*depth);
  return result;
}

// The disagreement of a pair alone with the rig, in standard deviations.
double disagreement_of(const SolvedRig& rig, std::size_t a, std::size_t b) {
  Connected only_a = rig.start.connected;
  only_a.cameras.assign(only_a.cameras.size(), 0);
  only_a.cameras[a] = 1;
  const Trajectory trajectory = trajectory_of(*rig.state, only_a);
  const auto all = disagreements(*rig.state, b, rig.state->poses.camera_from_rig[b],
                                 world_of_instants(*rig.state, b, trajectory), only_a);
  const auto place = place_of(all, *rig.state, b);
  if (!place) return 0;
  const Eigen::Matrix<double, 6, 6> c = place->covariance;
  return std::sqrt(place->step.dot(c.ldlt().solve(place->step)) / 6);
}

void report_camera(const SolvedRig& solved, std::size_t c, RigCameraEstimate& camera) {
  const RigState& state = *solved.state;
  const Bundle& bundle = state.cameras[c];
  camera.is_connected = solved.start.has(c);
  camera.camera_from_rig = state.poses.camera_from_rig[c];
  if (const auto at = solved.layout.pose[c])
    camera.covariance = solved.covariance.block<6, 6>(*at, *at);
  double sum = 0;
  ViewProblem buffer;
  for (std::size_t v = 0; v < bundle.views.size(); ++v) {
    if (!state.instant[c][v]) continue;
    ++camera.num_views;
    const ViewProblem& view = bundle.corrected(v, buffer);
    for (const auto& r :
         residuals_px(view.correspondences, bundle.lens(), bundle.camera_from_target[v])) {
      sum += r.squaredNorm();
      ++camera.num_corners;
    }
  }
  if (camera.num_corners > 0) camera.rms_px = std::sqrt(sum / camera.num_corners);
}

}  // namespace

Matrix6 covariance_of_pair(const SolvedRig& solved, std::size_t a, std::size_t b) {
  const auto& places = solved.state->poses.camera_from_rig;
  const auto by = pair_by_places(places[a], places[b]);
  const std::optional<Index> at[] = {solved.layout.pose[a], solved.layout.pose[b]};
  Matrix6 covariance = Matrix6::Zero();
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 2; ++k)
      if (at[i] && at[k])
        covariance += by.middleCols<6>(6 * i) * solved.covariance.block<6, 6>(*at[i], *at[k]) *
                      by.middleCols<6>(6 * k).transpose();
  return covariance;
}

void report_rig(const SolvedRig& solved, RigCalibration& answer) {
  const RigState& state = *solved.state;
  const std::vector<ViewExcess> excess = excesses(state);
  double sum = 0;
  for (std::size_t c = 0; c < answer.cameras.size(); ++c) {
    RigCameraEstimate& camera = answer.cameras[c];
    report_camera(solved, c, camera);
    camera.excess = excess_of_camera(excess, c);
    answer.num_corners += camera.num_corners;
    sum += camera.rms_px * camera.rms_px * camera.num_corners;
  }
  if (answer.num_corners > 0) answer.rms_px = std::sqrt(sum / answer.num_corners);
  RigOfPairs pairs(solved);
  for (std::size_t a = 0; a < answer.cameras.size(); ++a)
    for (std::size_t b = a + 1; b < answer.cameras.size(); ++b) {
      if (common_instants(state, a, b) == 0 || !answer.cameras[a].is_connected) continue;
      RigPair pair = report_pair({pairs, answer.cameras[a], answer.cameras[b], a, b});
      if (answer.cameras.size() > 2) pair.disagreement = disagreement_of(solved, a, b);
      answer.pairs.push_back(std::move(pair));
    }
  for (std::size_t b = 0; b < state.poses.world_from_board.size(); ++b) {
    RigBoard board{state.poses.world_from_board[b]};
    board.is_connected = solved.start.connected.boards[b];
    if (const auto at = solved.layout.board[b])
      board.covariance = solved.covariance.block<6, 6>(*at, *at);
    answer.boards.push_back(board);
  }
  std::vector<int> num_views(state.num_instants, 0);
  for (const auto& camera : state.instant)
    for (const auto& t : camera)
      if (t) ++num_views[*t];
  for (std::size_t t = 0; t < num_views.size(); ++t)
    if (num_views[t] > 0)
      answer.instants.push_back({t, state.poses.rig_from_world[t], num_views[t]});
}

}  // namespace tagcal::internal
