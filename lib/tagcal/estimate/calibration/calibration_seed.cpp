#include "tagcal/estimate/calibration/calibration_seed.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/bundle/lens_prior.hpp"
#include "tagcal/estimate/calibration/projective_lmeds.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/solvers/n_point.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Limits of work of the search for a focal length: views, and points of each.
constexpr std::size_t kMaxSearchViews = 8;
constexpr std::size_t kEnoughPoints = 36;

// The lens with the model's held parameters.
Lens with_held(const Model& model, const ImageSize& size, const Lens& lens) {
  if (!model.kind().is_central) return lens;
  return model.lens(model.free_values(lens), size).value_or(lens);
}

// The model's lens without distortion, with the principal point at the image centre and the held
// parameters.
Lens plain_lens(const Model& model, const ImageSize& size, double focal) {
  const Lens plain = tagcal::plain_lens(model.kind(), focal, image_centre(size));
  return model.held().empty() ? plain : with_held(model, size, plain);
}

// The start that the user gives for this kind of lens.
std::optional<Lens> given_lens(const Model& model, const ImageSize& size,
                               const SeedOptions& options) {
  if (options.lens && &kind_of(*options.lens) == &model.kind())
    return with_held(model, size, *options.lens);
  if (options.focal_px > 0) return plain_lens(model, size, options.focal_px);
  return std::nullopt;
}

// The inliers of a view's largest board.
struct SeedView {
  std::size_t index = 0;  // of the view
  ViewProblem problem;

  std::size_t size() const { return problem.correspondences.size(); }
};

std::vector<Vector3d> points_of(std::span<const Correspondence> correspondences) {
  std::vector<Vector3d> points;
  points.reserve(correspondences.size());
  for (const Correspondence& c : correspondences) points.push_back(c.point);
  return points;
}

std::vector<Vector3d> rays_of(std::span<const Correspondence> correspondences, const Lens& lens) {
  std::vector<Vector3d> rays;
  for (const Correspondence& c : correspondences) {
    const std::optional<Ray> ray = ray_in_camera(lens, c.pixel);
    // A pixel beyond the largest angle is inconsistent with this focal length; the backward
    // direction makes it an outlier.
    rays.push_back(ray ? ray->direction : Vector3d(0, 0, -1));
  }
  return rays;
}

std::optional<SeedView> seed_inliers(const CalibrationView& view, std::size_t index,
                                     const Lens& lens, std::vector<std::uint8_t>& inlier,
                                     bool keep_all) {
  std::vector<Correspondence> all;
  for (const std::size_t i : view.seed) all.push_back(view.problem.correspondences[i]);
  std::vector<Vector3d> points = points_of(all);
  inlier.assign(view.problem.correspondences.size(), 0);
  const PointSpread spread = spread_of(points);
  if (spread.shape == PointShape::point || spread.shape == PointShape::line) return std::nullopt;
  for (Vector3d& p : points) p = spread.in_plane(p);
  auto kept = projective_lmeds(points, spread.shape, rays_of(all, lens));
  if (!kept && !keep_all) return std::nullopt;
  if (!kept) {
    kept.emplace(all.size());
    std::iota(kept->begin(), kept->end(), 0);
  }
  SeedView seed{index, {}};
  for (const std::size_t i : *kept) inlier[view.seed[i]] = 1;
  if (kept->size() == view.problem.correspondences.size() && std::ranges::is_sorted(*kept)) {
    seed.problem.correspondences = view.problem.correspondences;  // shares their memory
    return seed;
  }
  seed.problem.correspondences.reserve(kept->size());
  for (const std::size_t i : *kept) seed.problem.correspondences.push_back(all[i]);
  return seed;
}

// The view with at most kEnoughPoints points, evenly spread.
SeedView thinned(const SeedView& seed) {
  const std::size_t stride = (seed.size() + kEnoughPoints - 1) / kEnoughPoints;
  SeedView thin{seed.index, {}};
  for (std::size_t i = 0; i < seed.size(); i += stride)
    thin.problem.correspondences.push_back(seed.problem.correspondences[i]);
  return thin;
}

// The pose of points in a plane (at least four) or in space (at least six). No value for a line or
// too few points.
std::optional<Pose> pose_closed_form(std::span<const Vector3d> points,
                                     std::span<const Vector3d> rays) {
  const PointSpread spread = spread_of(points);
  if (spread.shape == PointShape::space) return pose_from_points_dlt(points, rays);
  if (spread.shape != PointShape::plane) return std::nullopt;
  std::vector<Vector2d> plane;
  for (const Vector3d& p : points) plane.push_back(spread.in_plane(p).head<2>());
  const std::optional<Matrix3d> h = homography(plane, rays);
  if (!h) return std::nullopt;
  return pose_from_homography(*h) * spread.plane_from_target_pose();
}

std::optional<Pose> closed_form_pose(const SeedView& seed, const Lens& lens) {
  const SeedView thin = thinned(seed);
  return pose_closed_form(points_of(thin.problem.correspondences),
                          rays_of(thin.problem.correspondences, lens));
}

std::optional<RefinedPose> seed_pose(const SeedView& seed, const Lens& lens, int iterations) {
  const std::optional<Pose> pose = closed_form_pose(seed, lens);
  if (!pose) return std::nullopt;
  return refine_view_pose(seed.problem, lens, *pose, iterations);
}

// Sum over the views of the RMS residual; `worst` for a view without a pose.
double sum_of_rms_px(const std::vector<SeedView>& seeds, const Lens& lens, double worst) {
  double sum = 0;
  for (const SeedView& seed : seeds) {
    const std::optional<RefinedPose> pose = seed_pose(seed, lens, 6);
    const double n = static_cast<double>(seed.size());
    sum += pose ? std::min(worst, std::sqrt(pose->cost / n)) : worst;
  }
  return sum;
}

// Focal length by Zhang's closed form from the planar views, whose rays are those of a lens of
// focal length `focal`.
std::optional<double> closed_form_focal(const std::vector<SeedView>& seeds, const Lens& lens,
                                        double focal) {
  std::vector<Matrix3d> homographies;
  for (const SeedView& seed : seeds) {
    const std::vector<Vector3d> on_target = points_of(seed.problem.correspondences);
    const PointSpread spread = spread_of(on_target);
    if (spread.shape != PointShape::plane) continue;
    std::vector<Vector2d> points;
    for (const Vector3d& p : on_target) points.push_back(spread.in_plane(p).head<2>());
    const auto h = homography(points, rays_of(seed.problem.correspondences, lens));
    if (h) homographies.push_back(*h);
  }
  const std::optional<double> ratio = focal_ratio_from_homographies(homographies);
  if (!ratio) return std::nullopt;
  return focal * *ratio;
}

bool has_radial_distortion(const Model& model) {
  return std::ranges::any_of(
      model.free(), [](const FreeParameter& free) { return free.lens_parameters.front() == kK1; });
}

// Focal lengths from 0.15 to `most` times the extent, each 1.3 times the one before.
std::vector<double> focal_grid(double extent, double most) {
  std::vector<double> grid;
  // numeric: tried values
  for (double f = 0.15 * extent; f < most * extent; f *= 1.3) grid.push_back(f);
  return grid;
}

// -2 log of the likelihood of the views times the lens' prior. The residuals are mostly of the
// distortion that is not in the lens yet, and are alike within a view: each view counts once.
double start_score(const Model& model, const ImageSize& size, const std::vector<SeedView>& seeds,
                   const Lens& lens) {
  const double worst = std::max(size.width, size.height);
  const double views = static_cast<double>(seeds.size());
  return 2 * views * std::log(sum_of_rms_px(seeds, lens, worst)) +
         lens_prior(model, model.free_values(lens), size).residuals.squaredNorm();
}

// The undistorted lens that is the most probable one. Views from the front hardly depend on the
// focal length, so the prior keeps it where the solver needs few steps. Models with radial
// distortion also try an equidistant fisheye: under strong barrel distortion a pinhole of a much
// longer focal length fits, and the solver does not leave that minimum.
Lens search_lens(const Model& model, const ImageSize& size, const std::vector<SeedView>& seeds,
                 double nominal) {
  const bool is_wide = model.kind().reaches_behind;
  const double extent = std::max(size.width, size.height);
  Lens best = plain_lens(model, size, nominal);
  double least = std::numeric_limits<double>::infinity();
  const auto try_focal = [&](const Model& tried, double f) {
    const Lens lens = plain_lens(tried, size, f);
    const double score = start_score(tried, size, seeds, lens);
    if (score < least) std::tie(best, least) = std::pair(lens, score);
  };
  for (const double f : focal_grid(extent, is_wide ? 3 : 15)) try_focal(model, f);
  if (is_wide) return best;
  const auto f = closed_form_focal(seeds, plain_lens(model, size, nominal), nominal);
  constexpr double kShortest = 0.05, kLongest = 1000;  // numeric: of a closed form that ends
  if (f && *f > kShortest * extent && *f < kLongest * extent) try_focal(model, *f);
  if (has_radial_distortion(model))
    for (const double g : focal_grid(extent, 3))
      try_focal(model.sibling(kind_of<Fisheye>(), ModelRole::largest), g);
  return best;
}

constexpr std::array<std::size_t, 3> kRadial = {kK1, kK2, kK3};

// The coefficients that a model frees, by their indices in kRadial.
std::vector<Eigen::Index> free_radial(const Model& model) {
  std::vector<Eigen::Index> order;
  for (std::size_t i = 0; i < kRadial.size(); ++i)
    for (const FreeParameter& parameter : model.free())
      if (parameter.lens_parameters.front() == static_cast<int>(kRadial[i]))
        order.push_back(static_cast<Eigen::Index>(i));
  return order;
}

// A perspective lens with the focal length and centre of `plain`, whose free coefficients of k1,
// k2, k3 come from linear least squares under the given poses (Zhang 2000, section 3.3).
Lens with_radial_distortion(const Model& model, const Lens& plain,
                            const std::vector<SeedView>& seeds,
                            const std::vector<std::optional<Pose>>& poses) {
  const auto p = parameters(plain);
  Perspective::Parameters result = {p[kFx], p[kFy], p[kCx], p[kCy]};
  for (const auto& [k, value] : model.held()) result[static_cast<std::size_t>(k)] = value;
  const Vector3d held(result[kK1], result[kK2], result[kK3]);
  const std::vector<Eigen::Index> order = free_radial(model);
  const auto n = static_cast<Eigen::Index>(order.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (const SeedView& seed : seeds) {
    if (!poses[seed.index]) continue;
    for (const Correspondence& c : seed.problem.correspondences) {
      const Vector3d x = *poses[seed.index] * c.point;
      if (!(x.z() > 0)) continue;
      const Vector2d at = x.hnormalized();
      const Vector2d px(p[kFx] * at.x(), p[kFy] * at.y());
      const double s = at.squaredNorm();
      const Vector3d all(s, s * s, s * s * s);
      const Eigen::VectorXd powers = all(order);
      information += px.squaredNorm() * powers * powers.transpose();
      gradient += px.dot(c.pixel - Vector2d(p[kCx], p[kCy]) - (1 + held.dot(all)) * px) * powers;
    }
  }
  const Perspective plain_perspective(result);
  const Eigen::VectorXd k = information.ldlt().solve(gradient);
  for (Eigen::Index i = 0; i < n && k.allFinite(); ++i)
    result[kRadial[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]] = k[i];
  const Perspective distorted(result);
  // A polynomial that folds within the points cannot be a start.
  for (const SeedView& seed : seeds)
    for (const Correspondence& c : seed.problem.correspondences)
      if (poses[seed.index] && !distorted.in_domain(*poses[seed.index] * c.point))
        return plain_perspective;
  return distorted;
}

std::vector<SeedView> largest_views(const std::vector<SeedView>& seeds) {
  std::vector<std::size_t> order(seeds.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return seeds[a].size() > seeds[b].size(); });
  if (order.size() > kMaxSearchViews) order.resize(kMaxSearchViews);
  std::vector<SeedView> result;
  for (const std::size_t i : order) result.push_back(thinned(seeds[i]));
  return result;
}

}  // namespace

std::optional<CalibrationSeed> calibration_seed(const Model& model, const ImageSize& size,
                                                const std::vector<CalibrationView>& views,
                                                const SeedOptions& options) {
  const double nominal =
      std::max(size.width, size.height) *
      (model.kind().reaches_behind ? policy::kNominalFisheyeFocal : policy::kNominalFocal);
  const std::optional<Lens> given = given_lens(model, size, options);
  const Lens nominal_lens = given ? *given : plain_lens(model, size, nominal);
  CalibrationSeed start;
  start.camera_from_world.resize(views.size());
  start.inlier.resize(views.size());
  std::vector<std::optional<SeedView>> found(views.size());
  const int num_threads = threads_for_short_calls(views.size(), options.num_threads);
  parallel_for(views.size(), num_threads, [&](std::size_t i) {
    found[i] = seed_inliers(views[i], i, nominal_lens, start.inlier[i], options.keep_all);
  });
  std::vector<SeedView> seeds;
  for (std::optional<SeedView>& seed : found)
    if (seed) seeds.push_back(std::move(*seed));
  if (seeds.empty()) return std::nullopt;
  const Lens lens = given ? *given : search_lens(model, size, largest_views(seeds), nominal);
  parallel_for(seeds.size(), num_threads, [&](std::size_t i) {
    const std::optional<RefinedPose> pose = seed_pose(seeds[i], lens, 4);
    if (pose) start.camera_from_world[seeds[i].index] = pose->camera_from_target;
  });
  const bool any = std::any_of(start.camera_from_world.begin(), start.camera_from_world.end(),
                               [](const std::optional<Pose>& pose) { return pose.has_value(); });
  if (!any) return std::nullopt;
  start.free_values =
      model.free_values(&kind_of(lens) == &model.kind()
                            ? lens
                            : with_radial_distortion(model, lens, seeds, start.camera_from_world));
  return start;
}

}  // namespace tagcal::internal
