#include "tagcal/estimate/pose_fit.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/closed_form.hpp"
#include "tagcal/estimate/planar.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFew = 32;  // points that a start is made of
using Starts = Solutions<ViewStart<6>, 4>;

void consider(const Pose& pose, ViewSums& sums, Starts& starts) {
  ViewStart<6> start{state_of(pose), {}};
  if (!sums.at(start.state, start.equations)) return;
  starts.insert(start, [](const ViewStart<6>& a, const ViewStart<6>& b) {
    return a.equations.cost < b.equations.cost;
  });
}

// The points that the closed forms use: a start needs no more. In the order of the golden ratio, so
// that no regular pattern (a row of a grid) is all that is chosen.
class Chosen {
 public:
  Chosen(const PoseProblem& problem, std::size_t limit)
      : points_(std::min(limit, problem.size())), pixels_(points_.size()), rays_(points_.size()) {
    const ViewPoints view = problem.view();
    for (std::size_t k = 0; k < points_.size(); ++k) {
      constexpr double kGoldenRatio = 0.6180339887498949;
      const double turn = kGoldenRatio * static_cast<double>(k);
      const std::size_t i = points_.size() == problem.size()
                                ? k
                                : static_cast<std::size_t>((turn - std::floor(turn)) *
                                                           static_cast<double>(problem.size()));
      points_[k] = view.points[i];
      pixels_[k] = view.pixels[i];
    }
  }

  bool find_rays(const Lens& lens) {
    return tagcal::find_rays(lens, pixels_.span(), {rays_.data(), rays_.size()});
  }
  std::span<const Vector3d> points() const { return points_.span(); }
  std::span<const Vector3d> rays() const { return rays_.span(); }

 private:
  InlineBuffer<Vector3d, kFew> points_;
  InlineBuffer<Vector2d, kFew> pixels_;
  InlineBuffer<Vector3d, kFew> rays_;
};

void consider_plane_poses(const Chosen& chosen, ViewSums& sums, Starts& starts) {
  InlineBuffer<Vector2d, kFew> points(chosen.points().size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = chosen.points()[i].head<2>();
  const auto h = homography(points.span(), chosen.rays());
  if (!h) return;
  for (const Pose& pose : ippe(*h)) consider(pose, sums, starts);
}

// By the shape of the points. A plane whose homography does not tell (three corners on a line) is
// solved as points in space are.
Starts find_starts(const PoseProblem& problem, const Lens& lens, ViewSums& sums) {
  Starts starts;
  for (const std::size_t limit : {kFew, problem.size()}) {
    Chosen chosen(problem, limit);
    if (!chosen.find_rays(lens)) continue;
    if (problem.spread().shape == PointShape::plane) consider_plane_poses(chosen, sums, starts);
    if (starts.empty())
      if (const auto pose = pose_from_points_dlt(chosen.points(), chosen.rays()))
        consider(*pose, sums, starts);
    if (!starts.empty() || problem.size() <= kFew) break;
  }
  return starts;
}

bool is_same(const ViewState& a, const ViewState& b) {
  return (a.rotation - b.rotation).squaredNorm() < 2e-8;  // angle below 1e-4
}

// Keeps the solutions sorted by cost, each once.
void insert(const ViewSolution<6>& solution, Solutions<ViewSolution<6>, 4>& poses) {
  for (const ViewSolution<6>& other : poses)
    if (is_same(solution.state, other.state)) return;
  poses.insert(solution,
               [](const ViewSolution<6>& a, const ViewSolution<6>& b) { return a.cost < b.cost; });
}

}  // namespace

bool find_rays(const Lens& lens, std::span<const Vector2d> pixels, std::span<Vector3d> rays) {
  return std::visit(
      [&](const auto& l) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
          const auto ray = l.ray_in_camera(pixels[i]);
          if (!ray) return false;
          rays[i] = ray->direction;
        }
        return true;
      },
      lens);
}

std::optional<PoseFit> fit_pose(const PoseProblem& problem, const Lens& lens,
                                const PoseOptions& options) {
  ViewSums sums(lens, problem.view());
  ViewSolverOptions solver;
  solver.max_iterations = options.max_iterations;
  std::optional<PoseFit> fit(std::in_place);
  double limit = 0;  // of what is still a candidate
  for (const ViewStart<6>& start : find_starts(problem, lens, sums)) {
    const auto solution = solve_view<6>(sums, start, solver);
    if (!solution || (!fit->poses.empty() && solution->cost > limit)) continue;
    insert(*solution, fit->poses);
    fit->noise = noise_level(problem, options, fit->poses.front().cost, 6);
    limit = fit->poses.front().cost + kAmbiguousCost * fit->noise.sigma_px * fit->noise.sigma_px;
    solver.ruled_out_cost = limit;
    while (fit->poses[fit->poses.size() - 1].cost > limit) fit->poses.pop_back();
  }
  if (fit->poses.empty()) return std::nullopt;
  return fit;
}

}  // namespace tagcal
