#include "tagcal/io/formats/colmap_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/text_lines.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text/number_text.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::internal {
namespace {

constexpr int kMostId = std::numeric_limits<int>::max();

// A lens of COLMAP: where each of its parameters stands in those of the lens here, -1 for f, which
// is fx and fy.
struct CameraModel {
  std::string_view name;
  bool fisheye;
  std::vector<int> places;
};

const std::vector<CameraModel>& camera_models() {
  static const std::vector<CameraModel> all = {
      {"SIMPLE_PINHOLE", false, {-1, 2, 3}},
      {"PINHOLE", false, {0, 1, 2, 3}},
      {"SIMPLE_RADIAL", false, {-1, 2, 3, 4}},
      {"RADIAL", false, {-1, 2, 3, 4, 5}},
      {"OPENCV", false, {0, 1, 2, 3, 4, 5, 6, 7}},
      {"FULL_OPENCV", false, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}},
      {"SIMPLE_RADIAL_FISHEYE", true, {-1, 2, 3, 4}},
      {"RADIAL_FISHEYE", true, {-1, 2, 3, 4, 5}},
      {"OPENCV_FISHEYE", true, {0, 1, 2, 3, 4, 5, 6, 7}}};
  return all;
}

using CameraIds = std::map<std::string, std::size_t>;  // places of the cameras by their ids

void check_count(std::size_t count, const TextLines& lines) {
  if (count >= limits::kMaxListedPoses)
    lines.fail(fmt::format("must have at most {} cameras and pictures", limits::kMaxListedPoses));
}

FileCamera read_camera(const TextLines& lines, const std::string& where) {
  const std::string name(lines.words()[1]);
  const auto kind = std::ranges::find(camera_models(), name, &CameraModel::name);
  if (kind == camera_models().end())
    lines.fail(fmt::format("MODEL: the lens {} is one that tagcal does not have", shown(name)));
  const ImageSize size{lines.whole(2, "WIDTH", 1, limits::kMaxSidePx),
                       lines.whole(3, "HEIGHT", 1, limits::kMaxSidePx)};
  if (lines.words().size() != 4 + kind->places.size())
    lines.fail(fmt::format("PARAMS: must have {} values with {}, got {}", kind->places.size(), name,
                           lines.words().size() - 4));
  std::vector<double> p(12);
  for (std::size_t i = 0; i < kind->places.size(); ++i) {
    const double value = lines.number(4 + i, "PARAMS");
    if (kind->places[i] < 0) p[0] = p[1] = value;
    if (kind->places[i] >= 0) p[static_cast<std::size_t>(kind->places[i])] = value;
  }
  p[2] -= kHalfPixel;
  p[3] -= kHalfPixel;
  if (kind->fisheye) p.resize(8);
  try {
    return file_camera(std::string(lines.words()[0]),
                       kind->fisheye ? lens_of(kind_of<Fisheye>(), p, where)
                                     : lens_of(kind_of<Perspective>(), p, where),
                       size);
  } catch (const Error& error) {
    lines.fail(std::string(error.what()).substr(where.size() + 2));
  }
}

// The line of points behind each pose, X Y POINT3D_ID of each, which are not used. Another pose
// here would be one that is lost.
void skip_points(TextLines& lines, const std::string& image) {
  if (!lines.next(true)) return;
  const auto& words = lines.words();
  const bool numbers = std::ranges::all_of(
      words, [](std::string_view word) { return parse_number(word).has_value(); });
  if (numbers && words.size() % 3 == 0) return;
  lines.fail(fmt::format("must be blank or have X Y POINT3D_ID of each point of {}, got {}",
                         shown(image), shown(lines.line())));
}

// A pose and a name, then a line of points, which may be blank.
void read_images(const ColmapText& text, const CameraIds& cameras, CameraFile& file) {
  check_plain_text(text.text, text.name);
  TextLines lines(text.name, text.text);
  std::set<int> ids;
  std::set<std::string> names;
  while (lines.next()) {
    check_count(file.poses.size(), lines);
    if (lines.words().size() != 10)
      lines.fail("must have IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, the name without spaces");
    if (!ids.insert(lines.whole(0, "IMAGE_ID", 0, kMostId)).second)
      lines.fail("IMAGE_ID: must differ from those before it");
    const std::string image(lines.words()[9]);
    if (!names.insert(image).second)
      lines.fail(fmt::format("NAME: must differ from those before it, got {}", shown(image)));
    std::array<double, 7> v = {};
    constexpr std::array<std::string_view, 7> kNames = {"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = lines.number(1 + i, kNames[i]);
    const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
    if (!(std::abs(q.norm() - 1) <= kRotationTolerance))
      lines.fail(fmt::format("QW QX QY QZ: must be a unit quaternion, got one of length {:.6g}",
                             q.norm()));
    const std::string id(lines.words()[8]);
    const auto camera = cameras.find(id);
    if (camera == cameras.end())
      lines.fail(fmt::format("CAMERA_ID: must be one of cameras.txt, got {}", shown(id)));
    file.poses.push_back({image, camera->second, Pose(q, {v[4], v[5], v[6]})});
    skip_points(lines, image);
  }
}

std::string camera_line(const FileCamera& camera, std::size_t id) {
  const bool fisheye = is_fisheye(camera);
  const std::span<const double> given =
      fisheye ? parameters(camera.calibration.camera.lens) : perspective_numbers(camera, "colmap");
  std::vector<double> p(given.begin(), given.end());
  const auto zero_from = [&](int first) {
    return std::all_of(p.begin() + first, p.end(), [](double k) { return k == 0; });
  };
  const std::string_view name = fisheye        ? "OPENCV_FISHEYE"
                                : zero_from(4) ? "PINHOLE"
                                : zero_from(8) ? "OPENCV"
                                               : "FULL_OPENCV";
  p.resize(std::ranges::find(camera_models(), name, &CameraModel::name)->places.size());
  p[2] += kHalfPixel;
  p[3] += kHalfPixel;
  const ImageSize& size = camera.calibration.camera.image_size;
  std::string line = fmt::format("{} {} {} {}", id, name, size.width, size.height);
  for (const double value : p) line += fmt::format(" {}", value);
  return line + "\n";
}

std::string images_text(const std::vector<ImagePose>& poses) {
  std::string text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# a blank line\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string& image = poses[i].image;
    if (image.empty() || image.find_first_of(" \t\r\n") != std::string::npos)
      throw Error(fmt::format("COLMAP ends the name of a picture at a space: {} must have none",
                              shown(image)));
    const Eigen::Quaterniond q = poses[i].camera_from_world.rotation();
    const Eigen::Vector3d& t = poses[i].camera_from_world.translation();
    text += fmt::format("{} {} {} {} {} {} {} {} {} {}\n\n", i + 1, q.w(), q.x(), q.y(), q.z(),
                        t.x(), t.y(), t.z(), poses[i].camera + 1, image);
  }
  return text;
}

}  // namespace

bool is_colmap_cameras(std::string_view text) {
  TextLines lines("", text);
  if (!lines.next()) return false;
  const auto& words = lines.words();
  return words.size() >= 4 && parse_whole(words[0]) && parse_whole(words[2]) &&
         parse_whole(words[3]) && !parse_whole(words[1]) &&
         words[1].find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") ==
             std::string_view::npos;
}

CameraFile read_colmap(const ColmapText& cameras, const std::optional<ColmapText>& images) {
  CameraFile file;
  file.format = "colmap";
  check_plain_text(cameras.text, cameras.name);
  TextLines lines(cameras.name, cameras.text);
  CameraIds places;
  while (lines.next()) {
    check_count(file.cameras.size(), lines);
    if (lines.words().size() < 4) lines.fail("must have CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    lines.whole(0, "CAMERA_ID", 0, kMostId);
    file.cameras.push_back(read_camera(lines, cameras.name));
    if (!places.emplace(file.cameras.back().name, places.size()).second)
      lines.fail("CAMERA_ID: must differ from those before it");
  }
  if (file.cameras.empty()) throw Error(cameras.name + ": has no cameras");
  if (images) read_images(*images, places, file);
  file.notes.emplace_back(
      "pixel centres are at (0.5, 0.5) in COLMAP and (0, 0) here: cx and cy became 0.5 smaller");
  return file;
}

FormatOutput write_colmap(const CameraFile& file, bool cameras_only) {
  FormatOutput output;
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t i = 0; i < file.cameras.size(); ++i) text += camera_line(file.cameras[i], i + 1);
  output.files = {{cameras_only ? "" : "cameras.txt", text}};
  if (!cameras_only) {
    output.files.push_back({"images.txt", images_text(file.poses)});
    output.files.push_back({"points3D.txt",
                            "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, "
                            "POINT2D_IDX)\n"});
  } else {
    note_no_poses(file, output.notes);
  }
  output.notes.emplace_back(
      "pixel centres are at (0.5, 0.5) in COLMAP and (0, 0) here: cx and cy became 0.5 larger");
  note_no_uncertainty(file, output.notes);
  note_no_rig(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
