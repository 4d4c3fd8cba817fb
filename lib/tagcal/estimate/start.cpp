#include "tagcal/estimate/start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tagcal/estimate/closed_form.hpp"
#include "tagcal/estimate/robust.hpp"
#include "tagcal/parallel.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMaxSearchViews = 8;  // that the focal length is searched on,
constexpr std::size_t kEnoughPoints = 36;   // of each; a closed form needs no more

// The model's lens without distortion, the principal point at the image centre.
Lens plain_lens(const Model& model, const ImageSize& size, double focal) {
  const Vector2d c = image_centre(size);
  if (model.lens_type() == LensType::fisheye) return Fisheye({focal, focal, c.x(), c.y()});
  return pinhole(focal, focal, c.x(), c.y());
}

// The seed of a view as points and rays, and which of them agree.
struct SeedView {
  std::size_t index = 0;  // of the view
  ViewProblem problem;    // of the correspondences that agree
  std::vector<Vector3d> points;
};

std::vector<Vector3d> rays_of(const std::vector<Correspondence>& correspondences,
                              const Lens& lens) {
  std::vector<Vector3d> rays;
  for (const Correspondence& c : correspondences) {
    const std::optional<Ray> ray = ray_in_camera(lens, c.pixel);
    // A pixel beyond a fisheye's last angle is wrong for this focal length; any direction says so.
    rays.push_back(ray ? ray->direction : Vector3d(0, 0, -1));
  }
  return rays;
}

std::optional<SeedView> find_seed(const CalibrationView& view, std::size_t index, const Lens& lens,
                                  std::vector<std::uint8_t>& inlier) {
  std::vector<Correspondence> all;
  std::vector<Vector3d> points;
  for (const std::size_t i : view.seed) {
    all.push_back(view.problem.correspondences[i]);
    points.push_back(all.back().point);
  }
  inlier.assign(view.problem.correspondences.size(), 0);
  const PointSpread spread = spread_of(points);
  if (spread.shape == PointShape::point || spread.shape == PointShape::line) return std::nullopt;
  for (Vector3d& p : points) p = spread.in_plane(p);
  const auto consensus = find_consensus(points, spread.shape, rays_of(all, lens));
  if (!consensus) return std::nullopt;
  SeedView seed;
  seed.index = index;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!consensus->inlier[i]) continue;
    inlier[view.seed[i]] = 1;
    seed.problem.correspondences.push_back(all[i]);
    seed.points.push_back(all[i].point);
  }
  return seed;
}

// The same view by some of its points, spread over all.
SeedView thinned(const SeedView& seed) {
  const std::size_t stride = (seed.points.size() + kEnoughPoints - 1) / kEnoughPoints;
  SeedView thin;
  thin.index = seed.index;
  for (std::size_t i = 0; i < seed.points.size(); i += stride) {
    thin.problem.correspondences.push_back(seed.problem.correspondences[i]);
    thin.points.push_back(seed.points[i]);
  }
  return thin;
}

std::optional<Pose> closed_form_pose(const SeedView& seed, const Lens& lens) {
  const SeedView thin = thinned(seed);
  return pose_closed_form(thin.points, rays_of(thin.problem.correspondences, lens));
}

std::optional<RefinedPose> seed_pose(const SeedView& seed, const Lens& lens, int iterations) {
  const std::optional<Pose> pose = closed_form_pose(seed, lens);
  if (!pose) return std::nullopt;
  return refine_pose(seed.problem, lens, *pose, iterations);
}

// The sum over views of the root of the mean squared residual; a view without a pose counts as the
// worst that could be.
double misfit_px(const std::vector<SeedView>& seeds, const Lens& lens, double worst) {
  double sum = 0;
  for (const SeedView& seed : seeds) {
    const std::optional<RefinedPose> pose = seed_pose(seed, lens, 6);
    const double n = static_cast<double>(seed.points.size());
    sum += pose ? std::min(worst, std::sqrt(pose->cost / n)) : worst;
  }
  return sum;
}

// Zhang's closed form on the planar views, from rays of a lens of focal length `focal`.
std::optional<double> closed_form_focal(const std::vector<SeedView>& seeds, const Lens& lens,
                                        double focal) {
  std::vector<Matrix3d> homographies;
  for (const SeedView& seed : seeds) {
    const PointSpread spread = spread_of(seed.points);
    if (spread.shape != PointShape::plane) continue;
    std::vector<Vector2d> points;
    for (const Vector3d& p : seed.points) points.push_back(spread.in_plane(p).head<2>());
    const auto h = homography(points, rays_of(seed.problem.correspondences, lens));
    if (h) homographies.push_back(*h);
  }
  const std::optional<double> ratio = focal_ratio_from_homographies(homographies);
  if (!ratio) return std::nullopt;
  return focal * *ratio;
}

double search_focal(const Model& model, const ImageSize& size, const std::vector<SeedView>& seeds,
                    double nominal) {
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const double extent = std::max(size.width, size.height);
  std::vector<double> candidates;
  for (double f = 0.15 * extent; f < (fisheye ? 3 : 15) * extent; f *= 1.3) candidates.push_back(f);
  if (!fisheye) {
    const auto f = closed_form_focal(seeds, plain_lens(model, size, nominal), nominal);
    if (f && *f > 0.05 * extent && *f < 1000 * extent) candidates.push_back(*f);
  }
  double best = nominal;
  double best_misfit = std::numeric_limits<double>::infinity();
  for (const double f : candidates) {
    const double misfit = misfit_px(seeds, plain_lens(model, size, f), extent);
    if (misfit < best_misfit) std::tie(best, best_misfit) = std::pair(f, misfit);
  }
  return best;
}

std::vector<SeedView> largest(const std::vector<SeedView>& seeds) {
  std::vector<std::size_t> order(seeds.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return seeds[a].points.size() > seeds[b].points.size();
  });
  if (order.size() > kMaxSearchViews) order.resize(kMaxSearchViews);
  std::vector<SeedView> result;
  for (const std::size_t i : order) result.push_back(thinned(seeds[i]));
  return result;
}

}  // namespace

std::optional<CalibrationStart> find_start(const Model& model, const ImageSize& size,
                                           const std::vector<CalibrationView>& views,
                                           std::size_t num_threads) {
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const double nominal = std::max(size.width, size.height) * (fisheye ? 0.4 : 1.0);
  const Lens nominal_lens = plain_lens(model, size, nominal);
  CalibrationStart start;
  start.camera_from_world.resize(views.size());
  start.inlier.resize(views.size());
  std::vector<std::optional<SeedView>> found(views.size());
  parallel_for(views.size(), num_threads, [&](std::size_t i) {
    found[i] = find_seed(views[i], i, nominal_lens, start.inlier[i]);
  });
  std::vector<SeedView> seeds;
  for (std::optional<SeedView>& seed : found)
    if (seed) seeds.push_back(std::move(*seed));
  if (seeds.empty()) return std::nullopt;
  const double focal = search_focal(model, size, largest(seeds), nominal);
  const Lens lens = plain_lens(model, size, focal);
  parallel_for(seeds.size(), num_threads, [&](std::size_t i) {
    const std::optional<RefinedPose> pose = seed_pose(seeds[i], lens, 4);
    if (pose) start.camera_from_world[seeds[i].index] = pose->camera_from_target;
  });
  const bool any = std::any_of(start.camera_from_world.begin(), start.camera_from_world.end(),
                               [](const std::optional<Pose>& pose) { return pose.has_value(); });
  if (!any) return std::nullopt;
  start.free_values = model.free_values(lens);
  return start;
}

std::optional<Pose> consensus_pose(const CalibrationView& view, const Lens& lens) {
  std::vector<std::uint8_t> inlier;
  const std::optional<SeedView> seed = find_seed(view, 0, lens, inlier);
  if (!seed) return std::nullopt;
  const std::optional<RefinedPose> pose = seed_pose(*seed, lens, 30);
  if (!pose) return std::nullopt;
  return pose->camera_from_target;
}

}  // namespace tagcal
