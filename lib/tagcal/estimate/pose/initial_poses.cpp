#include "tagcal/estimate/pose/initial_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/solvers/n_point.hpp"
#include "tagcal/solvers/numeric/plane_tilts.hpp"
#include "tagcal/solvers/p3p.hpp"
#include "tagcal/solvers/p4pf.hpp"
#include "tagcal/solvers/plane.hpp"
#include "tagcal/solvers/weak_perspective.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFew = 48;     // points up to which the closed forms use all,
constexpr std::size_t kSubset = 32;  // points of a larger problem that the starts use
constexpr std::size_t kVeryFew = 5;  // points up to which minimal solvers give better starts

// A subset of the points for the closed forms. Multiples of the golden ratio select it, so that it
// does not follow a regular pattern such as a row of a grid.
class PointSubset {
 public:
  PointSubset(const PoseProblem& problem, std::size_t limit)
      : points_(problem.size() <= kFew ? problem.size() : limit),
        pixels_(points_.size()),
        rays_(points_.size()) {
    const ViewPoints view = problem.view();
    const auto n = static_cast<double>(problem.size());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      constexpr double kGoldenRatio = std::numbers::phi - 1;
      const double turn = kGoldenRatio * static_cast<double>(k);
      const bool all = points_.size() == problem.size();
      const std::size_t i = all ? k : static_cast<std::size_t>((turn - std::floor(turn)) * n);
      points_[k] = view.points[i];
      pixels_[k] = view.pixels[i];
      if (!view.whitening.empty()) whitening_.push_back(view.whitening[i]);
    }
  }

  bool find_rays(const Lens& lens) {
    return internal::find_rays(lens, pixels_.span(), {rays_.data(), rays_.size()});
  }
  void subtract(const Vector2d& centre) {
    for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i] -= centre;
  }

  std::span<const Vector3d> points() const { return points_.span(); }
  std::span<const Vector2d> pixels() const { return pixels_.span(); }
  std::span<const Vector3d> rays() const { return rays_.span(); }
  ViewPoints view() const { return {points_.span(), pixels_.span(), whitening_}; }
  InlineBuffer<Vector2d, kFew> points_in_plane() const {
    InlineBuffer<Vector2d, kFew> result(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) result[i] = points_[i].head<2>();
    return result;
  }

 private:
  InlineBuffer<Vector3d, kFew> points_;
  InlineBuffer<Vector2d, kFew> pixels_;
  InlineBuffer<Vector3d, kFew> rays_;
  std::vector<Matrix2> whitening_;
};

template <int N>
void add_start(const ViewState& state, ViewSums& sums, InitialPoses<N>& starts) {
  InitialPose<N> start{state};
  start.has_equations = sums.at(start.state, start.equations);
  if (!start.has_equations) return;
  start.cost = start.equations.cost;
  starts.insert(start, has_less_cost);
}

// Returns four points far from one another: the furthest from the centre, from the first one, from
// the line of both, and from the plane of the three; in a plane, from the lines of any two of them.
std::array<std::size_t, 4> four_spread(std::span<const Vector3d> points, PointShape shape) {
  if (shape == PointShape::plane && points.size() == 4) return {0, 1, 2, 3};
  std::array<std::size_t, 4> chosen;
  const auto furthest = [&](const auto& distance) {
    std::size_t best = 0;
    double longest = -1;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (const double d = distance(points[i]); d > longest) {
        longest = d;
        best = i;
      }
    return best;
  };
  chosen[0] = furthest([](const Vector3d& p) { return p.squaredNorm(); });
  const Vector3d a = points[chosen[0]];
  chosen[1] = furthest([&](const Vector3d& p) { return (p - a).squaredNorm(); });
  const Vector3d b = points[chosen[1]] - a;
  chosen[2] = furthest([&](const Vector3d& p) { return (p - a).cross(b).squaredNorm(); });
  const Vector3d c = points[chosen[2]] - a, normal = b.cross(c);
  if (shape == PointShape::plane)
    chosen[3] = furthest([&](const Vector3d& p) {
      const Vector3d d = p - a;
      return std::min(
          {d.cross(b).squaredNorm(), d.cross(c).squaredNorm(), (d - b).cross(c - b).squaredNorm()});
    });
  else
    chosen[3] = furthest([&](const Vector3d& p) { return std::abs((p - a).dot(normal)); });
  return chosen;
}

// Adds the P3P poses of each three of four points, the first three first. Stops once a start costs
// at most `enough`.
void add_p3p(std::span<const Vector3d> points, std::span<const Vector3d> rays,
             const std::array<std::size_t, 4>& four, ViewSums& sums, InitialPoses<6>& starts,
             double enough = 0) {
  for (const std::size_t skipped : {3, 2, 1, 0}) {
    if (!starts.empty() && starts.front().cost <= enough) return;
    std::array<Vector3d, 3> some_points, some_rays;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = four[k < skipped ? k : k + 1];
      some_points[k] = points[i];
      some_rays[k] = rays[i];
    }
    for (const Pose& pose : p3p(some_points, some_rays)) add_start(state_of(pose), sums, starts);
  }
}

// True for four points in a plane that are far from a square: one of them nearly on the line of two
// others, or within the triangle of the others. Their homography is too sensitive to noise.
bool is_poor_quadrangle(std::span<const Vector3d> points, const std::array<std::size_t, 4>& four) {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t skipped = 0; skipped < 4; ++skipped) {
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = points[four[k < skipped ? k : k + 1]];
    const double area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
    smallest = std::min(smallest, area);
    largest = std::max(largest, area);
  }
  return !(smallest > policy::kPoorQuadrangle * largest);
}

void add_pnp(const PointSubset& chosen, ViewSums& sums, InitialPoses<6>& starts) {
  for (const Pose& pose : pnp(chosen.points(), chosen.rays()))
    add_start(state_of(pose), sums, starts);
}

void add_plane(const PointSubset& chosen, ViewSums& sums, InitialPoses<6>& starts) {
  if (const auto h = homography(chosen.points_in_plane().span(), chosen.rays()))
    if (const auto tilts = ippe_tilts(*h))
      for (const Eigen::Matrix3d& rotation : tilts->rotation)
        add_start({rotation, tilts->translation}, sums, starts);
  if (chosen.points().size() <= kVeryFew) {
    const auto four = four_spread(chosen.points(), PointShape::plane);
    if (starts.empty() || is_poor_quadrangle(chosen.points(), four))
      add_p3p(chosen.points(), chosen.rays(), four, sums, starts);
  }
  if (starts.empty()) add_pnp(chosen, sums, starts);
}

// Cost of residuals that are the largest that noise has, policy::kLargestNoiseOfImage.
double cost_of_largest_noise(const ViewPoints& view) {
  Vector2d centre = Vector2d::Zero();
  for (const Vector2d& p : view.pixels) centre += p / static_cast<double>(view.size());
  double sum = 0;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Vector2d p = view.pixels[i] - centre;
    sum += view.whitening.empty() ? p.squaredNorm() : (view.whitening[i] * p).squaredNorm();
  }
  return policy::kLargestNoiseOfImage * policy::kLargestNoiseOfImage * sum;
}

// Three points far from one another nearly always give a start near the minimum; then neither other
// triples nor the closed form of all points is needed.
void add_space(const PointSubset& chosen, ViewSums& sums, InitialPoses<6>& starts) {
  const auto four = four_spread(chosen.points(), PointShape::space);
  const double enough = cost_of_largest_noise(chosen.view());
  add_p3p(chosen.points(), chosen.rays(), four, sums, starts, enough);
  const bool is_poor = starts.empty() || starts.front().cost > enough;
  if (is_poor && (starts.empty() || chosen.points().size() > kVeryFew))
    add_pnp(chosen, sums, starts);
}

// Adds the solutions for four of the points; of more than a few points only the best one.
void add_p4pf(const PointSubset& chosen, ViewSums& sums, InitialPoses<7>& starts) {
  const auto four = four_spread(chosen.points(), PointShape::space);
  std::array<Vector3d, 4> points;
  std::array<Vector2d, 4> pixels;
  for (std::size_t k = 0; k < 4; ++k) {
    points[k] = chosen.points()[four[k]];
    pixels[k] = chosen.pixels()[four[k]];
  }
  InitialPoses<7> found;
  for (const PoseAndFocal& solution : p4pf(points, pixels))
    add_start(state_of(solution.camera_from_target, solution.focal_px), sums, found);
  while (chosen.points().size() > kVeryFew && found.size() > 1) found.pop_back();
  for (const InitialPose<7>& start : found) starts.insert(start, has_less_cost);
}

// Adds the weak-perspective poses, at the distance that the guessed focal length gives them.
void add_weak_perspective(const PointSubset& chosen, double focal_px, ViewSums& sums,
                          InitialPoses<7>& starts) {
  for (const WeakPerspectivePose& weak : weak_perspective_poses(chosen.points(), chosen.pixels())) {
    ViewState state = state_of(weak.camera_from_target, focal_px);
    state.translation.z() = focal_px / weak.scale_px_per_m;
    add_start(state, sums, starts);
  }
}

}  // namespace

bool find_rays(const Lens& lens, std::span<const Eigen::Vector2d> pixels,
               std::span<Eigen::Vector3d> rays) {
  return std::visit(
      [&](const auto& l) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
          const std::optional<Ray> ray = l.ray_in_camera(pixels[i]);
          if (!ray) return false;
          rays[i] = ray->direction;
        }
        return true;
      },
      lens);
}

Eigen::Vector2d principal_point(const Lens& pinhole) {
  return {parameters(pinhole)[kCx], parameters(pinhole)[kCy]};
}

// Refines the starts on a subset of the points and sorts them by cost. The cost of a subset is a
// lower bound of the cost of all points, so a start that the subset excludes is dropped.
InitialPoses<6> refined_on(ViewSums& some, const InitialPoses<6>& starts) {
  InitialPoses<6> result;
  RefineOptions options;
  for (const InitialPose<6>& start : starts) {
    const auto solution = refine_pose<6>(some, start, options);
    if (!solution) continue;
    result.insert({solution->state, solution->cost}, has_less_cost);
    const double freedom = 2 * static_cast<double>(some.num_points()) - 6;
    options.ruled_out_cost = result.front().cost * (1 + policy::kExcludedCost / freedom);
  }
  return result;
}

// A plane without a homography (three corners on a line) is solved like points in space. So are
// four or five points of a plane whose homography is poor.
InitialPoses<6> initial_poses(const PoseProblem& problem, const Lens& lens) {
  InitialPoses<6> starts;
  for (const std::size_t limit : {kSubset, problem.size()}) {
    PointSubset chosen(problem, limit);
    if (!chosen.find_rays(lens)) continue;
    const bool all = chosen.points().size() == problem.size();
    ViewSums some(lens, all ? problem.view() : chosen.view());
    if (problem.spread().shape == PointShape::plane)
      add_plane(chosen, some, starts);
    else
      add_space(chosen, some, starts);
    if (all) return starts;
    if (!starts.empty()) return refined_on(some, starts);
  }
  return starts;
}

InitialPoses<7> initial_poses_with_focal(const PoseProblem& problem, const Lens& guess,
                                         ViewSums& sums) {
  InitialPoses<7> starts;
  PointSubset chosen(problem, kSubset);
  chosen.subtract(principal_point(guess));
  // Points near a plane use both closed forms: which one is nearer depends on thickness and noise.
  constexpr double kFlat = 1e-6;  // numeric: p4pf needs a height above rounding
  if (problem.spread().thickness < policy::kPlaneStartThickness)
    if (const auto solution =
            plane_pose_and_focal(chosen.points_in_plane().span(), chosen.pixels()))
      add_start(state_of(solution->camera_from_target, solution->focal_px), sums, starts);
  if (problem.spread().thickness > kFlat) add_p4pf(chosen, sums, starts);
  // Four or five points in space determine the focal length poorly, and all minima are needed.
  const bool few = problem.spread().shape == PointShape::space && problem.size() <= kVeryFew;
  constexpr double kSquare = policy::kPoorStartRmsPx * policy::kPoorStartRmsPx;
  const double poor = kSquare * static_cast<double>(problem.size());
  if (few || starts.empty() || starts.front().cost > poor)
    add_weak_perspective(chosen, parameters(guess)[kFx], sums, starts);
  return starts;
}

}  // namespace tagcal::internal
