#include "tagcal/estimate/rig/rig_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/calibration/calibration_fit.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

using RejectedCorners = std::set<std::pair<std::size_t, std::size_t>>;  // view and corner

Matrix2 whitening_in_rig(const Observation& corner, const Calibration& own) {
  if (!own.sigma_of_corners) return Matrix2::Identity() / std::max(own.sigma_px, kLeastNoisePx);
  const double error = own.model_error_px;
  return whitening_of(covariance_or_assumed(corner) + error * error * Matrix2::Identity());
}

ViewProblem problem_of(const View& seen, std::size_t index,
                       const std::map<CornerId, Vector3d>& points, const Calibration& own,
                       const RejectedCorners& rejected) {
  ViewProblem problem;
  for (std::size_t i = 0; i < seen.observations.size(); ++i) {
    const Observation& corner = seen.observations[i];
    const auto point = points.find(corner.id);
    if (point == points.end() || rejected.contains({index, i})) continue;
    problem.correspondences.push_back({point->second, corner.pixel});
    problem.whitening.push_back(whitening_in_rig(corner, own));
  }
  return problem;
}

// Models with all parameters of a lens held.
std::shared_ptr<const HeldModels> models_of(const Lens& lens) {
  const LensKind& kind = kind_of(lens);
  std::map<std::string, double> values;
  for (std::size_t k = 0; k < kind.parameters.size(); ++k)
    values[std::string(kind.parameters[k].name)] = parameters(lens)[k];
  return std::make_shared<const HeldModels>(values, kind);
}

// The model of the bundle: the one that carries the claim of the own calibration, because other
// views than those that chose the smaller model of the answer may need more; or one that holds the
// whole lens.
const Model& model_in_rig(const Calibration& own, RigLenses lenses, RigState& state) {
  const LensKind& kind = kind_of(own.camera->lens);
  if (lenses == RigLenses::fixed) {
    state.held.push_back(models_of(own.camera->lens));
    return state.held.back()->of(kind, ModelRole::largest);
  }
  const std::string model(own.claim && own.claim->model ? own.claim->model->name() : own.model);
  if (own.fixed.empty()) return Model::named(model);
  state.held.push_back(std::make_shared<const HeldModels>(own.fixed, kind));
  return state.held.back()->named(model);
}

Bundle bundle_of(const Dataset& data, const Calibration& own, const Model& model) {
  Bundle bundle;
  bundle.model = &model;
  bundle.image_size = data.image_size;
  bundle.free_values = model.free_values(own.camera->lens);
  bundle.row_sigma = own.row_sigma;
  bundle.board = flat_board(data);
  if (bundle.board && own.board_warp) {
    const BoardWarp& warp = *own.board_warp;
    bundle.shape << warp.bend_mm / 1e3, warp.twist_mm / 1e3, warp.aspect;
  }
  RejectedCorners rejected;
  for (const Outlier& outlier : own.outliers) rejected.insert({outlier.view, outlier.corner});
  const std::map<CornerId, Vector3d> points = points_in_world(data.boards);
  for (const CalibratedView& view : own.views) {
    bundle.views.push_back(problem_of(data.views[view.view], view.view, points, own, rejected));
    bundle.camera_from_target.push_back(view.camera_from_world);
  }
  bundle.row_terms.assign(bundle.views.size(), Vector6d::Zero());
  return bundle;
}

std::optional<OwnPose> own_pose(const Bundle& bundle, std::size_t view, const Lens& lens,
                                const Pose& pose) {
  const auto gram = products_of(bundle, view, {}, lens, pose);
  if (!gram) return std::nullopt;
  const Matrix6 information = gram->topLeftCorner<6, 6>().selfadjointView<Eigen::Upper>();
  const auto covariance = exact_inverse(information);
  if (!covariance) return std::nullopt;
  return OwnPose{pose, *covariance, (*gram)(gram->rows() - 1, gram->cols() - 1)};
}

// The means of the stamps at each instant, or without stamps its number; an instant without a view
// has the time of the one before, so that a search by time finds the others.
void set_times(const RigDataset& rig, RigState& state) {
  state.has_stamps = std::ranges::all_of(
      rig.cameras, [](const RigCamera& c) { return c.times_s.size() == c.data.views.size(); });
  std::vector<double> gaps;
  std::optional<double> last;  // time of an instant with views
  for (std::size_t t = 0; t < rig.instants.size(); ++t) {
    double sum = 0;
    int count = 0;
    for (std::size_t c = 0; state.has_stamps && c < rig.cameras.size(); ++c)
      if (const auto& view = rig.instants[t].view[c]) {
        sum += rig.cameras[c].times_s[*view];
        ++count;
      }
    if (!state.has_stamps)
      state.time.push_back(static_cast<double>(t));
    else if (count > 0)
      state.time.push_back(sum / count);
    else
      state.time.push_back(t > 0 ? state.time.back() : -std::numeric_limits<double>::infinity());
    if (state.has_stamps && count == 0) continue;
    if (last) gaps.push_back(state.time.back() - *last);
    last = state.time.back();
  }
  if (!gaps.empty()) state.gap = median(std::move(gaps));
}

}  // namespace

void take_stamps(const RigDataset& rig, RigState& state) {
  for (std::size_t c = 0; c < state.view_time.size(); ++c)
    for (std::size_t v = 0; v < state.view_time[c].size(); ++v)
      state.view_time[c][v] = rig.cameras[c].times_s[state.index_of_view[c][v]];
}

std::vector<std::vector<std::size_t>> RigState::views_at(std::size_t camera) const {
  std::vector<std::vector<std::size_t>> views(num_instants);
  for (std::size_t v = 0; v < instant[camera].size(); ++v)
    if (const auto& t = instant[camera][v]) views[*t].push_back(v);
  return views;
}

void RigState::set_alone(std::size_t camera, std::size_t view) {
  instant[camera][view].reset();
  poses.links[camera][view].motion = {};
  poses.links[camera][view].board = poses.first_board;
  poses.links[camera][view].instant = poses.rig_from_world.size();
  poses.rig_from_world.push_back(poses.camera_from_rig[camera].inverse() *
                                 own[camera][view].camera_from_world);
}

PlacedViews views_of_world(const RigDataset& rig) {
  PlacedViews views{{std::shared_ptr<const RigDataset>(), &rig}, {}, 1};
  for (const RigCamera& camera : rig.cameras) views.places.emplace_back(camera.data.views.size());
  for (std::size_t t = 0; t < rig.instants.size(); ++t)
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      if (const auto& view = rig.instants[t].view[c]) views.places[c][*view].instant = t;
  return views;
}

PlacedViews views_of_boards(const RigDataset& rig) {
  const PlacedViews whole = views_of_world(rig);
  const auto data = std::make_shared<RigDataset>(rig);
  PlacedViews views{data, {}, rig.cameras.front().data.boards.size()};
  std::map<CornerId, std::size_t> board_of;
  for (std::size_t b = 0; b < views.num_boards; ++b)
    for (const TargetPoint& p : target_points(rig.cameras.front().data.boards[b].board))
      board_of[p.id] = b;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    RigCamera& camera = data->cameras[c];
    for (PlacedBoard& board : camera.data.boards) board.world_from_board = {};
    camera.data.views.clear();
    camera.times_s.clear();
    views.places.emplace_back();
    for (std::size_t v = 0; v < rig.cameras[c].data.views.size(); ++v) {
      const View& picture = rig.cameras[c].data.views[v];
      std::map<std::size_t, View> by_board;
      for (const Observation& o : picture.observations)
        if (const auto at = board_of.find(o.id); at != board_of.end())
          by_board[at->second].observations.push_back(o);
      const std::optional<std::size_t>& instant = whole.places[c][v].instant;
      if (instant) data->instants[*instant].view[c].reset();
      for (auto& [board, view] : by_board) {
        view.image = picture.image;
        if (instant && !data->instants[*instant].view[c])
          data->instants[*instant].view[c] = camera.data.views.size();
        if (!rig.cameras[c].times_s.empty()) camera.times_s.push_back(rig.cameras[c].times_s[v]);
        camera.data.views.push_back(std::move(view));
        views.places[c].push_back({instant, board});
      }
    }
  }
  return views;
}

RigState rig_state(const PlacedViews& rig, const std::vector<Calibration>& own, RigLenses lenses) {
  const std::vector<RigCamera>& cameras = rig.data->cameras;
  RigState state;
  state.num_instants = rig.data->instants.size();
  state.poses.camera_from_rig.resize(cameras.size());
  state.poses.rig_from_world.resize(state.num_instants);
  state.poses.world_from_board.resize(rig.num_boards);
  set_times(*rig.data, state);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    Bundle bundle = bundle_of(cameras[c].data, own[c], model_in_rig(own[c], lenses, state));
    const Lens lens = bundle.lens();
    state.noise_px.push_back(own[c].rms_px / std::numbers::sqrt2);
    state.index_of_view.emplace_back();
    state.own.emplace_back();
    state.instant.emplace_back();
    state.view_time.emplace_back();
    std::vector<ViewProblem> views;
    std::vector<Pose> poses;
    std::vector<LinkedPoses::Link> links;
    for (std::size_t v = 0; v < bundle.views.size(); ++v) {
      const std::optional<OwnPose> pose = own_pose(bundle, v, lens, bundle.camera_from_target[v]);
      if (!pose) continue;
      const std::size_t index = own[c].views[v].view;
      const ViewPlace& place = rig.places[c][index];
      state.index_of_view[c].push_back(index);
      state.own[c].push_back(*pose);
      state.instant[c].push_back(place.instant);
      state.view_time[c].push_back(place.instant ? state.time[*place.instant] : 0);
      views.push_back(std::move(bundle.views[v]));
      poses.push_back(bundle.camera_from_target[v]);
      links.push_back({place.instant.value_or(0), place.board, {}});
    }
    bundle.views = std::move(views);
    bundle.camera_from_target = std::move(poses);
    bundle.row_terms.resize(bundle.views.size());
    state.cameras.push_back(std::move(bundle));
    state.poses.links.push_back(std::move(links));
  }
  return state;
}

void solve_places(RigState& state, const CalibrateOptions& options) {
  std::vector<Bundle> cameras = state.cameras;
  std::vector<std::shared_ptr<const HeldModels>> held;
  for (Bundle& camera : cameras) {
    held.push_back(models_of(camera.lens()));
    camera.model = &held.back()->of(kind_of(camera.lens()), ModelRole::largest);
    camera.free_values.clear();
  }
  solve(cameras, state.poses, options.max_iterations, options.num_threads);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    Bundle& camera = state.cameras[c];
    camera.camera_from_target = std::move(cameras[c].camera_from_target);
    camera.row_terms = std::move(cameras[c].row_terms);
    camera.shape = cameras[c].shape;
  }
}

void update_own_poses(RigState& state) {
  ViewProblem buffer;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const Bundle& bundle = state.cameras[c];
    const Lens lens = bundle.lens();
    for (std::size_t v = 0; v < bundle.views.size(); ++v) {
      OwnPose& own = state.own[c][v];
      const ViewProblem& view = bundle.corrected(v, buffer);
      auto refined = refine_view_pose(view, lens, own.camera_from_world);
      const Pose predicted = state.poses.camera_from_board(c, state.poses.links[c][v]);
      const auto of_rig = refine_view_pose(view, lens, predicted);
      if (of_rig && (!refined || of_rig->cost < refined->cost + policy::kAmbiguousCost))
        refined = of_rig;
      if (!refined) continue;
      if (const auto pose = own_pose(bundle, v, lens, refined->camera_from_target)) own = *pose;
    }
  }
}

std::optional<Pose> half_turn_of(const std::vector<PlacedBoard>& boards) {
  if (boards.size() != 1) return std::nullopt;
  const Board& board = boards.front().board;
  if (!point_grid(board) || !tags_of(board).empty()) return std::nullopt;
  const std::vector<TargetPoint> points = target_points(board);
  Vector3d centre = Vector3d::Zero();
  for (const TargetPoint& p : points) centre += p.position / static_cast<double>(points.size());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ()));
  const Pose half_turn(turn, 2 * Vector3d(centre.x(), centre.y(), 0));
  // The last point is the first one turned: grids count row by row.
  const double error = (half_turn * points.front().position - points.back().position).norm();
  if (error >
      1e-6 * (points.front().position - points.back().position).norm())  // numeric: rounding
    return std::nullopt;
  const Pose& place = boards.front().world_from_board;
  return place * half_turn * place.inverse();
}

void turn_view(RigState& state, std::size_t camera, std::size_t view, const Pose& half_turn) {
  for (Correspondence& c : state.cameras[camera].views[view].correspondences.own())
    c.point = half_turn * c.point;
  Pose& pose = state.own[camera][view].camera_from_world;
  pose = pose * half_turn;
}

double cost_of_view(const RigState& state, std::size_t camera, std::size_t view) {
  const Bundle& bundle = state.cameras[camera];
  const Pose pose = state.poses.camera_from_board(camera, state.poses.links[camera][view]);
  const auto gram = products_of(bundle, view, {}, bundle.lens(), pose);
  return gram ? (*gram)(gram->rows() - 1, gram->cols() - 1)
              : std::numeric_limits<double>::infinity();
}

}  // namespace tagcal::internal
