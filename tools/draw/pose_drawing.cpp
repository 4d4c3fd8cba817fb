#include "draw/pose_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "draw/canvas.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kEdgePieces = 64;  // distortion bends edges
constexpr double kFlat = 0.01;   // depth of a flat target at most, of its size

constexpr Rgb kWhite = {255, 255, 255};
constexpr Rgb kHalo = {0, 0, 0};
constexpr Rgb kOutline = {180, 180, 180};
constexpr Rgb kBox = {255, 176, 32};
constexpr Rgb kOtherBox = {214, 84, 214};
constexpr Rgb kObserved = {0, 214, 230};
constexpr Rgb kReprojected = {255, 64, 160};
constexpr Rgb kOutlier = {255, 32, 32};
constexpr std::array<Rgb, 3> kAxes = {{{240, 40, 40}, {40, 190, 70}, {50, 110, 255}}};
constexpr std::array kAxisNames = {"x", "y", "z"};

// The image of an edge, in several parts if some of it is outside of the lens' domain.
class Sight {
 public:
  Sight(const Camera& camera, const Pose& camera_from_target)
      : camera_(camera), camera_from_target_(camera_from_target) {}

  std::optional<Vector2d> pixel(const Vector3d& x_in_target) const {
    return project(camera_.lens, camera_from_target_ * x_in_target);
  }

  void add_edge(const Vector3d& a, const Vector3d& b, std::vector<Polyline>& lines) const {
    std::optional<double> seen, unseen;  // the share of the way to b, of the point before
    for (int i = 0; i <= kEdgePieces; ++i) {
      const double share = static_cast<double>(i) / kEdgePieces;
      const std::optional<Vector2d> p = at(a, b, share);
      if (p && !seen) lines.emplace_back();
      if (p && unseen) lines.back().push_back(*at(a, b, border(a, b, share, *unseen)));
      if (p) lines.back().push_back(*p);
      if (!p && seen) lines.back().push_back(*at(a, b, border(a, b, *seen, share)));
      (p ? seen : unseen) = share;
      (p ? unseen : seen).reset();
    }
  }

  Vector3d camera_in_target() const { return camera_from_target_.inverse().translation(); }

 private:
  std::optional<Vector2d> at(const Vector3d& a, const Vector3d& b, double share) const {
    return pixel((1 - share) * a + share * b);
  }

  // The last visible share between a visible and an invisible one, by bisection.
  double border(const Vector3d& a, const Vector3d& b, double seen, double unseen) const {
    for (int i = 0; i < 40; ++i) {
      const double middle = (seen + unseen) / 2;
      (at(a, b, middle) ? seen : unseen) = middle;
    }
    return seen;
  }

  const Camera& camera_;
  Pose camera_from_target_;
};

// Unit of the line widths. It grows with the image of the target, so that lines do not cover a
// small one; its upper bound grows with the picture.
double unit_px(const PoseDrawing& drawing) {
  const ImageSize& size = drawing.camera.image_size;
  Eigen::AlignedBox2d seen;
  for (const Correspondence& corner : drawing.corners) seen.extend(corner.pixel);
  const double picture = std::max(1.0, std::min(size.width, size.height) / 600.0);
  return std::clamp(seen.diagonal().norm() / 150, 0.5, picture);
}

// The box to draw: the target's own if it has depth; a flat one is raised by half its length
// towards the camera.
AlignedBox3d raised(const AlignedBox3d& target, const Vector3d& camera_in_target) {
  int axis = 0;
  const double depth = target.sizes().minCoeff(&axis);
  const double length = target.sizes().maxCoeff();
  AlignedBox3d box = target;
  if (depth > kFlat * length) return box;
  if (camera_in_target[axis] > target.center()[axis])
    box.max()[axis] = box.min()[axis] + length / 2;
  else
    box.min()[axis] = box.max()[axis] - length / 2;
  return box;
}

std::vector<Polyline> box_lines(const AlignedBox3d& box, const Sight& sight) {
  std::vector<Polyline> lines;
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) {
      if (corner >> axis & 1) continue;
      const auto type = [](int c) { return static_cast<AlignedBox3d::CornerType>(c); };
      sight.add_edge(box.corner(type(corner)), box.corner(type(corner | 1 << axis)), lines);
    }
  return lines;
}

Vector3d axis_end(const PoseDrawing& drawing, int axis) {
  return drawing.target.sizes().maxCoeff() / 2 * Vector3d::Unit(axis);
}

// Beside the axis' end, away from the target's middle.
std::optional<Label> axis_name(int axis, const Vector3d& end, const Vector3d& middle,
                               const Sight& sight, double unit) {
  const auto from = sight.pixel(middle);
  const auto to = sight.pixel(end);
  if (!from || !to) return std::nullopt;
  const Vector2d along = *to - *from;
  const Vector2d away = along.norm() > 1 ? along.normalized().eval() : Vector2d(1, -1);
  const double height = std::max(8.0, 12 * unit);
  return Label{kAxisNames[static_cast<std::size_t>(axis)], *to + 1.35 * height * away, height};
}

void append(std::vector<Polyline>& lines, const std::vector<Polyline>& more) {
  lines.insert(lines.end(), more.begin(), more.end());
}

// The box and the axes for one pose, with a dark outline that is visible on any picture.
void draw_frame(Canvas& canvas, const PoseDrawing& drawing, const Pose& pose, bool best) {
  const double unit = unit_px(drawing);
  const double width = unit * (best ? 2.2 : 1.2), dash = best ? 0 : 5 * unit;
  const Sight sight(drawing.camera, pose);
  const std::vector<Polyline> edges =
      box_lines(raised(drawing.target, sight.camera_in_target()), sight);
  std::vector<Polyline> all = edges;
  std::array<std::vector<Polyline>, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    sight.add_edge(Vector3d::Zero(), axis_end(drawing, static_cast<int>(i)), axes[i]);
    append(all, axes[i]);
  }
  canvas.draw(all, {kHalo, width + 2.4 * unit, best ? 0.55 : 0.3, dash});
  canvas.draw(edges, {best ? kBox : kOtherBox, width, 1, dash});
  for (std::size_t i = 0; i < 3; ++i)
    canvas.draw(axes[i], {kAxes[i], best ? 1.6 * width : width, 1, dash});
}

void draw_axis_names(Canvas& canvas, const PoseDrawing& drawing) {
  const double unit = unit_px(drawing);
  const Sight sight(drawing.camera, drawing.camera_from_target.front());
  for (std::size_t i = 0; i < 3; ++i) {
    const int axis = static_cast<int>(i);
    const auto name =
        axis_name(axis, axis_end(drawing, axis), drawing.target.center(), sight, unit);
    if (name) canvas.write(*name, kAxes[i]);
  }
}

void draw_corners(Canvas& canvas, const PoseDrawing& drawing) {
  const double unit = unit_px(drawing);
  const Sight sight(drawing.camera, drawing.camera_from_target.front());
  std::vector<Polyline> observed, reprojected, wrong, ties;
  for (std::size_t i = 0; i < drawing.corners.size(); ++i) {
    const Correspondence& corner = drawing.corners[i];
    const Vector2d& c = corner.pixel;
    const auto place = sight.pixel(corner.point);
    const double arm = 2.2 * unit;
    if (place)
      append(reprojected, {{*place - Vector2d(arm, 0), *place + Vector2d(arm, 0)},
                           {*place - Vector2d(0, arm), *place + Vector2d(0, arm)}});
    if (std::binary_search(drawing.outliers.begin(), drawing.outliers.end(), i)) {
      const double d = 5 * unit;
      append(wrong, {{c - Vector2d(d, d), c + Vector2d(d, d)},
                     {c + Vector2d(-d, d), c + Vector2d(d, -d)}});
      if (place) ties.push_back({c, *place});
    } else {
      observed.push_back(circle(c, 4 * unit));
    }
  }
  canvas.draw(observed, {kHalo, 2.6 * unit, 0.4, 0});
  canvas.draw(observed, {kObserved, 1.2 * unit, 1, 0});
  canvas.draw(reprojected, {kReprojected, 1.1 * unit, 1, 0});
  canvas.draw(ties, {kOutlier, 1.2 * unit, 1, 0});
  canvas.draw(wrong, {kHalo, 4.2 * unit, 0.5, 0});
  canvas.draw(wrong, {kOutlier, 2.2 * unit, 1, 0});
}

void draw_outlines(Canvas& canvas, const PoseDrawing& drawing) {
  const Sight sight(drawing.camera, drawing.camera_from_target.front());
  std::vector<Polyline> lines;
  for (const std::vector<Vector3d>& outline : drawing.outlines)
    for (std::size_t i = 0; i < outline.size(); ++i)
      sight.add_edge(outline[i], outline[(i + 1) % outline.size()], lines);
  canvas.draw(lines, {kOutline, 1.2 * unit_px(drawing), 1, 0});
}

}  // namespace

void set_target(const std::map<CornerId, Vector3d>& points, PoseDrawing& drawing) {
  std::map<int, std::vector<Vector3d>> outlines;
  for (const auto& [id, x] : points) {
    drawing.target.extend(x);
    outlines[id.tag_id].push_back(x);
  }
  for (const auto& [id, outline] : outlines)
    if (outline.size() >= 4) drawing.outlines.push_back(outline);  // not of points
}

std::vector<std::string> drawing_names(const std::vector<View>& views) {
  std::vector<std::string> names;
  std::set<std::string> used;
  for (const View& view : views) {
    std::filesystem::path image = view.image;
    std::string stem = is_picture_name(image) ? image.replace_extension().string() : view.image;
    std::ranges::replace_if(
        stem, [](char c) { return c == '/' || (c >= 0 && c < ' '); }, '_');
    std::string name = stem + "-pose.png";
    for (int i = 2; !used.insert(name).second; ++i) name = fmt::format("{}-{}-pose.png", stem, i);
    names.push_back(name);
  }
  return names;
}

ImageRgb draw_pose(const PoseDrawing& drawing, const Image8& picture) {
  Canvas canvas = picture.empty() ? Canvas(drawing.camera.image_size, kWhite) : Canvas(picture);
  if (picture.empty()) draw_outlines(canvas, drawing);
  for (std::size_t i = 0; i < drawing.camera_from_target.size(); ++i)
    draw_frame(canvas, drawing, drawing.camera_from_target[i], i == 0);
  draw_corners(canvas, drawing);
  draw_axis_names(canvas, drawing);
  return canvas.image();
}

}  // namespace tagcal::tools
