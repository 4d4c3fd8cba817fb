#include "tagcal/estimate/pose/initial_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tagcal/camera/kernels/parameter_index.hpp"
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

constexpr std::size_t kFew = 32;     // points that a start is made of
constexpr std::size_t kVeryFew = 5;  // points for which minimal solvers are the better ones

// The points that the closed forms use: a start needs no more. In the order of the golden ratio, so
// that no regular pattern (a row of a grid) is all that is chosen.
class Chosen {
 public:
  Chosen(const PoseProblem& problem, std::size_t limit)
      : points_(std::min(limit, problem.size())), pixels_(points_.size()), rays_(points_.size()) {
    const ViewPoints view = problem.view();
    const auto n = static_cast<double>(problem.size());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      constexpr double kGoldenRatio = 0.6180339887498949;
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
void consider(const ViewState& state, ViewSums& sums, ViewStarts<N>& starts) {
  ViewStart<N> start{state};
  start.has_equations = sums.at(start.state, start.equations);
  if (!start.has_equations) return;
  start.cost = start.equations.cost;
  starts.insert(start,
                [](const ViewStart<N>& a, const ViewStart<N>& b) { return a.cost < b.cost; });
}

// Four points far from one another: the furthest from the centre, from it, from their line and from
// their plane; in a plane, from the lines of any two of them.
std::array<std::size_t, 4> four_spread(std::span<const Vector3d> points, PointShape shape) {
  if (points.size() == 4) return {0, 1, 2, 3};
  std::array<std::size_t, 4> chosen;
  const auto furthest = [&](const auto& distance) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
      if (distance(points[i]) > distance(points[best])) best = i;
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

// The poses of three of four points far from one another, whichever three.
template <int N>
void consider_p3p(std::span<const Vector3d> points, std::span<const Vector3d> rays,
                  const std::array<std::size_t, 4>& four, double focal_px, ViewSums& sums,
                  ViewStarts<N>& starts) {
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    std::array<Vector3d, 3> some_points, some_rays;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = four[k < left_out ? k : k + 1];
      some_points[k] = points[i];
      some_rays[k] = rays[i];
    }
    for (const Pose& pose : p3p(some_points, some_rays))
      consider(state_of(pose, focal_px), sums, starts);
  }
}

// Whether four points in a plane are far from a square: one of them nearly on the line of two
// others, or within the triangle of the others. Noise then makes anything of their homography.
bool is_poor_quadrangle(std::span<const Vector3d> points, const std::array<std::size_t, 4>& four) {
  constexpr double kPoor = 0.5;  // the smallest of the four triangles, of the largest; a square: 1
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    std::array<Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = points[four[k < left_out ? k : k + 1]];
    const double area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
    smallest = std::min(smallest, area);
    largest = std::max(largest, area);
  }
  return !(smallest > kPoor * largest);
}

void consider_space_with_focal(const Chosen& chosen, ViewSums& sums, ViewStarts<7>& starts) {
  const auto four = four_spread(chosen.points(), PointShape::space);
  std::array<Vector3d, 4> points;
  std::array<Vector2d, 4> pixels;
  for (std::size_t k = 0; k < 4; ++k) {
    points[k] = chosen.points()[four[k]];
    pixels[k] = chosen.pixels()[four[k]];
  }
  for (const PoseAndFocal& solution : p4pf(points, pixels))
    consider(state_of(solution.camera_from_target, solution.focal_px), sums, starts);
}

// Four or five points hardly tell one focal length from another: every minimum that they have
// counts, and the poses for some focal lengths lead to those.
void consider_ladder_of_focals(const Chosen& chosen, double guess_px, ViewSums& sums,
                               ViewStarts<7>& starts) {
  const auto four = four_spread(chosen.points(), PointShape::space);
  for (const double ratio : {0.35, 1.0, 3.0}) {
    InlineBuffer<Vector3d, kFew> rays(chosen.pixels().size());
    const double focal = ratio * guess_px;
    for (std::size_t i = 0; i < rays.size(); ++i)
      rays[i] = Vector3d(chosen.pixels()[i].x(), chosen.pixels()[i].y(), focal);
    consider_p3p(chosen.points(), rays.span(), four, focal, sums, starts);
  }
}

// Weak perspective, put at the distance where the guessed focal length makes it perspective.
void consider_weak_perspective(const Chosen& chosen, double focal_px, ViewSums& sums,
                               ViewStarts<7>& starts) {
  for (const WeakPerspectivePose& weak : weak_perspective_poses(chosen.points(), chosen.pixels())) {
    ViewState state = state_of(weak.camera_from_target, focal_px);
    state.translation.z() = focal_px / weak.scale_px_per_m;
    consider(state, sums, starts);
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

// Starts of some of the points become starts of all: refined on those, in the order of their costs,
// which are lower bounds then. What some points exclude by 25 sigma^2 all will.
ViewStarts<6> refined_on(ViewSums& some, const ViewStarts<6>& starts) {
  ViewStarts<6> result;
  ViewSolverOptions options;
  for (const ViewStart<6>& start : starts) {
    const auto solution = solve_view<6>(some, start, options);
    if (!solution) continue;
    result.insert({solution->state, solution->cost},
                  [](const ViewStart<6>& a, const ViewStart<6>& b) { return a.cost < b.cost; });
    const double freedom = 2 * static_cast<double>(some.num_points()) - 6;
    options.ruled_out_cost = result.front().cost * (1 + 25 / freedom);
  }
  return result;
}

// A plane whose homography does not tell (three corners on a line) is solved as points in space
// are, and of four or five points also one whose homography tells little.
ViewStarts<6> find_starts(const PoseProblem& problem, const Lens& lens) {
  ViewStarts<6> starts;
  for (const std::size_t limit : {kFew, problem.size()}) {
    Chosen chosen(problem, limit);
    if (!chosen.find_rays(lens)) continue;
    const bool all = chosen.points().size() == problem.size();
    ViewSums some(lens, all ? problem.view() : chosen.view());
    if (problem.spread().shape == PointShape::plane)
      if (const auto h = homography(chosen.points_in_plane().span(), chosen.rays()))
        if (const auto tilts = ippe_tilts(*h))
          for (const Eigen::Matrix3d& rotation : tilts->rotation)
            consider({rotation, tilts->translation}, some, starts);
    if (problem.size() <= kVeryFew) {
      const auto four = four_spread(chosen.points(), problem.spread().shape);
      if (starts.empty() || is_poor_quadrangle(chosen.points(), four))
        consider_p3p(chosen.points(), chosen.rays(), four, 0, some, starts);
    }
    if (starts.empty())
      for (const Pose& pose : pnp(chosen.points(), chosen.rays()))
        consider(state_of(pose), some, starts);
    if (all) return starts;
    if (!starts.empty()) return refined_on(some, starts);
  }
  return starts;
}

ViewStarts<7> find_starts_with_focal(const PoseProblem& problem, const Lens& guess,
                                     ViewSums& sums) {
  ViewStarts<7> starts;
  Chosen chosen(problem, kFew);
  chosen.subtract(principal_point(guess));
  // Nearly a plane is both: which of the two is nearer depends on the thickness and the noise.
  constexpr double kFlat = 1e-6, kThick = 0.3;
  constexpr double kPoorRms = 2;  // of a start that may lead astray
  if (problem.spread().thickness < kThick)
    if (const auto solution =
            plane_pose_and_focal(chosen.points_in_plane().span(), chosen.pixels()))
      consider(state_of(solution->camera_from_target, solution->focal_px), sums, starts);
  if (problem.spread().thickness > kFlat) consider_space_with_focal(chosen, sums, starts);
  if (problem.spread().shape == PointShape::space && problem.size() <= kVeryFew)
    consider_ladder_of_focals(chosen, parameters(guess)[kFx], sums, starts);
  const double poor = kPoorRms * kPoorRms * static_cast<double>(problem.size());
  if (starts.empty() || starts.front().cost > poor)
    consider_weak_perspective(chosen, parameters(guess)[kFx], sums, starts);
  return starts;
}

}  // namespace tagcal::internal
