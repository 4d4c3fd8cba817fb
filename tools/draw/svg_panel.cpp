#include "draw/svg_panel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kEdgePieces = 16;  // distortion bends edges

std::string named(std::string_view id) { return id.empty() ? "" : fmt::format("id=\"{}\" ", id); }

}  // namespace

std::string grey(double level) {
  return fmt::format("rgb({0},{0},{0})", std::lround(255 * std::clamp(level, 0.0, 1.0)));
}

std::string svg_points(const std::vector<Vector2d>& points) {
  std::string text;
  for (const Vector2d& p : points) text += fmt::format("{:.2f},{:.2f} ", p.x(), p.y());
  return text;
}

std::string svg_polygon(std::string_view id, const std::vector<Vector2d>& points,
                        std::string_view style) {
  return fmt::format("<polygon {}points=\"{}\" {}/>\n", named(id), svg_points(points), style);
}

std::string svg_line(std::string_view id, const Vector2d& from, const Vector2d& to,
                     std::string_view style) {
  return fmt::format("<line {}x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" {}/>\n",
                     named(id), from.x(), from.y(), to.x(), to.y(), style);
}

std::string svg_circle(std::string_view id, const Vector2d& centre, double radius,
                       std::string_view style) {
  return fmt::format("<circle {}cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" {}/>\n", named(id), centre.x(),
                     centre.y(), radius, style);
}

std::string SvgPanel::things(const Scene& scene) const {
  std::string svg, edges;
  const Shadows shadows(scene, camera_.lens, camera_from_world_);
  for (std::size_t i = 0; i < shadows.sheets().size(); ++i) {
    const Sheet& sheet = shadows.sheets()[i];
    const double level = sheet.panel ? scene.paper_level : scene.occluders[sheet.occluder].level;
    svg += visible_area(sheet.corners, shadows, i, grey(level));
    edges += visible_edges(sheet.corners, shadows, i);
    if (!sheet.panel || !shadows.faces(i)) continue;
    const Pose camera_from_board = camera_from_world_ * scene.boards[sheet.board].world_from_board;
    for (InkCell& ink : drawn_print(scene.boards[sheet.board].board, *sheet.panel)) {
      for (Vector3d& x : ink) x = camera_from_board * x;
      svg += visible_area(ink, shadows, i, kInk);
    }
  }
  svg += edges;
  for (const PlacedBoard& placed : scene.boards) {
    if (point_kind(placed.board) != PointKind::measured) continue;  // the others have ink
    for (const TargetPoint& point : target_points(placed.board))
      if (const auto at = pixel(placed.world_from_board * point.position))
        svg += svg_circle("", *at, 1.5, fmt::format("fill=\"{}\"", kInk));
  }
  return svg;
}

std::string SvgPanel::outline(const std::vector<Vector3d>& corners, std::string_view style) const {
  std::string svg;
  for (const auto& part : clip_to_domain(corners, camera_.lens, 1e-6)) {
    std::vector<Vector2d> pixels;
    for (std::size_t i = 0; i < part.size(); ++i)
      append(part[i], part[(i + 1) % part.size()], kEdgePieces - 1, pixels);
    svg += svg_polygon("", pixels, style);
  }
  return svg;
}

std::string SvgPanel::segment(const Vector3d& a, const Vector3d& b) const {
  std::vector<Vector2d> pixels;
  append(a, b, kEdgePieces, pixels);
  return fmt::format(
      "<polyline points=\"{}\" fill=\"none\" stroke=\"#999\" stroke-width=\"0.5\"/>\n",
      svg_points(pixels));
}

// The thin stroke closes the gaps that a viewer leaves between neighbouring polygons.
std::string SvgPanel::visible_area(const std::vector<Vector3d>& corners, const Shadows& shadows,
                                   std::size_t sheet, std::string_view colour) const {
  const std::string style = fmt::format("fill=\"{0}\" stroke=\"{0}\" stroke-width=\"0.3\"", colour);
  std::string svg;
  for (const auto& part : shadows.visible_parts(corners, sheet)) svg += outline(part, style);
  return svg;
}

std::string SvgPanel::visible_edges(const std::vector<Vector3d>& corners, const Shadows& shadows,
                                    std::size_t sheet) const {
  std::string svg;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    std::vector<SegmentPart> hidden = {{1, 1}};
    for (std::size_t other = 0; other < shadows.sheets().size(); ++other) {
      const auto planes = shadows.shadow(other, sheet);
      const auto part = planes.empty() ? std::nullopt : clip_segment(a, b, planes);
      if (part) hidden.push_back(*part);
    }
    std::ranges::sort(hidden, {}, &SegmentPart::from);
    double done = 0;
    for (const SegmentPart& part : hidden) {
      if (part.from > done) svg += segment(a + done * (b - a), a + part.from * (b - a));
      done = std::max(done, part.to);
    }
  }
  return svg;
}

// Appends the images of a and of the points up to the share num_points / kEdgePieces of the way.
void SvgPanel::append(const Vector3d& a, const Vector3d& b, int num_points,
                      std::vector<Vector2d>& pixels) const {
  for (int piece = 0; piece <= num_points; ++piece) {
    const double share = static_cast<double>(piece) / kEdgePieces;
    if (const auto at = project(camera_.lens, (1 - share) * a + share * b)) pixels.push_back(*at);
  }
}

}  // namespace tagcal::tools
