#include "report/view_text.hpp"

#include <fmt/format.h>

#include <string_view>

#include "job/plain_text.hpp"
#include "job/view_values.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

Json matrices_json(const ViewReport& report) {
  const ViewingPipeline& p = report.pipeline;
  Json matrices;
  if (report.point.board)
    matrices["world_from_board"] =
        rows(report.scene.boards[*report.point.board].world_from_board.matrix());
  matrices["camera_from_world"] = rows(p.camera_from_world.matrix());
  matrices["eye_from_camera"] = rows(p.eye_from_camera);
  matrices["clip_from_eye"] = rows(p.clip_from_eye);
  matrices["raster_from_ndc"] = rows(p.raster_from_ndc);
  return matrices;
}

Json volume_json(const ViewVolume& volume) {
  const Window& w = volume.window;
  Json steps = Json::array();
  for (const NormalisingStep& step : normalising_steps(volume, CanonicalVolume::opengl))
    steps.push_back({{"name", step.name}, {"matrix", rows(step.matrix)}});
  return {{"projection", volume.projection == Projection::perspective ? "perspective" : "parallel"},
          {"left", w.left},
          {"right", w.right},
          {"bottom", w.bottom},
          {"top", w.top},
          {"near_m", volume.near_m},
          {"far_m", volume.far_m},
          {"normalising_steps", steps}};
}

Json vanishing_points_json(const ViewingPipeline& pipeline) {
  Json result;
  for (int axis = 0; axis < 3; ++axis) {
    Json points = Json::array();
    const Eigen::Vector3d direction =
        pipeline.camera_from_world.rotation() * Eigen::Vector3d::Unit(axis);
    for (const auto& pixel : vanishing_points(pipeline.camera.lens, direction))
      points.push_back(array(pixel));
    result[std::string(1, "xyz"[axis])] = points;
  }
  return result;
}

std::string matrix_text(std::string_view name, const Eigen::Matrix4d& m) {
  std::string text = fmt::format("{}\n", name);
  for (int r = 0; r < 4; ++r) {
    text += "  ";
    for (int c = 0; c < 4; ++c) text += fmt::format(" {:>12.6f}", shown(m(r, c)));
    text += "\n";
  }
  return text;
}

template <typename Vector>
std::string line(std::string_view name, const Vector& v, std::string_view comment) {
  std::string numbers;
  for (const double x : v) numbers += fmt::format(" {:>12.6f}", shown(x));
  return fmt::format("  {:<8}{:<53} {}\n", name, numbers, comment);
}

std::string point_text(const ViewReport& report) {
  const FollowedPoint& f = report.followed;
  std::string text = report.point.name + "\n";
  if (f.in_board) text += line("board", *f.in_board, "m");
  text += line("world", f.in_world, "m");
  text += line("camera", f.in_camera, "m; x right, y down, z forward");
  text += line("eye", f.in_eye, "m; x right, y up, looking along -z");
  const std::string beyond = planes_beyond(report);
  text += line(
      "clip", f.in_clip,
      beyond.empty() ? "x, y, z within +-w" : fmt::format("outside the volume: beyond {}", beyond));
  if (f.in_ndc) text += line("ndc", *f.in_ndc, "divided by w");
  if (f.in_raster_px) text += line("raster", *f.in_raster_px, "px, without distortion");
  if (f.pixel) text += line("pixel", *f.pixel, "px, through the lens");
  text += fmt::format("  {}\n", sight_line(f));
  if (f.sight == Sight::seen && !f.in_volume)
    text +=
        "  (seen by the camera, not drawn by a renderer: only a renderer has near and far "
        "planes)\n";
  if (const std::string note = pinhole_note(report); !note.empty())
    text += fmt::format("  ({})\n", note);
  return text;
}

}  // namespace

std::string view_json(const ViewReport& report) {
  const FollowedPoint& f = report.followed;
  const Camera& camera = report.pipeline.camera;
  const auto fov = field_of_view(camera);
  const Json answer = {
      {"image", report.image},
      {"image_size", {camera.image_size.width, camera.image_size.height}},
      {"model", report.scene.model},
      {"field_of_view_deg", fov ? Json({{"horizontal", degrees(fov->horizontal_rad)},
                                        {"vertical", degrees(fov->vertical_rad)},
                                        {"diagonal", degrees(fov->diagonal_rad)}})
                                : Json()},
      {"vanishing_points_px", vanishing_points_json(report.pipeline)},
      {"matrices", matrices_json(report)},
      {"view_volume", volume_json(report.pipeline.volume)},
      {"point",
       {{"name", report.point.name},
        {"in_board_m", array_or_null(f.in_board)},
        {"in_world_m", array(f.in_world)},
        {"in_camera_m", array(f.in_camera)},
        {"in_eye_m", array(f.in_eye)},
        {"in_clip", array(f.in_clip)},
        {"in_volume", f.in_volume},
        {"in_ndc", array_or_null(f.in_ndc)},
        {"in_raster_px", array_or_null(f.in_raster_px)},
        {"pixel", array_or_null(f.pixel)},
        {"seen", f.sight == Sight::seen},
        {"sight", sight_text(f.sight)},
        {"hidden_by", f.hidden_by.empty() ? Json() : Json(f.hidden_by)},
        {"hit_in_world_m", array_or_null(f.hit_in_world)}}},
      {"steps", steps_json(report)},
      {"opengl", opengl_json(report)}};
  return json_text(answer);
}

std::string view_text(const ViewReport& report, bool steps) {
  const ViewingPipeline& p = report.pipeline;
  const ImageSize& size = p.camera.image_size;
  std::string text = fmt::format("{}: {} camera, {} x {} px", report.image, report.scene.model,
                                 size.width, size.height);
  if (const auto fov = field_of_view(p.camera))
    text += fmt::format(", field of view {:.2f} x {:.2f} deg", degrees(fov->horizontal_rad),
                        degrees(fov->vertical_rad));
  text += "\n\n";
  if (report.point.board)
    text += matrix_text("world_from_board",
                        report.scene.boards[*report.point.board].world_from_board.matrix());
  text += matrix_text("camera_from_world", p.camera_from_world.matrix());
  text += matrix_text("eye_from_camera", p.eye_from_camera);
  text += matrix_text(
      fmt::format("clip_from_eye (near {:.6g} m, far {:.6g} m)", p.volume.near_m, p.volume.far_m),
      p.clip_from_eye);
  text += matrix_text("raster_from_ndc", p.raster_from_ndc);
  text += "\n" + point_text(report);
  if (steps) return text + steps_text(steps_json(report));
  return report.line_to ? text + steps_text({{"line_to", line_steps(report)}}) : text;
}

}  // namespace tagcal::tools
