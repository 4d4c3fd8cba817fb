#include "tagcal/estimate/advice.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "tagcal/estimate/bundle/covariance.hpp"
#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/projection_effect.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::string formatted(double value) { return with_digits(value, 3); }

struct PossibleView {
  double tilt_rad = 0;
  int side = 0;  // the side nearest to the camera: 0 upper, 1 upper right, ... by 45 degrees
  int column = 0, row = 0;  // -1, 0, 1
  double distance_m = 1;
};

std::vector<PossibleView> candidates(double distance_m) {
  std::vector<PossibleView> all;
  for (const double share : {1.0, 0.7, 0.5, 1.4})  // numeric: tried values
    for (const int row : {0, -1, 1})
      for (const int column : {0, -1, 1})
        for (const double tilt_deg : {0, 20, 40, 55})
          for (int side = 0; side < (tilt_deg > 0 ? 8 : 1); ++side)
            all.push_back({tilt_deg * kDegree, side, column, row, share * distance_m});
  return all;
}

// The points of the largest board, in its frame (metres).
struct BoardPoints {
  std::vector<Vector3d> points;
  Vector3d centre = Vector3d::Zero();
  Vector3d centre_in_world = Vector3d::Zero();
  double size = 0;  // diameter

  explicit BoardPoints(const Dataset& dataset) {
    Pose world_from_board;
    for (const PlacedBoard& placed : dataset.boards) {
      const auto of_board = target_points(placed.board);
      if (of_board.size() <= points.size()) continue;
      points.clear();
      for (const TargetPoint& p : of_board) points.push_back(p.position);
      world_from_board = placed.world_from_board;
    }
    for (const Vector3d& p : points) centre += p / static_cast<double>(points.size());
    centre_in_world = world_from_board * centre;
    for (const Vector3d& p : points) size = std::max(size, 2 * (p - centre).norm());
  }
};

Vector2d pixel_of(const PossibleView& c, const ImageSize& size) {
  constexpr double kOffset = 0.3;  // numeric: tried places, as a share of the image
  return image_centre(size) + kOffset * Vector2d(c.column * size.width, c.row * size.height);
}

std::optional<Pose> pose_of(const PossibleView& c, const Camera& camera, const BoardPoints& board) {
  const auto ray = ray_in_camera(camera.lens, pixel_of(c, camera.image_size));
  if (!ray) return std::nullopt;
  const double angle = c.side * std::numbers::pi / 4;
  const Eigen::Quaterniond to_ray = rotation_between(Vector3d::UnitZ(), ray->direction);
  const Eigen::Quaterniond tilt =
      exp_rotation(c.tilt_rad * Vector3d(std::cos(angle), std::sin(angle), 0));
  const Eigen::Quaterniond facing(0, 1, 0, 0);  // x right, y up, z to the viewer
  const Eigen::Quaterniond rotation = to_ray * tilt * facing;
  return Pose(rotation, c.distance_m * ray->direction - rotation * board.centre);
}

// The view of the board's visible points. No value if fewer than half of them are visible.
std::optional<ViewProblem> visible_part(const BoardPoints& board, const Camera& camera,
                                        const Pose& camera_from_board) {
  ViewProblem view;
  for (const Vector3d& x : board.points) {
    const auto pixel = project(camera.lens, camera_from_board * x);
    if (pixel && contains(camera.image_size, *pixel)) view.correspondences.push_back({x, *pixel});
  }
  if (2 * view.correspondences.size() < board.points.size()) return std::nullopt;
  return view;
}

// The estimate that a new view is to improve.
struct CurrentEstimate {
  std::shared_ptr<const HeldModels> models;  // owns the model
  const Model* model = nullptr;
  Camera camera;
  MatrixXd information;
  double sigma_px = 1;
  double inflation = 1;  // of the variance of what a view tells
  ViewRowTerms rows;
  double distance_m = 1;
  SeenRegion seen;  // empty if the model has no distortion
};

// Noise per coordinate (px) expected in the next view: the RMS of the residuals if the corners have
// covariances of their own (sigma_px is 1 then).
double expected_noise(const Calibration& c) {
  return c.sigma_of_corners ? c.rms_px / std::numbers::sqrt2 : c.sigma_px;
}

bool has_distortion(const Model& model) {
  for (std::size_t i = 0; i < model.free().size(); ++i)
    if (const ParameterRole role = model.parameter(i).role;
        role == ParameterRole::radial || role == ParameterRole::shape)
      return true;
  return false;
}

std::optional<CurrentEstimate> current_estimate(const Calibration& c, const BoardPoints& board) {
  if (!c.camera) return std::nullopt;
  CurrentEstimate current;
  current.camera = *c.camera;
  current.sigma_px = expected_noise(c);
  current.inflation = std::max(1.0, c.variance_inflation);  // as of the views that there are
  current.rows = {image_centre(c.camera->image_size).y(), c.row_sigma / current.sigma_px};
  if (is_answer(c.status) && c.covariance.size() > 0) {
    current.models = std::make_shared<const HeldModels>(c.fixed, Model::named(c.model).kind());
    current.model = &current.models->named(c.model);
    const auto information = exact_inverse(c.covariance);
    if (!information) return std::nullopt;
    current.information = *information;
    if (c.views.empty()) return std::nullopt;  // no distance to begin with
    std::vector<double> distances;
    for (const CalibratedView& view : c.views)
      distances.push_back((view.camera_from_world * board.centre_in_world).norm());
    std::sort(distances.begin(), distances.end());
    current.distance_m = distances[distances.size() / 2];
    if (has_distortion(*current.model)) current.seen = c.seen;
    return current;
  }
  const ImageSize& size = c.camera->image_size;
  const double focal = std::max(size.width, size.height);
  const Vector2d centre = image_centre(size);
  current.model = &Model::named("f");
  current.camera.lens = pinhole(focal, focal, centre.x(), centre.y());
  current.information = MatrixXd::Zero(1, 1);
  // numeric: two thirds of the shorter side, as the middle of the tried distances
  current.distance_m = 1.5 * board.size * focal / std::min(size.width, size.height);
  return current;
}

double focal_sigma(const Model& model, const MatrixXd& covariance) {
  double largest = 0;
  for (int i = 0; i < model.num_free(); ++i)
    if (model.parameter(static_cast<std::size_t>(i)).role == ParameterRole::focal_length)
      largest = std::max(largest, std::sqrt(covariance(i, i)));
  return largest;
}

std::string instruction_of(const PossibleView& c, const AdvisedView& view) {
  constexpr std::array<std::array<int, 2>, 8> kSides = {
      {{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}}};
  const auto& side = kSides[static_cast<std::size_t>(c.side)];
  std::string text = "show the board in the " + side_name(c.column, c.row, "middle") +
                     (c.column != 0 && c.row != 0   ? " corner"
                      : c.column != 0 || c.row != 0 ? " part"
                                                    : "") +
                     " of the image, " + with_digits(view.distance_m, 2) + " m away, ";
  if (c.tilt_rad > 0)
    text += "tilted by " + formatted(c.tilt_rad / kDegree) + " degrees, " +
            side_name(side[0], side[1], "") + (side[0] != 0 && side[1] != 0 ? " corner" : " edge") +
            " near";
  else
    text += "facing the camera";
  return text + (view.fills.empty() ? "" : ", which covers the " + listed(view.fills));
}

std::string sentence_of(const AdvisedView& view, bool known_before) {
  const std::string text = view.instruction +
                           ": it makes the standard deviation of the focal length " +
                           formatted(view.focal_sigma_px) + " px";
  if (known_before) return text + " (now " + formatted(view.focal_sigma_now_px) + " px)";
  return text + " if the focal length is about the longer side of the image";
}

// The missing parts of the image that a view would cover.
std::vector<std::string> parts_covered_by(const ViewProblem& view, const CurrentEstimate& current,
                                          std::vector<std::string> missing) {
  if (missing.empty()) return {};
  std::vector<Vector2d> pixels = current.seen.hull();
  for (const Correspondence& c : view.correspondences) pixels.push_back(c.pixel);
  const auto still_missing = SeenRegion(current.camera.image_size, pixels).missing_parts();
  std::erase_if(missing,
                [&](const auto& part) { return std::ranges::count(still_missing, part) > 0; });
  return missing;
}

struct JudgedView {
  PossibleView candidate;
  Pose pose;
  MatrixXd covariance;  // of the parameters after this view
  double variance = 0;  // of the projection at infinity, mean over the image, px^2
  std::vector<std::string> fills;
};

std::vector<JudgedView> judge_candidates(const BoardPoints& board, const CurrentEstimate& current) {
  const MatrixXd effect = projection_effect(*current.model, current.camera);
  const std::vector<std::string> missing = current.seen.missing_parts();
  const double noise = current.inflation * current.sigma_px * current.sigma_px;
  std::vector<JudgedView> all;
  for (const PossibleView& c : candidates(current.distance_m)) {
    const auto pose = pose_of(c, current.camera, board);
    const auto view = pose ? visible_part(board, current.camera, *pose) : std::nullopt;
    if (!view) continue;
    const auto added =
        information_of(*view, current.camera.lens, *current.model, *pose, current.rows);
    if (!added) continue;
    const auto covariance = exact_inverse(current.information + added->schur / noise);
    if (!covariance) continue;
    all.push_back({c, *pose, *covariance, (effect * *covariance).trace(),
                   parts_covered_by(*view, current, missing)});
  }
  return all;
}

// The view that fills most missing parts, of those with nearly the least variance.
const JudgedView* best_view(const std::vector<JudgedView>& all) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const JudgedView& j : all) lowest = std::min(lowest, j.variance);
  const JudgedView* best = nullptr;
  for (const JudgedView& j : all) {
    if (!(j.variance <= policy::kNearlyLeastVariance * lowest)) continue;
    if (!best || j.fills.size() > best->fills.size() ||
        (j.fills.size() == best->fills.size() && j.variance < best->variance))
      best = &j;
  }
  return best;
}

}  // namespace

std::optional<AdvisedView> advise(const Dataset& dataset, const Calibration& calibration) {
  const BoardPoints board(dataset);
  const std::optional<CurrentEstimate> current = current_estimate(calibration, board);
  if (!current) return std::nullopt;
  const std::vector<JudgedView> all = judge_candidates(board, *current);
  const JudgedView* best = best_view(all);
  if (!best) return std::nullopt;
  const auto before = exact_inverse(current->information);
  AdvisedView view{
      best->pose,
      best->candidate.tilt_rad,
      best->candidate.distance_m,
      pixel_of(best->candidate, current->camera.image_size),
      focal_sigma(*current->model, best->covariance),
      before ? focal_sigma(*current->model, *before) : std::numeric_limits<double>::infinity(),
      std::sqrt(best->variance),
      best->fills,
      "",
      ""};
  view.instruction = instruction_of(best->candidate, view);
  view.sentence = sentence_of(view, before.has_value());
  return view;
}

}  // namespace tagcal
