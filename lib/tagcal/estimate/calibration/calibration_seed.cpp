#include "tagcal/estimate/calibration/calibration_seed.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/calibration/projective_lmeds.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/solvers/n_point.hpp"
#include "tagcal/solvers/numeric/point_spread.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMaxSearchViews = 8;  // that the focal length is searched on,
constexpr std::size_t kEnoughPoints = 36;   // of each; a closed form needs no more

// The lens with what the model holds at its place.
Lens as_held(const Model& model, const ImageSize& size, const Lens& lens) {
  if (model.lens_type() == LensType::parallel) return lens;
  return model.lens(model.free_values(lens), size).value_or(lens);
}

// The model's lens without distortion, the principal point at the image centre, but for what the
// model holds elsewhere.
Lens plain_lens(const Model& model, const ImageSize& size, double focal) {
  const Vector2d c = image_centre(size);
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const Lens plain = fisheye ? Lens(Fisheye({focal, focal, c.x(), c.y()}))
                             : Lens(pinhole(focal, focal, c.x(), c.y()));
  return model.held().empty() ? plain : as_held(model, size, plain);
}

bool is_kind(const Lens& lens, const Model& model) {
  return model.lens_type() == LensType::fisheye ? std::holds_alternative<Fisheye>(lens)
                                                : std::holds_alternative<Perspective>(lens);
}

// The start that was given, if there is one for the model.
std::optional<Lens> known_lens(const Model& model, const ImageSize& size,
                               const StartOptions& options) {
  if (options.lens && is_kind(*options.lens, model)) return as_held(model, size, *options.lens);
  if (options.focal_px > 0) return plain_lens(model, size, options.focal_px);
  return std::nullopt;
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
                                  std::vector<std::uint8_t>& inlier, bool keep_all = false) {
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
  if (!consensus && !keep_all) return std::nullopt;
  SeedView seed;
  seed.index = index;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (consensus && !consensus->inlier[i]) continue;
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

// The pose of a set of points by the solver that fits its shape; no value for a line, or where
// there are too few points (four in a plane, six in space).
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

// Whether a model's distortion can bend straight lines outwards as an equidistant fisheye does.
bool has_distortion(const Model& model) {
  return std::ranges::any_of(
      model.free(), [](const FreeParameter& free) { return free.lens_parameters.front() == kK1; });
}

// The lens without coefficients that fits the views best, over a ladder of focal lengths. Poses
// under a strong barrel distortion fit a pinhole of a much longer focal length, and a solver that
// starts there stays there: so models with distortion are also tried as an equidistant fisheye.
Lens search_lens(const Model& model, const ImageSize& size, const std::vector<SeedView>& seeds,
                 double nominal) {
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const double extent = std::max(size.width, size.height);
  const Model& equidistant = model.sibling("fisheye4");
  std::vector<Lens> candidates;
  for (double f = 0.15 * extent; f < (fisheye ? 3 : 15) * extent; f *= 1.3)
    candidates.push_back(plain_lens(model, size, f));
  if (!fisheye) {
    const auto f = closed_form_focal(seeds, plain_lens(model, size, nominal), nominal);
    if (f && *f > 0.05 * extent && *f < 1000 * extent)
      candidates.push_back(plain_lens(model, size, *f));
    for (double g = 0.15 * extent; has_distortion(model) && g < 3 * extent; g *= 1.3)
      candidates.push_back(plain_lens(equidistant, size, g));
  }
  Lens best = plain_lens(model, size, nominal);
  double best_misfit = std::numeric_limits<double>::infinity();
  for (const Lens& lens : candidates) {
    const double misfit = misfit_px(seeds, lens, extent);
    if (misfit < best_misfit) std::tie(best, best_misfit) = std::pair(lens, misfit);
  }
  return best;
}

// The radial coefficients k1, k2, k3, as far as the model has them free, of a perspective lens with
// the views' poses and the focal length and centre of `plain`, by linear least squares (Zhang 2000,
// section 3.3).
Lens with_radial_distortion(const Model& model, const Lens& plain,
                            const std::vector<SeedView>& seeds,
                            const std::vector<std::optional<Pose>>& poses) {
  const auto p = parameters(plain);
  Perspective::Parameters result = {p[kFx], p[kFy], p[kCx], p[kCy]};
  for (const auto& [k, value] : model.held()) result[static_cast<std::size_t>(k)] = value;
  const std::vector<int> radial = {kK1, kK2, kK3};
  const Vector3d held(result[kK1], result[kK2], result[kK3]);
  std::vector<int> free;
  std::vector<Eigen::Index> order;  // of the free ones among the radial
  for (std::size_t i = 0; i < radial.size(); ++i) {
    for (const FreeParameter& parameter : model.free()) {
      if (parameter.lens_parameters.front() != radial[i]) continue;
      free.push_back(radial[i]);
      order.push_back(static_cast<Eigen::Index>(i));
    }
  }
  const auto n = static_cast<Eigen::Index>(free.size());
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
    result[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])] = k[i];
  const Perspective bent(result);
  // A polynomial that folds among the points is no start for them.
  for (const SeedView& seed : seeds)
    for (const Correspondence& c : seed.problem.correspondences)
      if (poses[seed.index] && !bent.in_domain(*poses[seed.index] * c.point))
        return plain_perspective;
  return bent;
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
                                           const StartOptions& options) {
  const bool fisheye = model.lens_type() == LensType::fisheye;
  const double nominal = std::max(size.width, size.height) * (fisheye ? 0.4 : 1.0);
  const std::optional<Lens> known = known_lens(model, size, options);
  const Lens nominal_lens = known ? *known : plain_lens(model, size, nominal);
  CalibrationStart start;
  start.camera_from_world.resize(views.size());
  start.inlier.resize(views.size());
  std::vector<std::optional<SeedView>> found(views.size());
  parallel_for(views.size(), options.num_threads, [&](std::size_t i) {
    found[i] = find_seed(views[i], i, nominal_lens, start.inlier[i], options.keep_all);
  });
  std::vector<SeedView> seeds;
  for (std::optional<SeedView>& seed : found)
    if (seed) seeds.push_back(std::move(*seed));
  if (seeds.empty()) return std::nullopt;
  const Lens lens = known ? *known : search_lens(model, size, largest(seeds), nominal);
  parallel_for(seeds.size(), options.num_threads, [&](std::size_t i) {
    const std::optional<RefinedPose> pose = seed_pose(seeds[i], lens, 4);
    if (pose) start.camera_from_world[seeds[i].index] = pose->camera_from_target;
  });
  const bool any = std::any_of(start.camera_from_world.begin(), start.camera_from_world.end(),
                               [](const std::optional<Pose>& pose) { return pose.has_value(); });
  if (!any) return std::nullopt;
  const bool is_bent = !fisheye && std::holds_alternative<Fisheye>(lens);
  start.free_values = model.free_values(
      is_bent ? with_radial_distortion(model, lens, seeds, start.camera_from_world) : lens);
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

}  // namespace tagcal::internal
