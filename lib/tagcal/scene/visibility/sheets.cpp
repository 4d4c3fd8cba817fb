#include "tagcal/scene/visibility/sheets.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;

// A point lies in a plane below this distance (metres per metre of the sheet's size).
constexpr double kFlat = 1e-9;

Vector3d area_vector(const std::vector<Vector3d>& corners) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i)
    sum += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  return sum / 2;
}

double extent(const Sheet& sheet) {
  double largest = 0;
  for (const Vector3d& corner : sheet.corners)
    largest = std::max(largest, (corner - sheet.corners.front()).norm());
  return largest;
}

Vector3d middle(const Sheet& sheet) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& corner : sheet.corners) sum += corner;
  return sum / static_cast<double>(sheet.corners.size());
}

double distance(const Sheet& sheet, const Eye& eye) {
  return eye.w == 0 ? -eye.position.dot(middle(sheet)) : eye.towards_from(middle(sheet)).norm();
}

// The sides of the plane of `other` on which `sheet` has corners: the eye's side, the far side.
struct Sides {
  bool eye_side = false;
  bool far_side = false;
};

Sides sides(const Sheet& sheet, const Sheet& other, const Eye& eye) {
  const double eye_height = other.normal.dot(eye.towards_from(other.corners.front()));
  const double sign = eye_height < 0 ? -1 : 1;
  const double tolerance = kFlat * (extent(sheet) + extent(other));
  Sides result;
  for (const Vector3d& corner : sheet.corners) {
    const double height = sign * other.normal.dot(corner - other.corners.front());
    if (height > tolerance) result.eye_side = true;
    if (height < -tolerance) result.far_side = true;
  }
  return result;
}

bool paper(const Sheet& sheet) { return sheet.panel.has_value(); }

// Returns true if `behind` must be painted before `front`.
bool goes_before(const Sheet& behind, const Sheet& front, const Eye& eye) {
  const Sides b = sides(behind, front, eye);
  const Sides f = sides(front, behind, eye);
  // Both are in one plane: paper lies on top of an occluder (a desk); else the given order stays.
  if (!b.eye_side && !b.far_side) return !paper(behind) && paper(front);
  const bool is_behind = !b.eye_side || !f.far_side;
  const bool is_before = !b.far_side || !f.eye_side;
  if (is_behind && is_before) return false;  // they do not overlap
  if (is_behind || is_before) return is_behind;
  return distance(behind, eye) > distance(front, eye);
}

// The distance to the sheet along a ray, in lengths of its direction.
std::optional<double> crossing(const Sheet& sheet, const Ray& ray) {
  const double climb = sheet.normal.dot(ray.direction);
  const double height = sheet.normal.dot(sheet.corners.front() - ray.origin);
  if (std::abs(height) <= kFlat * extent(sheet) || climb == 0) return std::nullopt;
  const double at = height / climb;
  if (!(at > 0)) return std::nullopt;
  const Vector3d hit = ray.origin + at * ray.direction;
  for (std::size_t i = 0; i < sheet.corners.size(); ++i) {
    const Vector3d& a = sheet.corners[i];
    const Vector3d& b = sheet.corners[(i + 1) % sheet.corners.size()];
    if (sheet.normal.dot((b - a).cross(hit - a)) < 0) return std::nullopt;
  }
  return at;
}

Sheet paper_sheet(const PlacedBoard& placed, std::size_t board, const BoardPanel& panel) {
  Sheet sheet;
  for (const Vector3d& corner : panel.paper)
    sheet.corners.push_back(placed.world_from_board * corner);
  sheet.normal = area_vector(sheet.corners).normalized();
  sheet.board = board;
  sheet.panel = panel;
  return sheet;
}

Sheet occluder_sheet(const Occluder& occluder, std::size_t index) {
  const Vector3d area = area_vector(occluder.corners);
  if (occluder.corners.size() < 3 || !(area.norm() > 0))
    throw Error(fmt::format("scene: occluders[{}].corners: must span an area", index));
  Sheet sheet;
  sheet.corners = occluder.corners;
  sheet.normal = area.normalized();
  sheet.occluder = index;
  return sheet;
}

}  // namespace

Eye eye(const Lens& lens, const Pose& camera_from_world) {
  const Pose world_from_camera = camera_from_world.inverse();
  if (const auto* parallel = std::get_if<Parallel>(&lens))
    return {world_from_camera.rotation() * -parallel->ray_in_camera({0, 0})->direction, 0};
  return {world_from_camera.translation(), 1};
}

std::vector<Sheet> sheets(const Scene& scene) {
  std::vector<Sheet> result;
  for (std::size_t i = 0; i < scene.boards.size(); ++i)
    for (const BoardPanel& panel : board_panels(scene.boards[i].board, scene.paper_margin_m))
      result.push_back(paper_sheet(scene.boards[i], i, panel));
  for (std::size_t i = 0; i < scene.occluders.size(); ++i)
    result.push_back(occluder_sheet(scene.occluders[i], i));
  return result;
}

bool faces(const Sheet& sheet, const Eye& eye) {
  return sheet.normal.dot(eye.towards_from(sheet.corners.front())) > 0;
}

std::optional<Hit> nearest_hit(const std::vector<Sheet>& sheets, const Ray& ray) {
  std::optional<Hit> nearest;
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    const std::optional<double> at = crossing(sheets[i], ray);
    if (at && (!nearest || *at < nearest->distance))
      nearest = Hit{i, *at, ray.origin + *at * ray.direction};
  }
  return nearest;
}

bool hides(const Sheet& sheet, const Eye& eye, const Vector3d& x) {
  const std::optional<double> at = crossing(sheet, {x, eye.towards_from(x)});
  return at && (eye.w == 0 || *at < 1);
}

std::vector<std::size_t> painting_order(const std::vector<Sheet>& sheets, const Eye& eye) {
  std::vector<std::size_t> left(sheets.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  std::ranges::stable_sort(left, [&](std::size_t a, std::size_t b) {
    return distance(sheets[a], eye) > distance(sheets[b], eye);
  });
  std::vector<std::size_t> order;
  while (!left.empty()) {
    // The farthest sheet that no remaining one must precede; in a cycle, the farthest.
    const auto free = [&](std::size_t candidate) {
      return std::ranges::none_of(left, [&](std::size_t other) {
        return other != candidate && goes_before(sheets[other], sheets[candidate], eye);
      });
    };
    auto next = std::ranges::find_if(left, free);
    if (next == left.end()) next = left.begin();
    order.push_back(*next);
    left.erase(next);
  }
  return order;
}

}  // namespace tagcal::internal
