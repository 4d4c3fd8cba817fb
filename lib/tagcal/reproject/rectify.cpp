#include "tagcal/reproject/rectify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/reproject/policy/policy.hpp"
#include "tagcal/reproject/rows/outline.hpp"
#include "tagcal/reproject/rows/pinhole_pair.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

PairOrientation orientation_of(const KnownRig::Member& first, const KnownRig::Member& second) {
  const Pose second_from_first = second.camera_from_rig * first.camera_from_rig.inverse();
  const Quaterniond half = exp_rotation(-0.5 * log_rotation(second_from_first.rotation()));
  const Vector3d baseline = half * second_from_first.translation();
  if (!(baseline.norm() > policy::kLeastBaseline))
    throw Error(fmt::format("rectify: {} and {} are at one place: there is no baseline", first.name,
                            second.name));
  PairOrientation orientation;
  const int axis = std::abs(baseline.x()) > std::abs(baseline.y()) ? 0 : 1;
  orientation.is_vertical = axis == 1;
  const Vector3d along = Vector3d::Unit(axis) * (baseline[axis] > 0 ? 1 : -1);
  const Quaterniond turn = rotation_between(baseline, along);
  orientation.rectified_from_camera = {turn * half.inverse(), turn * half};
  orientation.translation_m =
      (orientation.rectified_from_camera[1] * second_from_first.translation())[axis];
  return orientation;
}

void check_directions(const std::array<const KnownRig::Member*, 2>& members,
                      const PairOrientation& orientation) {
  for (int k = 0; k < 2; ++k) {
    const Vector3d axis = orientation.rectified_from_camera[k] * Vector3d::UnitZ();
    const double turn = std::atan2(axis.head<2>().norm(), axis.z());
    if (turn > policy::kMostRectifiedTurn)
      throw Error(fmt::format(
          "rectify: {} looks {:.0f} degrees away from the direction of the rectified pictures, "
          "{:.0f} "
          "at most: {} and {} look at each other, in different directions, or along their baseline",
          members[k]->name, degrees(turn), degrees(policy::kMostRectifiedTurn), members[0]->name,
          members[1]->name));
  }
}

// Angles of the rays of a camera before both rectified cameras: (along, about) the baseline.
struct AnglesOfView {
  Vector2d least = Vector2d::Constant(std::numeric_limits<double>::max());
  Vector2d most = -least;
};

AnglesOfView angles_of(const Camera& camera, const Quaterniond& rectified_from_camera,
                       bool is_vertical) {
  AnglesOfView view;
  std::vector<Vector3d> rays = outline_rays(camera);
  const std::vector<Vector3d> grid = grid_rays(camera);
  rays.insert(rays.end(), grid.begin(), grid.end());
  for (const Vector3d& seen : rays) {
    Vector3d ray = rectified_from_camera * seen;
    if (is_vertical) std::swap(ray.x(), ray.y());
    const Vector2d angles = transverse_angles(ray);
    if (!(ray.z() > 0) || std::abs(angles.x()) > policy::kWidestAngle) continue;
    view.least = view.least.cwiseMin(angles);
    view.most = view.most.cwiseMax(angles);
  }
  return view;
}

Panorama panorama_of_pair(const std::array<const KnownRig::Member*, 2>& members,
                          const PairOrientation& orientation) {
  AnglesOfView common;
  common.least = {pi, -pi};
  common.most = {-pi, pi};
  double px_per_rad = 0;
  for (int k = 0; k < 2; ++k) {
    const AnglesOfView view = angles_of(
        members[k]->camera.camera, orientation.rectified_from_camera[k], orientation.is_vertical);
    common.least = {std::min(common.least.x(), view.least.x()),
                    std::max(common.least.y(), view.least.y())};
    common.most = {std::max(common.most.x(), view.most.x()),
                   std::min(common.most.y(), view.most.y())};
    px_per_rad += scale_on_axis(*members[k])[orientation.is_vertical ? 0 : 1] / 2;
  }
  const Vector2d extent = px_per_rad * (common.most - common.least);
  constexpr double kMostSide = 1e6;  // numeric: beyond any memory
  if (!(extent.minCoeff() > 1 && extent.maxCoeff() < kMostSide))
    throw Error(fmt::format("rectify: {} and {} have no common field of view", members[0]->name,
                            members[1]->name));
  Panorama panorama{PanoramaKind::transverse, px_per_rad, {}, {}};
  panorama.size = {static_cast<int>(std::ceil(extent.x())),
                   static_cast<int>(std::ceil(extent.y()))};
  panorama.centre = image_centre(panorama.size) - px_per_rad / 2 * (common.least + common.most);
  if (orientation.is_vertical) {
    panorama.kind = PanoramaKind::equirectangular;
    std::swap(panorama.size.width, panorama.size.height);
    panorama.centre.reverseInPlace();
  }
  return panorama;
}

// Where points of a row lie that camera k sees: the last place along the baseline for the first
// camera, and the first one for the second, towards which near points move. Relative to the place
// of infinitely far points.
class RowsOfView {
 public:
  RowsOfView(const KnownRig& rig, const RectifiedPair& pair, std::size_t k)
      : reprojection_(rectification(rig, pair, k)), axis_(pair.is_vertical ? 1 : 0) {
    const Target& target = reprojection_.target;
    if (const auto* camera = std::get_if<Camera>(&target))
      centre_ = parameters(camera->lens)[static_cast<std::size_t>(2 + axis_)];
    else
      centre_ = std::get<Panorama>(target).centre[axis_];
  }

  // The largest place times `sign` in row i of kViewSamples; no value in a row that is not seen.
  std::optional<double> extreme(int i, double sign) const {
    const ImageSize size = size_of(reprojection_.target);
    const Vector2d last(size.width - 1, size.height - 1);
    std::optional<double> most;
    for (int j = 0; j < policy::kViewSamples; ++j) {
      Vector2d at = Vector2d(j, i) / (policy::kViewSamples - 1);
      if (axis_ == 1) at.reverseInPlace();
      at = at.cwiseProduct(last);
      const auto pixel = source_pixel(reprojection_, at);
      if (!pixel || !contains(reprojection_.camera.image_size, *pixel)) continue;
      most = std::max(most.value_or(-1e300), sign * (at[axis_] - centre_));
    }
    return most;
  }

 private:
  Reprojection reprojection_;
  int axis_;
  double centre_ = 0;
};

bool has_common_view(const KnownRig& rig, const RectifiedPair& pair) {
  const RowsOfView first(rig, pair, 0), second(rig, pair, 1);
  const double sign = pair.translation_m < 0 ? 1 : -1;
  for (int i = 0; i < policy::kViewSamples; ++i) {
    const auto a = first.extreme(i, sign), b = second.extreme(i, -sign);
    if (a && b && *a + *b >= 0) return true;
  }
  return false;
}

void check_pair(const KnownRig& rig, std::size_t first, std::size_t second,
                const RectifyOptions& options) {
  if (options.alpha && !(*options.alpha >= 0 && *options.alpha <= 1))
    throw Error(fmt::format("rectify: alpha must be from 0 to 1, got {}", *options.alpha));
  if (options.alpha && options.longlat)
    throw Error("rectify: alpha is of pinholes, not of longlat");
  for (const std::size_t camera : {first, second}) {
    if (camera >= rig.cameras.size())
      throw Error(fmt::format("rectify: the rig has {} cameras, got the index {}",
                              rig.cameras.size(), camera));
    outline_rays(rig.cameras[camera].camera.camera);  // a central lens, whose picture has rays
  }
  if (first == second)
    throw Error(fmt::format("rectify: needs two cameras, got {} twice", rig.cameras[first].name));
}

}  // namespace

RectifiedPair rectify(const KnownRig& rig, std::size_t first, std::size_t second,
                      const RectifyOptions& options) {
  check_pair(rig, first, second, options);
  const std::array<const KnownRig::Member*, 2> members = {&rig.cameras[first],
                                                          &rig.cameras[second]};
  const PairOrientation orientation = orientation_of(*members[0], *members[1]);
  check_directions(members, orientation);
  RectifiedPair pair;
  pair.cameras = {first, second};
  pair.is_vertical = orientation.is_vertical;
  pair.translation_m = orientation.translation_m;
  for (int k = 0; k < 2; ++k)
    pair.camera_from_rectified[k] = {orientation.rectified_from_camera[k].inverse(),
                                     Vector3d::Zero()};
  if (options.longlat) {
    pair.targets.fill(panorama_of_pair(members, orientation));
  } else {
    const PinholePair pinholes =
        pinholes_of(members, orientation, options.zero_disparity, options.alpha);
    const double f = pinholes.focal_px;
    for (int k = 0; k < 2; ++k)
      pair.targets[k] = Camera{pinhole(f, f, pinholes.centre[k].x(), pinholes.centre[k].y()),
                               members[0]->camera.camera.image_size};
  }
  if (!has_common_view(rig, pair))
    throw Error(fmt::format("rectify: {} and {} have no common field of view", members[0]->name,
                            members[1]->name));
  return pair;
}

Reprojection rectification(const KnownRig& rig, const RectifiedPair& pair, std::size_t k) {
  return {rig.cameras[pair.cameras[k]].camera.camera, pair.targets[k],
          pair.camera_from_rectified[k]};
}

ProjectionMatrix projection_matrix(const RectifiedPair& pair, std::size_t k) {
  const auto p = parameters(std::get<Camera>(pair.targets[k]).lens);
  ProjectionMatrix matrix;
  matrix << p[0], 0, p[2], 0, 0, p[1], p[3], 0, 0, 0, 1, 0;
  if (k == 1) matrix(pair.is_vertical ? 1 : 0, 3) = p[0] * pair.translation_m;
  return matrix;
}

Matrix4 disparity_to_depth(const RectifiedPair& pair) {
  const auto a = parameters(std::get<Camera>(pair.targets[0]).lens);
  const auto b = parameters(std::get<Camera>(pair.targets[1]).lens);
  const std::size_t along = pair.is_vertical ? 3 : 2;
  Matrix4 q = Matrix4::Zero();
  q(0, 0) = q(1, 1) = 1;
  q(0, 3) = -a[2];
  q(1, 3) = -a[3];
  q(2, 3) = a[0];
  q(3, 2) = -1 / pair.translation_m;
  q(3, 3) = (a[along] - b[along]) / pair.translation_m;
  return q;
}

}  // namespace tagcal
