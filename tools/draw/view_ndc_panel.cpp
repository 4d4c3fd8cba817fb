#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>

#include "draw/labels.hpp"
#include "draw/scene_drawing.hpp"
#include "draw/view_panels.hpp"
#include "tagcal/scene/surfaces.hpp"
#include "tagcal/viewing/projection.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using study::Drawing;

constexpr double kRecedes = std::numbers::pi / 6;  // direction of depth on the page
constexpr double kHalfSide = 0.5;  // of the near face, as a share of the panel's smaller side:
constexpr double kMargin = 0.68;   // with depth and names beside it

// Clipping leaves parts that touch the volume in a point or a line.
bool has_area(const std::vector<Vector3d>& polygon) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum += (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]);
  return sum.norm() > 1e-9;  // numeric: of the cube's faces
}

class NdcPanel {
 public:
  NdcPanel(const ViewReport& report, const PanelSize& size)
      : report_(report),
        size_(size),
        pen_(cabinet_camera(), Pose()),
        labels_({0, size.width, 0, size.height}) {}

  Drawing drawing() {
    Drawing drawing;
    add_cube(drawing);
    pen_.draw(clipped_scene(), drawing);
    add_point(drawing);
    add_near_face(drawing);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector2d tip = at(1.25 * Vector3d::Unit(axis));
      labels_.add(std::string(1, "xyz"[axis]), tip, kAxisColours[axis]);
      drawing.line(at(Vector3d::Zero()), tip, kAxisColours[axis], 1.5);
    }
    labels_.add("near, z = -1", at({-1, -1, -1}), kVolumeColour);
    labels_.add("far, z = 1", at({1, 1, 1}), kVolumeColour);
    labels_.draw(drawing);
    return drawing;
  }

 private:
  // NDC has y up and z away from the viewer, the drawing x right, y down, z forward.
  static Vector3d in_drawing(const Vector3d& ndc) { return {ndc.x(), -ndc.y(), ndc.z()}; }

  Camera cabinet_camera() const {
    const double scale = kMargin * kHalfSide * std::min(size_.width, size_.height);
    const Eigen::Matrix4d cabinet = cabinet_projection(kRecedes);
    return {
        Parallel({scale, scale, size_.width / 2, size_.height / 2, cabinet(0, 2), cabinet(1, 2)}),
        {static_cast<int>(size_.width), static_cast<int>(size_.height)}};
  }

  Vector2d at(const Vector3d& ndc) const { return *pen_.pixel(in_drawing(ndc)); }

  std::vector<Vector2d> all_at(const std::vector<Vector3d>& all) const {
    std::vector<Vector2d> pixels;
    for (const Vector3d& x : all) pixels.push_back(at(x));
    return pixels;
  }

  // Appends what is left of a polygon of the scene in the canonical volume, divided by w.
  void append_clipped(const std::vector<Vector3d>& corners_in_world, double level,
                      std::vector<Occluder>& polygons) const {
    const ViewingPipeline& p = report_.pipeline;
    const Eigen::Matrix4d clip_from_world =
        p.clip_from_eye * p.eye_from_camera * p.camera_from_world.matrix();
    std::vector<Vector4d> in_clip;
    for (const Vector3d& x : corners_in_world)
      in_clip.emplace_back(clip_from_world * x.homogeneous());
    Occluder polygon{{}, level};
    for (const Vector4d& x : clip_polygon_to_volume(in_clip))
      if (const auto ndc = divided(x)) polygon.corners.push_back(in_drawing(*ndc));
    if (has_area(polygon.corners)) polygons.push_back(std::move(polygon));
  }

  // The scene in the canonical volume, as flat polygons: a projective map keeps planes.
  Scene clipped_scene() const {
    Scene result;
    const Scene& scene = report_.scene;
    for (const Sheet& sheet : sheets(scene)) {
      const double level = sheet.panel ? scene.paper_level : scene.occluders[sheet.occluder].level;
      append_clipped(sheet.corners, level, result.occluders);
      if (!sheet.panel) continue;
      const PlacedBoard& placed = scene.boards[sheet.board];
      for (InkCell& ink : drawn_print(placed.board, *sheet.panel)) {
        for (Vector3d& x : ink) x = placed.world_from_board * x;
        append_clipped(ink, scene.ink_level, result.occluders);
      }
    }
    return result;
  }

  void add_cube(Drawing& drawing) const {
    constexpr double kLine = 0.8;
    add_outline(all_at({{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}), kVolumeColour, kLine,
                drawing);
    for (const double x : {-1, 1})
      for (const double y : {-1, 1})
        drawing.line(at({x, y, -1}), at({x, y, 1}), kVolumeColour, kLine);
  }

  void add_near_face(Drawing& drawing) const {
    const auto corners = all_at({{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}});
    add_area(corners, kVolumeColour, 0.08, drawing);
    add_outline(corners, kVolumeColour, 1.2, drawing);
  }

  // The point, and its place on the near face, where the image is.
  void add_point(Drawing& drawing) {
    const auto& ndc = report_.followed.in_ndc;
    if (!ndc) return;
    const Vector2d there = at(*ndc), image = at({ndc->x(), ndc->y(), -1});
    if (!contains(pen_.camera().image_size, there)) return;
    labels_.keep_free(there);
    labels_.add(fmt::format("({:.3f}, {:.3f}, {:.3f})", ndc->x(), ndc->y(), ndc->z()), there,
                kPointColour);
    labels_.keep_free(image);
    drawing.line(image, there, kPointColour, 1);
    add_disc(image, 3, kPlaneColour, drawing);
    add_disc(there, 4, kPointColour, drawing);
  }

  const ViewReport& report_;
  PanelSize size_;
  ScenePen pen_;
  Labels labels_;
};

}  // namespace

Drawing ndc_panel(const ViewReport& report, const PanelSize& size) {
  return NdcPanel(report, size).drawing();
}

}  // namespace tagcal::tools
