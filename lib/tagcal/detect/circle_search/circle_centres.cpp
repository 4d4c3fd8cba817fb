#include "tagcal/detect/circle_search/circle_centres.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/circle_search/circle_fit.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRounds = 2;  // under the lens: the second one starts from centres without its bias

// The image of the board about a centre: a homography of the nearest centres to rays of a lens, or
// to pixels without one.
class PlaneImage {
 public:
  static std::optional<PlaneImage> about(const CircleCentre& centre, const CircleCentres& all,
                                         const Lens* lens) {
    std::vector<const CircleCentre*> nearest;
    for (const auto& [id, other] : all) nearest.push_back(&other);
    const auto distance = [&](const CircleCentre* other) {
      return (other->on_board - centre.on_board).squaredNorm();
    };
    std::ranges::stable_sort(nearest, {}, distance);
    if (nearest.size() > policy::kCircleNeighbours) nearest.resize(policy::kCircleNeighbours);
    PlaneImage image(lens, centre);
    for (const CircleCentre* other : nearest)
      image.side_px_ = std::max(image.side_px_, (other->at - centre.at).norm());
    std::vector<Vector2d> points;
    std::vector<Vector3d> rays;
    for (const CircleCentre* other : nearest) {
      const auto ray = image.ray(other->at);
      if (!ray) continue;
      points.emplace_back(other->on_board - centre.on_board);
      rays.push_back(*ray);
    }
    if (points.size() < 4) return std::nullopt;
    const auto h = homography(points, rays);
    if (!h) return std::nullopt;
    image.to_rays_ = *h;
    return image;
  }

  // By differences over the disc's size, which have the terms of fourth order.
  std::optional<LocalMap> local_map() const {
    constexpr double kStep = 1.0 / 4;  // numeric: the radius of a usual disc
    const Vector2d x(kStep, 0), y(0, kStep);
    const Vector2d places[] = {{0, 0}, x, -x, y, -y, x + y, -x - y, x - y, y - x};
    std::array<Vector2d, 9> at;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const auto there = pixel(places[i]);
      if (!there || !there->allFinite()) return std::nullopt;
      at[i] = *there;
    }
    LocalMap map;
    map.centre = at[0];
    map.first << (at[1] - at[2]) / (2 * kStep), (at[3] - at[4]) / (2 * kStep);
    constexpr double kSquare = 2 * kStep * kStep;
    map.second << (at[1] + at[2] - 2 * at[0]) / kSquare,
        (at[5] + at[6] - at[7] - at[8]) / (2 * kSquare), (at[3] + at[4] - 2 * at[0]) / kSquare;
    if (!(std::abs(map.first.determinant()) > 1)) return std::nullopt;  // numeric: px^2, no area
    return map;
  }

 private:
  PlaneImage(const Lens* lens, const CircleCentre& centre) : lens_(lens), origin_(centre.at) {}

  std::optional<Vector3d> ray(const Vector2d& at) const {
    if (!lens_) return Vector3d(((at - origin_) / side_px_).homogeneous());
    const auto ray = ray_in_camera(*lens_, at);
    if (!ray) return std::nullopt;
    return ray->direction;
  }

  std::optional<Vector2d> pixel(const Vector2d& x) const {
    const Vector3d ray = to_rays_ * x.homogeneous();
    if (lens_) return project(*lens_, ray);
    return origin_ + side_px_ * ray.hnormalized();
  }

  const Lens* lens_;
  Vector2d origin_;
  double side_px_ = 1;  // to the farthest neighbour: rays without a lens are 45 degrees wide
  Matrix3d to_rays_ = Matrix3d::Identity();
};

// Standard deviation that the curvature of an unknown lens gives to a centre, px: half the radius
// squared, times half of the sum of two curvatures.
double lens_sd_px(const LocalMap& map, double radius, const ImageSize& size) {
  const double side = std::max({static_cast<double>(size.width), static_cast<double>(size.height),
                                policy::kTagSmallestPicturePx});
  const double square_px2 = radius * radius * map.first.squaredNorm() / 2;
  return square_px2 / 4 * policy::kTagBendSd / side;
}

// One round: each centre is fitted under the images of its neighbours of the last round.
int fit_round(const ImageView8& image, const Lens* lens, bool is_lens_known,
              CircleCentres& centres) {
  const CircleCentres before = centres;
  int count = 0;
  for (auto& [id, centre] : centres) {
    const auto plane = PlaneImage::about(before.at(id), before, lens);
    const auto map = plane ? plane->local_map() : std::nullopt;
    const auto fit = map ? fit_circle(image, *map) : std::nullopt;
    centre.covariance_px2.setZero();
    if (!fit) continue;
    centre.at = fit->centre;
    centre.covariance_px2 = fit->covariance_px2;
    if (!is_lens_known)
      centre.covariance_px2.diagonal().array() +=
          std::pow(lens_sd_px(*map, fit->radius, image.size()), 2);
    ++count;
  }
  return count;
}

std::optional<PanelLens> lens_of(const CircleCentres& centres, const ImageSize& size,
                                 const std::optional<PanelLens>& start) {
  std::vector<PanelCorner> corners;
  for (const auto& [id, centre] : centres)
    if (const double sd = std::sqrt(centre.covariance_px2.trace() / 2); sd > 0)
      corners.push_back({centre.on_board, centre.at, sd});
  return lens_of_panel(corners, size, start ? &*start : nullptr);
}

}  // namespace

CircleCentres centres_on_board(const CircleGrid& grid) {
  CircleCentres centres;
  for (const TargetPoint& point : target_points({grid, {}}))
    centres[point.id.tag_id].on_board = point.position.head<2>() / centre_distance(grid);
  return centres;
}

int fit_centres(const ImageView8& image, const Camera* camera, CircleCentres& centres) {
  const bool is_known = camera && !std::holds_alternative<Parallel>(camera->lens);
  const Lens* const lens = is_known ? &camera->lens : nullptr;
  int count = fit_round(image, lens, camera != nullptr, centres);
  std::optional<PanelLens> panel;
  for (int round = 0; round < kRounds; ++round) {
    if (!camera) panel = lens_of(centres, image.size(), panel);
    if (!camera && !panel) return count;
    count = fit_round(image, panel ? &panel->camera.lens : lens, true, centres);
  }
  return count;
}

}  // namespace tagcal::internal
