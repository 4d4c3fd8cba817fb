#include "draw/scene_drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "draw/canvas.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using study::Drawing, study::Path;

constexpr int kEdgePieces = 16;  // distortion bends edges

// The borders of an image, and its part of a polygon.
Window borders(const ImageSize& size) { return {-0.5, size.width - 0.5, -0.5, size.height - 0.5}; }

std::vector<Vector2d> inside(const std::vector<Vector2d>& polygon, const ImageSize& size) {
  const Window window = borders(size);
  const std::array planes = {
      HalfSpace{Vector3d::UnitX(), window.left}, HalfSpace{-Vector3d::UnitX(), -window.right},
      HalfSpace{Vector3d::UnitY(), window.bottom}, HalfSpace{-Vector3d::UnitY(), -window.top}};
  std::vector<Vector3d> corners;
  for (const Vector2d& p : polygon) corners.emplace_back(p.x(), p.y(), 0);
  std::vector<Vector2d> kept;
  for (const Vector3d& p : clip_polygon(corners, planes)) kept.push_back(p.head<2>());
  return kept;
}

}  // namespace

std::string grey_colour(double level) {
  return fmt::format("#{0:02x}{0:02x}{0:02x}", std::lround(255 * std::clamp(level, 0.0, 1.0)));
}

void add_area(const std::vector<Vector2d>& points, std::string_view colour, double opacity,
              Drawing& drawing) {
  drawing.items.emplace_back(Path{points, std::string(colour), 0, opacity});
}

void add_outline(std::vector<Vector2d> points, std::string_view colour, double width,
                 Drawing& drawing) {
  if (points.empty()) return;
  points.push_back(points.front());
  drawing.items.emplace_back(Path{std::move(points), std::string(colour), width});
}

void add_disc(const Vector2d& centre, double radius, std::string_view colour, Drawing& drawing) {
  study::add_mark(study::Mark::disc, true, centre, radius, colour, drawing);
}

void add_ring(const Vector2d& centre, double radius, std::string_view colour, Drawing& drawing) {
  study::add_mark(study::Mark::disc, false, centre, radius, colour, drawing);
}

void ScenePen::draw(const Scene& scene, Drawing& drawing) const {
  Drawing edges;
  const Shadows shadows(scene, camera_.lens, camera_from_world_);
  for (std::size_t i = 0; i < shadows.sheets().size(); ++i) {
    const Sheet& sheet = shadows.sheets()[i];
    const double level = sheet.panel ? scene.paper_level : scene.occluders[sheet.occluder].level;
    draw_visible_area(sheet.corners, shadows, i, grey_colour(level), drawing);
    draw_visible_edges(sheet.corners, shadows, i, edges);
    if (!sheet.panel || !shadows.faces(i)) continue;
    const Pose camera_from_board = camera_from_world_ * scene.boards[sheet.board].world_from_board;
    for (InkCell& ink : drawn_print(scene.boards[sheet.board].board, *sheet.panel)) {
      for (Vector3d& x : ink) x = camera_from_board * x;
      draw_visible_area(ink, shadows, i, kInk, drawing);
    }
  }
  drawing.add(edges, Vector2d::Zero());
  for (const PlacedBoard& placed : scene.boards) {
    if (point_kind(placed.board) != PointKind::measured) continue;  // the others have ink
    for (const TargetPoint& point : target_points(placed.board))
      if (const auto at = pixel(placed.world_from_board * point.position))
        if (contains(camera_.image_size, *at)) add_disc(*at, 1.5, kInk, drawing);
  }
}

// The thin line closes the gaps that a viewer leaves between neighbouring polygons.
void ScenePen::draw_outline(const std::vector<Vector3d>& corners, std::string_view colour,
                            Drawing& drawing) const {
  constexpr double kLine = 0.3;
  for (const auto& part : clip_to_domain(corners, camera_.lens, 1e-6)) {
    std::vector<Vector2d> pixels;
    for (std::size_t i = 0; i < part.size(); ++i)
      append(part[i], part[(i + 1) % part.size()], kEdgePieces - 1, pixels);
    pixels = inside(pixels, camera_.image_size);
    add_area(pixels, colour, 1, drawing);
    add_outline(std::move(pixels), colour, kLine, drawing);
  }
}

void ScenePen::draw_segment(const Vector3d& a, const Vector3d& b, Drawing& drawing) const {
  std::vector<Vector2d> pixels;
  append(a, b, kEdgePieces, pixels);
  for (Polyline& part : clipped(pixels, borders(camera_.image_size)))
    drawing.items.emplace_back(Path{std::move(part), "#999999", 0.5});
}

void ScenePen::draw_visible_area(const std::vector<Vector3d>& corners, const Shadows& shadows,
                                 std::size_t sheet, std::string_view colour,
                                 Drawing& drawing) const {
  for (const auto& part : shadows.visible_parts(corners, sheet))
    draw_outline(part, colour, drawing);
}

void ScenePen::draw_visible_edges(const std::vector<Vector3d>& corners, const Shadows& shadows,
                                  std::size_t sheet, Drawing& drawing) const {
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
      if (part.from > done) draw_segment(a + done * (b - a), a + part.from * (b - a), drawing);
      done = std::max(done, part.to);
    }
  }
}

// Appends the images of a and of the points up to the share num_points / kEdgePieces of the way.
void ScenePen::append(const Vector3d& a, const Vector3d& b, int num_points,
                      std::vector<Vector2d>& pixels) const {
  for (int piece = 0; piece <= num_points; ++piece) {
    const double share = static_cast<double>(piece) / kEdgePieces;
    if (const auto at = project(camera_.lens, (1 - share) * a + share * b)) pixels.push_back(*at);
  }
}

}  // namespace tagcal::tools
