#include "report/reproject_files.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "tagcal/io/calibration_file.hpp"
#include "tagcal/reproject/maps.hpp"

namespace tagcal::tools {
namespace {

std::string matrix_yaml(const char* key, int rows, std::span<const double> values) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
                     key, rows, values.size() / static_cast<std::size_t>(rows),
                     fmt::join(values, ", "));
}

std::string pose_yaml(const char* indent, const Pose& pose, bool with_translation) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  std::string text =
      fmt::format("{}rotation: [{}, {}, {}, {}]\n", indent, q.w(), q.x(), q.y(), q.z());
  if (with_translation)
    text += fmt::format("{}translation_m: [{}, {}, {}]\n", indent, t.x(), t.y(), t.z());
  return text;
}

// True for a model whose free parameters are the scales and the principal point, each by itself.
bool is_plain_model(const Model& model) {
  return model.num_free() == 4 &&  // numeric: number of these parameters
         std::ranges::all_of(model.free(), [](const FreeParameter& free) {
           return free.lens_parameters.size() == 1 && free.lens_parameters.front() < 4;
         });
}

// The model of a lens without distortion, if its kind has one; else that of all parameters.
std::string_view model_of(const Lens& lens) {
  for (const Model& model : Model::all())
    if (is_plain_model(model) && model.contains({lens})) return model.name();
  return full_model(lens).name();
}

std::string camera_yaml(const Camera& camera) {
  const auto p = parameters(camera.lens);
  const std::size_t all =  // the coefficients in OpenCV's order; none of parallel rays
      kind_of(camera.lens).is_central ? static_cast<std::size_t>(full_model(camera.lens).num_free())
                                      : 4;
  const double matrix[] = {p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1};
  return fmt::format("image_width: {}\nimage_height: {}\n", camera.image_size.width,
                     camera.image_size.height) +
         matrix_yaml("camera_matrix", 3, matrix) +
         matrix_yaml("distortion_coefficients", 1, p.subspan(4, all - 4)) +
         fmt::format("model: \"{}\"\n", model_of(camera.lens));
}

const char* kind_of_panorama(const Panorama& p) {
  switch (p.kind) {
    case PanoramaKind::cylindrical:
      return "cylindrical";
    case PanoramaKind::transverse:
      return "transverse";
    default:
      return "equirectangular";
  }
}

std::string panorama_yaml(const Panorama& p) {
  return fmt::format(
      "panorama: {}\nimage_width: {}\nimage_height: {}\npx_per_rad: {}\n"
      "centre_px: [{}, {}]\n",
      kind_of_panorama(p), p.size.width, p.size.height, p.px_per_rad, p.centre.x(), p.centre.y());
}

std::string plane_yaml(const PlaneRaster& p) {
  return fmt::format(
      "image_width: {}\nimage_height: {}\nm_per_px: {}\n"
      "centre_of_first_pixel_m: [{}, {}]\n",
      p.size.width, p.size.height, p.m_per_px, p.upper_left.x(), p.upper_left.y());
}

std::string poses_yaml(const Target& target, const NamedPoses& poses) {
  const bool plane = std::holds_alternative<PlaneRaster>(target);
  if (!plane) return "source_camera_from_this:\n" + pose_yaml("   ", poses.front().second, false);
  std::string text = "camera_from_plane:\n";
  for (const auto& [name, pose] : poses)
    text += fmt::format("   - image: {}\n", quoted_yaml(name)) + pose_yaml("     ", pose, true);
  return text;
}

}  // namespace

std::string target_file_name(const Target& target) {
  if (std::holds_alternative<Camera>(target)) return "camera.yaml";
  return std::holds_alternative<Panorama>(target) ? "panorama.yaml" : "plane.yaml";
}

std::string target_yaml(const Target& target, const NamedPoses& poses,
                        const std::string& source_camera) {
  std::string text = "%YAML:1.0\n---\n";
  if (const auto* camera = std::get_if<Camera>(&target))
    text += camera_yaml(*camera);
  else if (const auto* panorama = std::get_if<Panorama>(&target))
    text += panorama_yaml(*panorama);
  else
    text += plane_yaml(std::get<PlaneRaster>(target));
  return text + fmt::format("source_camera: {}\n", quoted_yaml(source_camera)) +
         poses_yaml(target, poses);
}

std::string rectified_yaml(const RectifiedPair& pair, const std::array<std::string, 2>& names) {
  const ImageSize size = size_of(pair.targets[0]);
  std::string text =
      fmt::format("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", size.width, size.height);
  for (std::size_t k = 0; k < 2; ++k)
    text += fmt::format("camera{}: {}\n", k + 1, quoted_yaml(names[k]));
  text += fmt::format("baseline_m: {}\nepipolar_lines: {}\n", std::abs(pair.translation_m),
                      pair.is_vertical ? "columns" : "rows");
  const auto add = [&](const std::string& key, const auto& matrix) {
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = matrix;
    text += matrix_yaml(key.c_str(), static_cast<int>(rows.rows()),
                        {rows.data(), static_cast<std::size_t>(rows.size())});
  };
  for (std::size_t k = 0; k < 2; ++k)
    add(fmt::format("R{}", k + 1),
        pair.camera_from_rectified[k].rotation_matrix().transpose().eval());
  if (const auto* panorama = std::get_if<Panorama>(&pair.targets[0]))
    return text + fmt::format("panorama: {}\npx_per_rad: {}\ncentre_x: {}\ncentre_y: {}\n",
                              kind_of_panorama(*panorama), panorama->px_per_rad,
                              panorama->centre.x(), panorama->centre.y());
  for (std::size_t k = 0; k < 2; ++k) add(fmt::format("P{}", k + 1), projection_matrix(pair, k));
  add("Q", disparity_to_depth(pair));
  return text;
}

std::string described(const Target& target) {
  const ImageSize size = size_of(target);
  std::string text = fmt::format("{}x{} pixels", size.width, size.height);
  if (const auto* camera = std::get_if<Camera>(&target))
    text += fmt::format(", {} with fx {:.2f}", model_of(camera->lens), parameters(camera->lens)[0]);
  else if (const auto* panorama = std::get_if<Panorama>(&target))
    text += fmt::format(", {:.2f} per radian", panorama->px_per_rad);
  else
    text += fmt::format(" of {:g} m", std::get<PlaneRaster>(target).m_per_px);
  return text;
}

// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html, version 1.0. The header
// is padded so that the numbers begin at a multiple of 64 bytes.
std::string map_npy(const PixelMap& map) {
  static_assert(std::endian::native == std::endian::little);
  std::string header =
      fmt::format("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, {}, 2), }}",
                  map.x.height(), map.x.width());
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  std::string text("\x93NUMPY\x01\x00", 8);
  text += static_cast<char>(header.size() & 255);
  text += static_cast<char>(header.size() >> 8);
  text += header;
  const std::size_t begin = text.size();
  text.resize(begin + map.x.pixels().size() * 2 * sizeof(float));
  char* to = text.data() + begin;
  for (std::size_t i = 0; i < map.x.pixels().size(); ++i) {
    const float pair[] = {map.x.pixels()[i], map.y.pixels()[i]};
    std::memcpy(to, pair, sizeof pair);
    to += sizeof pair;
  }
  return text;
}

}  // namespace tagcal::tools
