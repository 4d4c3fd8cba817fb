#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "draw/outside_view.hpp"
#include "draw/svg_panel.hpp"
#include "draw/view_panels.hpp"
#include "job/plain_text.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class ScenePanel {
 public:
  ScenePanel(const ViewReport& report, const PanelSize& size)
      : report_(report),
        view_(report),
        panel_(view_.camera(size), view_.camera_from_world()),
        labels_({0, size.width, 0, size.height}) {}

  std::string svg() {
    const std::string sight = line_of_sight(), volume = view_volume();  // named first
    std::string svg = panel_.things(report_.scene);
    for (const DrawnFrame& frame : view_.frames()) svg += axes(frame);
    svg += volume + sight;
    name_objects();
    if (!view_.left_out().empty())
      name("beyond the drawing: " + view_.left_out(), {5, labels_.height() - 5}, kInk);
    return fmt::format(
               "<g id=\"scene-drawing\" data-lens=\"{} {} {}\" data-camera-from-world=\"{}\" "
               "data-image-depth=\"{}\">\n",
               parameters(panel_.camera().lens)[0], parameters(panel_.camera().lens)[2],
               parameters(panel_.camera().lens)[3], pose_text(), view_.image_depth_m()) +
           svg + "</g>\n<g id=\"scene-labels\">\n" + labels_.svg() + "</g>\n";
  }

 private:
  std::string pose_text() const {
    const Eigen::Matrix4d m = panel_.camera_from_world().matrix();
    std::string text;
    for (int i = 0; i < 12; ++i)  // numeric: the three rows that are not 0 0 0 1
      text += fmt::format("{}{}", i ? " " : "", m(i / 4, i % 4));
    return text;
  }

  Vector2d at(const Vector3d& x_in_world) const { return *panel_.pixel(x_in_world); }

  std::vector<Vector2d> at(const std::vector<Vector3d>& points) const {
    std::vector<Vector2d> pixels;
    for (const Vector3d& x : points) pixels.push_back(at(x));
    return pixels;
  }

  void name(std::string_view text, const Vector2d& point, std::string_view colour) {
    labels_.add(text, point, colour);
  }

  std::string axes(const DrawnFrame& frame) {
    std::string svg;
    const Vector2d origin = at(Vector3d(frame.world_from_frame.translation()));
    labels_.keep_free(origin);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector2d tip = at(view_.axis_tip(frame, axis));
      svg += svg_line(fmt::format("axis-{}-{}", xml_text(frame.name), "xyz"[axis]), origin, tip,
                      fmt::format("stroke=\"{}\" stroke-width=\"2\"", kAxisColours[axis]));
      name(std::string(1, "xyz"[axis]), tip, kAxisColours[axis]);
    }
    name(frame.name, origin, kInk);
    return svg;
  }

  std::string plane(std::string_view id, double depth, std::string_view colour, double opacity,
                    const std::string& text) {
    const std::vector<Vector2d> pixels = at(view_.cross_section(depth));
    const auto top = std::ranges::min_element(pixels, {}, [](const auto& p) { return p.y(); });
    name(text, *top, colour);
    return svg_polygon(id, pixels,
                       fmt::format("fill=\"{0}\" fill-opacity=\"{1}\" stroke=\"{0}\" "
                                   "stroke-width=\"0.9\"",
                                   colour, opacity));
  }

  std::string edges(double from, double to, std::string_view style) const {
    const auto begin = at(view_.cross_section(from)), end = at(view_.cross_section(to));
    std::string svg;
    for (std::size_t i = 0; i < begin.size(); ++i) svg += svg_line("", begin[i], end[i], style);
    return svg;
  }

  std::string view_volume() {
    const ViewVolume& v = report_.pipeline.volume;
    const std::string thin = fmt::format("stroke=\"{}\" stroke-width=\"0.8\"", kVolumeColour);
    const double near = std::min(v.near_m, view_.drawn_depth_m());
    std::string svg = edges(0, near, thin + " stroke-dasharray=\"2 2\"");
    svg += edges(near, view_.drawn_depth_m(), thin);
    if (v.far_m <= view_.drawn_depth_m()) {
      svg +=
          plane("far", v.far_m, kVolumeColour, 0.05, fmt::format("far plane, {:.4g} m", v.far_m));
    } else {
      const Vector2d end = at(view_.cross_section(view_.drawn_depth_m())).front();
      const bool near_too = v.near_m > view_.drawn_depth_m();
      name(fmt::format("{}far plane at {:.4g} m: beyond the drawing, edges cut at {:.3g} m",
                       near_too ? fmt::format("near plane at {:.4g} m, ", v.near_m) : "", v.far_m,
                       view_.drawn_depth_m()),
           end, kVolumeColour);
    }
    svg += plane("image-plane", view_.image_depth_m(), kPlaneColour, 0.15,
                 fmt::format("image plane, drawn at {:.3g} m", view_.image_depth_m()));
    if (v.near_m <= view_.drawn_depth_m())
      svg += plane("near", v.near_m, kVolumeColour, 0.2,
                   fmt::format("near plane, {:.4g} m", v.near_m));
    return svg;
  }

  // The ray from the eye through the image to what stops it, and on to the point.
  std::string line_of_sight() {
    const FollowedPoint& f = report_.followed;
    const std::string ray = fmt::format("stroke=\"{}\" stroke-width=\"1.2\"", kPointColour);
    const Vector3d start = view_.sight_start_in_eye();
    const Vector2d from = at(view_.in_world(start)), point = at(f.in_world);
    const Vector2d stop = f.hit_in_world ? at(*f.hit_in_world) : point;
    std::string svg = svg_line("ray", from, stop, ray);
    if (f.hit_in_world)
      svg += svg_line("ray-behind", stop, point, ray + " stroke-dasharray=\"3 3\"");
    if (const auto inside =
            clip_segment(start, f.in_eye, clip_planes(report_.pipeline.clip_from_eye)))
      svg += svg_line(
          "ray-in-volume", at(view_.in_world(start + inside->from * (f.in_eye - start))),
          at(view_.in_world(start + inside->to * (f.in_eye - start))),
          fmt::format("stroke=\"{}\" stroke-width=\"3\" stroke-opacity=\"0.35\"", kPointColour));
    const HalfSpace image{-Vector3d::UnitZ(), view_.image_depth_m()};
    if (const auto pierced = segment_plane_intersection(start, f.in_eye, image)) {
      const Vector2d pixel = at(view_.in_world(*pierced));
      svg += svg_circle("image-point", pixel, 3, fmt::format("fill=\"{}\"", kPlaneColour));
      labels_.keep_free(pixel);
      name("image point", pixel, kPlaneColour);
    }
    svg += svg_circle("point", point, 4, fmt::format("fill=\"{}\"", kPointColour));
    labels_.keep_free(point);
    name(report_.point.name, point, kPointColour);
    if (f.hit_in_world) svg += hit(stop);
    return svg;
  }

  std::string hit(const Vector2d& stop) {
    labels_.keep_free(stop);
    name("stopped by " + report_.followed.hidden_by, stop, kPointColour);
    return svg_circle(
               "hit", stop, 4.5,
               fmt::format("fill=\"#fff\" stroke=\"{}\" stroke-width=\"1.5\"", kPointColour)) +
           fmt::format("<path d=\"M{:.2f} {:.2f}m-3 -3l6 6m0 -6l-6 6\" stroke=\"{}\"/>\n", stop.x(),
                       stop.y(), kPointColour);
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
  SvgPanel panel_;
  SvgLabels labels_;
};

}  // namespace

std::string scene_panel(const ViewReport& report, const PanelSize& size) {
  return ScenePanel(report, size).svg();
}

}  // namespace tagcal::tools
