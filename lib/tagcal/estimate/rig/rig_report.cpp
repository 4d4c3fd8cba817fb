#include "tagcal/estimate/rig/rig_report.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tagcal/estimate/rig/rig_pair.hpp"
#include "tagcal/internal/spread_indices.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostEpipolarInstants = 100;  // numeric: a limit of work

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
    inverse_of_lenses = inverse_of_last(covariance, layout.size - layout.num_extrinsics());
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

// A pair of cameras of the rig.
struct PairModel {
  RigOfPairs& rig;
  const RigCameraEstimate &a, &b;
  std::size_t index_a, index_b;
};

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
  const RigLayout& layout = pair.rig.layout;
  report_place({pair.a.camera, pair.b.camera, pair.a.camera_from_rig, pair.b.camera_from_rig,
                layout.pose[pair.index_a], layout.pose[pair.index_b], layout.lens[pair.index_a],
                layout.lens[pair.index_b], pair.rig.covariance, pair.rig.inverse_of_lenses},
               result);
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
  return covariance_between(places[a], places[b], solved.layout.pose[a], solved.layout.pose[b],
                            solved.covariance);
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
