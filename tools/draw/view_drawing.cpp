#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string_view>

#include "report/view_report.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/scene/visibility/shadows.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPanelWidth = 620;
constexpr int kPanelHeight = 440;
constexpr int kEdgePieces = 16;  // distortion bends edges
constexpr std::string_view kInk = "#222";
constexpr std::string_view kFrustum = "#2a78b8";
constexpr std::string_view kPoint = "#d9480f";
constexpr std::string_view kAxes[3] = {"#c92a2a", "#2b8a3e", "#1c4fd8"};

std::string grey(double level) {
  return fmt::format("rgb({0},{0},{0})", std::lround(255 * std::clamp(level, 0.0, 1.0)));
}

// Draws in world coordinates through a camera, by the library's own projection.
class Panel {
 public:
  Panel(Camera camera, Pose camera_from_world)
      : camera_(std::move(camera)), camera_from_world_(camera_from_world) {}

  std::string polygon(const std::vector<Vector3d>& corners_in_world, std::string_view style) const {
    return outline(in_camera(corners_in_world), style);
  }

  std::string line(const Vector3d& from, const Vector3d& to, std::string_view style) const {
    return segment(camera_from_world_ * from, camera_from_world_ * to, style);
  }

  std::string dot(const Vector3d& x_in_world, double radius, std::string_view style) const {
    const auto pixel = project(camera_.lens, camera_from_world_ * x_in_world);
    return pixel ? circle(*pixel, radius, style) : "";
  }

  static std::string circle(const Vector2d& pixel, double radius, std::string_view style) {
    return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" {}/>\n", pixel.x(), pixel.y(),
                       radius, style);
  }

  // What is seen of papers, tags and occluders, then of their edges.
  std::string things(const Scene& scene) const {
    std::string svg, edges;
    const Shadows shadows(scene, camera_.lens, camera_from_world_);
    for (std::size_t i = 0; i < shadows.sheets().size(); ++i) {
      const Sheet& sheet = shadows.sheets()[i];
      const double level = sheet.panel ? scene.paper_level : scene.occluders[sheet.occluder].level;
      svg += visible_area(sheet.corners, shadows, i, grey(level));
      edges += visible_edges(sheet.corners, shadows, i);
      if (!sheet.panel || !shadows.faces(i)) continue;
      const Pose& world_from_board = scene.boards[sheet.board].world_from_board;
      for (const Tag& tag : sheet.panel->tags) {
        std::vector<Vector3d> corners;
        for (const Vector3d& x : tag_corners(tag)) corners.push_back(world_from_board * x);
        svg += visible_area(in_camera(corners), shadows, i, kInk);
      }
    }
    svg += edges;
    for (const PlacedBoard& placed : scene.boards)
      for (const TargetPoint& point : placed.board.points)
        svg += dot(placed.world_from_board * point.position, 1.5, fmt::format("fill=\"{}\"", kInk));
    return svg;
  }

  std::string axes(const Pose& world_from_frame, double length) const {
    std::string svg;
    for (int axis = 0; axis < 3; ++axis)
      svg +=
          line(world_from_frame.translation(), world_from_frame * (length * Vector3d::Unit(axis)),
               fmt::format("stroke=\"{}\" stroke-width=\"2\"", kAxes[axis]));
    return svg;
  }

 private:
  std::vector<Vector3d> in_camera(const std::vector<Vector3d>& corners_in_world) const {
    std::vector<Vector3d> corners;
    for (const Vector3d& x : corners_in_world) corners.push_back(camera_from_world_ * x);
    return corners;
  }

  std::string outline(const std::vector<Vector3d>& corners, std::string_view style) const {
    std::string svg;
    for (const auto& part : clip_to_domain(corners, camera_.lens, 1e-6)) {
      std::string points;
      for (std::size_t i = 0; i < part.size(); ++i)
        for (int piece = 0; piece < kEdgePieces; ++piece)
          points += at(part[i], part[(i + 1) % part.size()], piece);
      svg += fmt::format("<polygon points=\"{}\" {}/>\n", points, style);
    }
    return svg;
  }

  std::string segment(const Vector3d& a, const Vector3d& b, std::string_view style) const {
    std::string points;
    for (int piece = 0; piece <= kEdgePieces; ++piece) points += at(a, b, piece);
    return fmt::format("<polyline points=\"{}\" fill=\"none\" {}/>\n", points, style);
  }

  // The thin stroke closes the gaps that a viewer leaves between neighbouring polygons.
  std::string visible_area(const std::vector<Vector3d>& corners, const Shadows& shadows,
                           std::size_t sheet, std::string_view colour) const {
    const std::string style =
        fmt::format("fill=\"{0}\" stroke=\"{0}\" stroke-width=\"0.3\"", colour);
    std::string svg;
    for (const auto& part : shadows.visible_parts(corners, sheet)) svg += outline(part, style);
    return svg;
  }

  std::string visible_edges(const std::vector<Vector3d>& corners, const Shadows& shadows,
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
        if (part.from > done)
          svg += segment(a + done * (b - a), a + part.from * (b - a),
                         "stroke=\"#999\" stroke-width=\"0.5\"");
        done = std::max(done, part.to);
      }
    }
    return svg;
  }

  std::string at(const Vector3d& a, const Vector3d& b, int piece) const {
    const double share = static_cast<double>(piece) / kEdgePieces;
    const auto pixel = project(camera_.lens, (1 - share) * a + share * b);
    return pixel ? fmt::format("{:.2f},{:.2f} ", pixel->x(), pixel->y()) : "";
  }

  Camera camera_;
  Pose camera_from_world_;
};

// The four corners of the frustum's cross-section at a depth, in world coordinates.
std::vector<Vector3d> cross_section(const ViewingPipeline& pipeline, double depth) {
  const Window& w = pipeline.volume.window;
  const bool parallel = pipeline.volume.projection == Projection::parallel;
  const double spread = parallel ? 1 : depth / pipeline.volume.near_m;
  const Pose world_from_camera = pipeline.camera_from_world.inverse();
  std::vector<Vector3d> result;
  for (const auto& [x, y] : {std::pair(w.left, w.bottom), std::pair(w.right, w.bottom),
                             std::pair(w.right, w.top), std::pair(w.left, w.top)})
    result.push_back(world_from_camera * Vector3d(spread * x, -spread * y, depth));
  return result;
}

// Depth of the drawn frustum: a little beyond the point, or the far plane.
double drawn_depth(const ViewReport& report) {
  const double depth = report.followed.in_camera.z();
  return depth > 0 ? 1.1 * depth : report.pipeline.volume.far_m / 2;
}

// All points that the drawing of the scene must contain.
std::vector<Vector3d> points_to_hold(const ViewReport& report) {
  std::vector<Vector3d> all = cross_section(report.pipeline, drawn_depth(report));
  all.push_back(report.pipeline.camera_from_world.inverse().translation());
  all.push_back(report.followed.in_world);
  for (const Sheet& sheet : sheets(report.scene))
    all.insert(all.end(), sheet.corners.begin(), sheet.corners.end());
  return all;
}

// The pinhole at a pose that shows these points as large as the panel allows. Precondition: all are
// in front of it.
Camera filling_camera(const Pose& camera_from_world, const std::vector<Vector3d>& points) {
  Eigen::AlignedBox2d box;
  for (const Vector3d& x : points) box.extend((camera_from_world * x).hnormalized());
  const Vector2d panel(kPanelWidth, kPanelHeight);
  const double focal = 0.95 * panel.cwiseQuotient(box.sizes()).minCoeff();
  const Vector2d centre = image_centre({kPanelWidth, kPanelHeight}) - focal * box.center();
  return {pinhole(focal, focal, centre.x(), centre.y()), {kPanelWidth, kPanelHeight}};
}

// A pose that looks across the camera's line of sight, from above and a little behind.
Panel outside_panel(const ViewReport& report) {
  const std::vector<Vector3d> points = points_to_hold(report);
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : points) box.extend(x);
  const Pose world_from_camera = report.pipeline.camera_from_world.inverse();
  Vector3d along = world_from_camera.rotation() * Vector3d::UnitZ();
  along.z() = 0;
  if (along.norm() < 1e-3) along = Vector3d::UnitY();
  along.normalize();
  const Vector3d from = along.cross(Vector3d::UnitZ()) - 0.4 * along + 0.5 * Vector3d::UnitZ();
  const Vector3d eye = box.center() + 2 * box.diagonal().norm() * from.normalized();
  const Pose pose = camera_from_world_looking_at(eye, box.center(), Vector3d::UnitZ());
  return {filling_camera(pose, points), pose};
}

std::string scene_panel(const ViewReport& report) {
  const Panel panel = outside_panel(report);
  const ViewingPipeline& p = report.pipeline;
  const double depth = drawn_depth(report);
  const Pose world_from_camera = p.camera_from_world.inverse();
  const auto end = cross_section(p, depth), picture = cross_section(p, depth / 4);
  const auto begin = cross_section(p, 0);
  const std::string thin = fmt::format("stroke=\"{}\" stroke-width=\"0.8\"", kFrustum);
  std::string svg = panel.things(report.scene);
  for (std::size_t i = 0; i < 4; ++i) svg += panel.line(begin[i], end[i], thin);
  svg += panel.polygon(end, "fill=\"none\" " + thin);
  svg += panel.polygon(picture, fmt::format("fill=\"{}\" fill-opacity=\"0.2\" {}", kFrustum, thin));
  svg += panel.axes(Pose(), depth / 5);
  svg += panel.axes(world_from_camera, depth / 8);
  const Vector3d& x = report.followed.in_camera;
  const bool parallel = p.volume.projection == Projection::parallel;
  const Vector3d from = parallel ? Vector3d(x.x(), x.y(), 0) : Vector3d::Zero();
  svg += panel.line(world_from_camera * from, report.followed.in_world,
                    fmt::format("stroke=\"{}\" stroke-width=\"1.2\"", kPoint));
  return svg + panel.dot(report.followed.in_world, 4, fmt::format("fill=\"{}\"", kPoint));
}

std::string image_panel(const ViewReport& report) {
  const ImageSize& size = report.pipeline.camera.image_size;
  const double scale = std::min(static_cast<double>(kPanelWidth) / size.width,
                                static_cast<double>(kPanelHeight) / size.height);
  const ImageSize drawn{std::max(1, static_cast<int>(size.width * scale)),
                        std::max(1, static_cast<int>(size.height * scale))};
  const Camera camera = resized(report.pipeline.camera, drawn);
  const Panel panel(camera, report.pipeline.camera_from_world);
  std::string svg = fmt::format(
      "<svg x=\"-0.5\" y=\"-0.5\" width=\"{0}\" height=\"{1}\" viewBox=\"-0.5 -0.5 {0} {1}\">\n"
      "<rect x=\"-0.5\" y=\"-0.5\" width=\"{0}\" height=\"{1}\" fill=\"{2}\"/>\n",
      drawn.width, drawn.height, grey(report.scene.background_level));
  svg += panel.things(report.scene);
  const auto p = parameters(camera.lens);
  svg += fmt::format("<path d=\"M{0:.2f} {1:.2f}m-6 0h12m-6 -6v12\" stroke=\"{2}\"/>\n", p[2], p[3],
                     kFrustum);
  const auto undistorted_pixel = project(undistorted(camera).lens, report.followed.in_camera);
  if (undistorted_pixel)
    svg += Panel::circle(*undistorted_pixel, 6, fmt::format("fill=\"none\" stroke=\"{}\"", kPoint));
  svg += panel.dot(report.followed.in_world, 3, fmt::format("fill=\"{}\"", kPoint));
  return svg + "</svg>\n";
}

template <typename Vector>
std::string caption(int row, std::string_view frame, const Vector& v, std::string_view unit) {
  std::string numbers;
  for (const double x : v) numbers += fmt::format("{}{:.4f}", numbers.empty() ? "" : ", ", x + 0.0);
  return fmt::format("<text x=\"{}\" y=\"{}\">{}: ({}){}</text>\n", 20 + row / 4 * 320,
                     kPanelHeight + 80 + row % 4 * 18, frame, numbers, unit);
}

std::string captions(const FollowedPoint& f) {
  std::string svg;
  int row = 0;
  if (f.in_board) svg += caption(row++, "board", *f.in_board, " m");
  svg += caption(row++, "world", f.in_world, " m");
  svg += caption(row++, "camera", f.in_camera, " m");
  svg += caption(row++, "eye", f.in_eye, " m");
  svg += caption(row++, "clip", f.in_clip, "");
  if (f.in_ndc) svg += caption(row++, "ndc", *f.in_ndc, "");
  if (f.in_raster_px) svg += caption(row++, "raster (open circle)", *f.in_raster_px, " px");
  if (f.pixel) svg += caption(row++, "pixel (dot)", *f.pixel, " px");
  return svg;
}

}  // namespace

std::string view_svg(const ViewReport& report) {
  const int width = 2 * kPanelWidth + 60, height = kPanelHeight + 150;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"13\">\n"
      "<title>{2}</title>\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
      width, height, report.image);
  svg += fmt::format("<text x=\"20\" y=\"28\">the scene; axes x red, y green, z blue</text>\n");
  svg += fmt::format("<text x=\"{}\" y=\"28\">the image {}; {}: {}</text>\n", kPanelWidth + 40,
                     report.image, report.point.name, sight_line(report.followed));
  svg += fmt::format("<g transform=\"translate(20,40)\">\n{}</g>\n", scene_panel(report));
  svg += fmt::format("<g transform=\"translate({},40)\">\n{}</g>\n", kPanelWidth + 40,
                     image_panel(report));
  return svg + captions(report.followed) + "</svg>\n";
}

}  // namespace tagcal::tools
