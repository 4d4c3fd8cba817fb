#include <fmt/format.h>

#include <Eigen/LU>
#include <string_view>

#include "job/plain_text.hpp"
#include "report/view_text.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

// Column by column, as glLoadMatrixd and glUniformMatrix4dv take it.
Json by_columns(const Eigen::Matrix4d& m) {
  return array(Eigen::Map<const Eigen::VectorXd>(m.data(), m.size()));
}

Json camera_json(const Camera& camera) {
  Json result;
  for (std::size_t i = 0; i < 4; ++i)  // numeric: both scales and the principal point
    result[std::string(parameter_names(camera.lens)[i])] = parameters(camera.lens)[i];
  return result;
}

// The camera that the matrix gives back.
Json round_trip(const ViewingPipeline& p) {
  const CameraFromMatrix back = camera_from_opengl(p.clip_from_eye, p.camera.image_size);
  Json result = camera_json(back.camera);
  result["near_m"] = back.near_m;
  result["far_m"] = back.far_m;
  const Camera seen = undistorted(p.camera);
  const auto expected = parameters(seen.lens), actual = parameters(back.camera.lens);
  double difference = 0;
  for (std::size_t i = 0; i < 4; ++i)  // numeric: both focal lengths and the principal point
    difference = std::max(difference, std::abs(expected[i] - actual[i]));
  result["largest_difference_px"] = difference;
  return result;
}

// gluPerspective, the frustum about the axis with the same angle of view.
Json symmetric_json(const ViewingPipeline& p) {
  const Camera seen = undistorted(p.camera);
  const auto f = parameters(seen.lens);
  const ImageSize& size = p.camera.image_size;
  const double angle = field_of_view_rad(f[1], size.height);
  const double aspect = size.width / f[0] * f[1] / size.height;
  const ViewVolume symmetric = symmetric_frustum(angle, aspect, p.volume.near_m, p.volume.far_m);
  return {{"fovy_deg", degrees(angle)},
          {"aspect", aspect},
          {"largest_difference_of_entries",
           (clip_from_eye(symmetric) - p.clip_from_eye).cwiseAbs().maxCoeff()}};
}

std::string distortion_note(const ViewReport& report) {
  const Camera& camera = report.pipeline.camera;
  if (kind_of(camera.lens).reaches_behind)
    return "the lens reaches 180 deg or more, a matrix less: draw with this matrix, then distort "
           "the picture";
  if (!kind_of(camera.lens).is_central) return "parallel rays: a matrix has all of it";
  for (const double k : parameters(camera.lens).subspan(4))
    if (k != 0)
      return "the lens has distortion, which no matrix can represent: draw with this matrix, then "
             "distort the picture";
  return "the lens has no distortion: the picture is the camera's";
}

std::string array_text(std::string_view name, const Json& numbers) {
  std::string text = fmt::format("const double {}[16] = {{  // column by column\n", name);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    text += fmt::format("{}{}{}", i % 4 ? " " : "    ", numbers[i].get<double>() + 0.0,
                        i + 1 == numbers.size() ? "};\n"
                        : i % 4 == 3            ? ",\n"
                                                : ",");
  return text;
}

}  // namespace

Json opengl_json(const ViewReport& report) {
  const ViewingPipeline& p = report.pipeline;
  Json result = {{"projection", by_columns(p.clip_from_eye)},
                 {"modelview", by_columns(p.eye_from_camera * p.camera_from_world.matrix())},
                 {"near_m", p.volume.near_m},
                 {"far_m", p.volume.far_m},
                 {"camera_from_projection", round_trip(p)}};
  if (p.volume.projection == Projection::perspective) result["symmetric"] = symmetric_json(p);
  result["distortion"] = distortion_note(report);
  return result;
}

std::string view_opengl(const ViewReport& report) {
  const Json gl = opengl_json(report);
  const ImageSize& size = report.pipeline.camera.image_size;
  std::string text = fmt::format(
      "// {}: {} camera, {} x {} px, near {:.6g} m, far {:.6g} m\n// {}\n",
      one_line_text(report.image), report.scene.model, size.width, size.height,
      gl["near_m"].get<double>(), gl["far_m"].get<double>(), gl["distortion"].get<std::string>());
  text += array_text("projection", gl["projection"]);
  text += array_text("modelview", gl["modelview"]);
  text += fmt::format(
      "glViewport(0, 0, {}, {});\nglMatrixMode(GL_PROJECTION);\nglLoadMatrixd(projection);\n"
      "glMatrixMode(GL_MODELVIEW);\nglLoadMatrixd(modelview);  // world to eye; then draw in "
      "world coordinates\n// With shaders: glUniformMatrix4dv(location, 1, GL_FALSE, "
      "projection);\n",
      size.width, size.height);
  text += "// camera_from_opengl(projection):";
  for (const auto& [name, value] : gl["camera_from_projection"].items())
    text += fmt::format(" {} {:.7g}", name, value.get<double>());
  return text + "\n";
}

}  // namespace tagcal::tools
