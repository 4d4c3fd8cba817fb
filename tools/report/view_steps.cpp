#include "report/view_text.hpp"

#include <fmt/format.h>

#include <bitset>
#include <set>
#include <string_view>

#include "tagcal/geometry/transform.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::pair<const char*, CanonicalVolume> kVolumes[] = {
    {"opengl", CanonicalVolume::opengl},
    {"phigs", CanonicalVolume::phigs},
    {"zero_to_one", CanonicalVolume::zero_to_one},
    {"one_to_zero", CanonicalVolume::one_to_zero}};
constexpr double kRecedes = std::numbers::pi / 4;  // of depth in the oblique projections

// Those that OpenGL's volume has too are not repeated.
Json normalising_json(const ViewVolume& volume) {
  Json result;
  std::set<std::string_view> known;
  for (const auto& [name, canonical] : kVolumes) {
    Json steps = Json::array();
    for (const NormalisingStep& step : normalising_steps(volume, canonical))
      if (known.insert(step.name).second)
        steps.push_back({{"name", step.name}, {"matrix", rows(step.matrix)}});
    steps.push_back({{"name", "product of all, scaled to w = -z (parallel: 1)"},
                     {"matrix", rows(clip_from_eye(volume, canonical))}});
    result[name] = steps;
  }
  return result;
}

// The matrix by which five corners of the volume, no four of them in a plane, become those of NDC.
Json five_corners_json(const ViewVolume& volume) {
  static constexpr int kUsed[] = {0, 1, 3, 4, 6};  // near: three, far: two that are opposite
  const std::vector<Vector3d> in_eye = corners(volume);
  FivePoints source, target;
  Json eye_rows = Json::array(), ndc_rows = Json::array();
  for (std::size_t i = 0; i < std::size(kUsed); ++i) {
    const int k = kUsed[i] % 4;  // left or right, lower or upper
    const Vector3d ndc(k == 1 || k == 2 ? 1 : -1, k >= 2 ? 1 : -1, kUsed[i] < 4 ? -1 : 1);
    const Vector3d& eye = in_eye[static_cast<std::size_t>(kUsed[i])];
    source[i] = eye.homogeneous();
    target[i] = ndc.homogeneous();
    eye_rows.push_back(array(eye));
    ndc_rows.push_back(array(ndc));
  }
  Eigen::Matrix4d map = projective_map(source, target);
  map /= volume.projection == Projection::parallel ? map(3, 3) : -map(3, 2);
  return {{"in_eye_m", eye_rows},
          {"in_ndc", ndc_rows},
          {"clip_from_eye, scaled to w = -z (parallel: 1)", rows(map)}};
}

// The depth of the point in each canonical volume, and z of the eye back from it.
Json depth_json(const ViewReport& report) {
  const ViewVolume& v = report.pipeline.volume;
  const double z = report.followed.in_eye.z();
  Json result = {{"z_in_eye_m", z}};
  for (const auto& [name, canonical] : kVolumes)
    if (const auto ndc =
            divided(clip_from_eye(v, canonical) * report.followed.in_eye.homogeneous()))
      result[name] = ndc->z();
  if (report.followed.in_ndc) {
    const Raster raster{report.pipeline.camera.image_size, {0, 0}, true, 1 << 16};
    result["of_65536_levels"] =
        (raster_from_ndc(raster) * report.followed.in_ndc->homogeneous()).z();
  }
  if (v.projection == Projection::parallel || !(z < 0)) return result;
  const double k = v.near_m / v.far_m;
  result["z_back_from_opengl_m"] =
      z_from_opengl_depth(opengl_depth(z, v.near_m, v.far_m), v.near_m, v.far_m);
  result["z_back_from_phigs_m"] = v.far_m * z_from_phigs_depth(phigs_depth(z / v.far_m, k), k);
  for (const int bits : {16, 24})
    result[fmt::format("resolution_{}_bits_m", bits)] =
        depth_resolution_m(z, v.near_m, v.far_m, bits);
  return result;
}

Json planes_json(const ViewReport& report) {
  const auto planes = clip_planes(report.pipeline.clip_from_eye);
  Json result;
  for (std::size_t i = 0; i < planes.size(); ++i)
    result[fmt::format("inside_{}_m", kPlaneNames[i])] = planes[i].height(report.followed.in_eye);
  result["inside_all"] = contains(planes, report.followed.in_eye);
  return result;
}

// The line from the middle of the image to the point, clipped to the image.
Json line_clip_json(const Vector2d& in_ndc) {
  const Window window;
  const auto part = clip_line_cohen_sutherland(window, {Vector2d::Zero(), in_ndc});
  return {{"outcode_top_bottom_right_left",
           std::bitset<4>(outcode(window, in_ndc)).to_string()},  // numeric: bits of an outcode
          {"line_from_middle_in_ndc", part ? Json({array(part->from), array(part->to)}) : Json()}};
}

Json projections_json(const Vector3d& x) {
  const std::pair<const char*, Eigen::Matrix4d> all[] = {
      {"perspective_onto_z_1", perspective_from_origin(1)},
      {"perspective_from_behind_1", perspective_from_behind(1)},
      {"perspective_map", perspective_map()},
      {"orthographic", orthographic_projection()},
      {"cavalier_45_deg", cavalier_projection(kRecedes)},
      {"cabinet_45_deg", cabinet_projection(kRecedes)}};
  Json result;
  for (const auto& [name, matrix] : all)
    result[name] = array_or_null(divided(matrix * x.homogeneous()));
  return result;
}

Eigen::Matrix3d moved(double x, double y) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topRightCorner<2, 1>() << x, y;
  return m;
}

// The pixels of the points of the window in the near plane, in three steps and at once.
Json raster_from_window(const ViewingPipeline& p) {
  const ImageSize& size = p.camera.image_size;
  const Window pixels{-0.5, size.width - 0.5, size.height - 0.5, -0.5}, &window = p.volume.window;
  const Vector3d scales((pixels.right - pixels.left) / (window.right - window.left),
                        (pixels.top - pixels.bottom) / (window.top - window.bottom), 1);
  return {
      {"move the lower left corner to the origin", rows(moved(-window.left, -window.bottom))},
      {"scale metres to pixels, y down", rows(Eigen::Matrix3d(scales.asDiagonal()))},
      {"move it to the lower left corner of the image", rows(moved(pixels.left, pixels.bottom))},
      {"product", rows(viewport_from_window(pixels, window))}};
}

bool is_matrix(const Json& value) {
  return value.is_array() && !value.empty() && value[0].is_array();
}

std::string numbers_text(const Json& numbers) {
  std::string text;
  for (const Json& x : numbers) text += fmt::format(" {:>12.6f}", shown(x.get<double>()));
  return text;
}

// Zero instead of a rounding error, in metres, degrees and pixels.
double rounded(double value) { return std::abs(value) < 1e-9 ? 0 : value; }  // numeric: display

std::string value_text(const Json& value) {
  if (value.is_array()) return numbers_text(value);
  if (value.is_number()) return fmt::format(" {:>12.7g}", rounded(value.get<double>()));
  if (value.is_null()) return " none";
  return " " + (value.is_string() ? value.get<std::string>() : value.dump());
}

std::string lines(const Json& value, const std::string& name, const std::string& indent) {
  const std::string title = indent + name + "\n", deeper = indent + "  ";
  if (value.is_object()) {
    std::string text = title;
    for (const auto& [key, part] : value.items()) text += lines(part, key, deeper);
    return text;
  }
  if (is_matrix(value)) {
    std::string text = title;
    for (const Json& row : value) text += deeper + numbers_text(row) + "\n";
    return text;
  }
  if (value.is_array() && !value.empty() && value[0].is_object()) {
    std::string text = title;
    for (Json part : value) {
      const auto part_name = part["name"].get<std::string>();
      part.erase("name");
      text += part.size() == 1 ? lines(part.front(), part_name, deeper)
                               : lines(part, part_name, deeper);
    }
    return text;
  }
  return fmt::format("{}{:<{}}{}\n", indent, name, 32 - indent.size(), value_text(value));
}

}  // namespace

Json steps_json(const ViewReport& report) {
  const ViewingPipeline& p = report.pipeline;
  Json result = camera_steps(report);
  Json corner_rows = Json::array();
  for (const Vector3d& corner : corners(p.volume)) corner_rows.push_back(array(corner));
  result["corners_of_volume_in_eye_m"] = corner_rows;
  result["normalising_steps"] = normalising_json(p.volume);
  result["five_matched_corners"] = five_corners_json(p.volume);
  result["depth"] = depth_json(report);
  result["planes"] = planes_json(report);
  if (report.followed.in_ndc)
    result["line_clip"] = line_clip_json(report.followed.in_ndc->head<2>());
  if (report.line_to) result["line_to"] = line_steps(report);
  result["projections_of_point"] = projections_json(report.followed.in_camera);
  const Json viewport = raster_from_window(p);
  result["raster_from_near_window"] = viewport["product"];
  result["window_to_viewport"] = viewport;
  result["plane_of_board"] = board_plane_steps(report);
  return result;
}

std::string steps_text(const Json& steps) {
  std::string text;
  for (const auto& [name, part] : steps.items())
    if (!part.empty()) text += "\n" + lines(part, name, "");
  return text;
}

}  // namespace tagcal::tools
