#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "draw/labels.hpp"
#include "draw/outside_view.hpp"
#include "draw/scene_drawing.hpp"
#include "draw/view_panels.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using study::Drawing;

class ScenePanel {
 public:
  ScenePanel(const ViewReport& report, const PanelSize& size)
      : report_(report),
        view_(report),
        pen_(view_.camera(size), view_.camera_from_world()),
        labels_({0, size.width, 0, size.height}) {}

  Drawing drawing() {
    Drawing sight, volume, drawing;
    add_line_of_sight(sight);
    add_view_volume(volume);  // named first, these two
    pen_.draw(report_.scene, drawing);
    for (const DrawnFrame& frame : view_.frames()) add_axes(frame, drawing);
    drawing.add(volume, Vector2d::Zero());
    drawing.add(sight, Vector2d::Zero());
    name_objects();
    if (!view_.left_out().empty())
      name("beyond the drawing: " + view_.left_out(), {5, labels_.height() - 5}, kInk);
    labels_.draw(drawing);
    return drawing;
  }

 private:
  Vector2d at(const Vector3d& x_in_world) const { return *pen_.pixel(x_in_world); }

  std::vector<Vector2d> at(const std::vector<Vector3d>& points) const {
    std::vector<Vector2d> pixels;
    for (const Vector3d& x : points) pixels.push_back(at(x));
    return pixels;
  }

  void name(std::string_view text, const Vector2d& point, std::string_view colour) {
    labels_.add(text, point, colour);
  }

  void add_axes(const DrawnFrame& frame, Drawing& drawing) {
    const Vector2d origin = at(Vector3d(frame.world_from_frame.translation()));
    labels_.keep_free(origin);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector2d tip = at(view_.axis_tip(frame, axis));
      drawing.line(origin, tip, kAxisColours[axis], 2);
      name(std::string(1, "xyz"[axis]), tip, kAxisColours[axis]);
    }
    name(frame.name, origin, kInk);
  }

  void add_plane(double depth, std::string_view colour, double opacity, const std::string& text,
                 Drawing& drawing) {
    const std::vector<Vector2d> pixels = at(view_.cross_section(depth));
    const auto top = std::ranges::min_element(pixels, {}, [](const auto& p) { return p.y(); });
    name(text, *top, colour);
    add_area(pixels, colour, opacity, drawing);
    add_outline(pixels, colour, 0.9, drawing);
  }

  void add_edges(double from, double to, double dash, Drawing& drawing) const {
    const auto begin = at(view_.cross_section(from)), end = at(view_.cross_section(to));
    for (std::size_t i = 0; i < begin.size(); ++i)
      drawing.line(begin[i], end[i], kVolumeColour, 0.8, 1, dash);
  }

  void add_view_volume(Drawing& drawing) {
    const ViewVolume& v = report_.pipeline.volume;
    const double near = std::min(v.near_m, view_.drawn_depth_m());
    add_edges(0, near, 2, drawing);
    add_edges(near, view_.drawn_depth_m(), 0, drawing);
    if (v.far_m <= view_.drawn_depth_m()) {
      add_plane(v.far_m, kVolumeColour, 0.05, fmt::format("far plane, {:.4g} m", v.far_m), drawing);
    } else {
      const Vector2d end = at(view_.cross_section(view_.drawn_depth_m())).front();
      const bool near_too = v.near_m > view_.drawn_depth_m();
      name(fmt::format("{}far plane at {:.4g} m: beyond the drawing, edges cut at {:.3g} m",
                       near_too ? fmt::format("near plane at {:.4g} m, ", v.near_m) : "", v.far_m,
                       view_.drawn_depth_m()),
           end, kVolumeColour);
    }
    add_plane(view_.image_depth_m(), kPlaneColour, 0.15,
              fmt::format("image plane, drawn at {:.3g} m", view_.image_depth_m()), drawing);
    if (v.near_m <= view_.drawn_depth_m())
      add_plane(v.near_m, kVolumeColour, 0.2, fmt::format("near plane, {:.4g} m", v.near_m),
                drawing);
  }

  // The ray from the eye through the image to what stops it, and on to the point.
  void add_line_of_sight(Drawing& drawing) {
    constexpr double kLine = 1.2;
    const FollowedPoint& f = report_.followed;
    const Vector3d start = view_.sight_start_in_eye();
    const Vector2d from = at(view_.in_world(start)), point = at(f.in_world);
    const Vector2d stop = f.hit_in_world ? at(*f.hit_in_world) : point;
    drawing.line(from, stop, kPointColour, kLine);
    if (f.hit_in_world) drawing.line(stop, point, kPointColour, kLine, 1, 3);
    if (const auto inside =
            clip_segment(start, f.in_eye, clip_planes(report_.pipeline.clip_from_eye)))
      drawing.line(at(view_.in_world(start + inside->from * (f.in_eye - start))),
                   at(view_.in_world(start + inside->to * (f.in_eye - start))), kPointColour, 3,
                   0.35);
    const HalfSpace image{-Vector3d::UnitZ(), view_.image_depth_m()};
    if (const auto pierced = segment_plane_intersection(start, f.in_eye, image)) {
      const Vector2d pixel = at(view_.in_world(*pierced));
      add_disc(pixel, 3, kPlaneColour, drawing);
      labels_.keep_free(pixel);
      name("image point", pixel, kPlaneColour);
    }
    add_disc(point, 4, kPointColour, drawing);
    labels_.keep_free(point);
    name(report_.point.name, point, kPointColour);
    if (f.hit_in_world) add_hit(stop, drawing);
  }

  void add_hit(const Vector2d& stop, Drawing& drawing) {
    labels_.keep_free(stop);
    name("stopped by " + report_.followed.hidden_by, stop, kPointColour);
    add_disc(stop, 4.5, "#ffffff", drawing);
    add_ring(stop, 4.5, kPointColour, drawing);
    for (const Vector2d& arm : {Vector2d(3, 3), Vector2d(3, -3)})
      drawing.line(stop - arm, stop + arm, kPointColour, 1);
  }

  void name_objects() {
    std::map<std::string, std::vector<Vector3d>> corners_of;
    for (const Sheet& sheet : sheets(report_.scene)) {
      auto& corners = corners_of[sheet_name(report_.scene, sheet)];
      corners.insert(corners.end(), sheet.corners.begin(), sheet.corners.end());
    }
    for (const auto& [object, corners] : corners_of) {
      if (report_.point.board && object == fmt::format("board {}", *report_.point.board)) continue;
      Vector3d sum = Vector3d::Zero();
      for (const Vector3d& x : corners) sum += x;
      name(object, at(Vector3d(sum / static_cast<double>(corners.size()))), kInk);
    }
  }

  const ViewReport& report_;
  OutsideView view_;
  ScenePen pen_;
  Labels labels_;
};

}  // namespace

Drawing scene_panel(const ViewReport& report, const PanelSize& size) {
  return ScenePanel(report, size).drawing();
}

}  // namespace tagcal::tools
