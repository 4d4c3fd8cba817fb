#include "tagcal/io/formats/colmap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/text_lines.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::internal {
namespace {

constexpr int kMostId = std::numeric_limits<int>::max();

using CameraIds = std::map<std::string, std::size_t>;  // places of the cameras by their ids

void check_count(std::size_t count, const TextLines& lines) {
  if (count >= limits::kMaxListedPoses)
    lines.fail(fmt::format("must have at most {} cameras and pictures", limits::kMaxListedPoses));
}

FileCamera read_camera(const TextLines& lines, const std::string& where) {
  const std::string name(lines.words()[1]);
  const ImageSize size{lines.whole(2, "WIDTH", 1, limits::kMaxSidePx),
                       lines.whole(3, "HEIGHT", 1, limits::kMaxSidePx)};
  std::vector<double> values;
  for (std::size_t i = 4; i < lines.words().size(); ++i)
    values.push_back(lines.number(i, "PARAMS"));
  try {
    return file_camera(std::string(lines.words()[0]), colmap_lens(name, values, where), size);
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

// The pose of words i to i + 6.
Pose read_words(const TextLines& lines, std::size_t i, std::string_view what) {
  std::array<double, 7> v = {};
  constexpr std::array<std::string_view, 7> kNames = {"QW", "QX", "QY", "QZ", "TX", "TY", "TZ"};
  for (std::size_t k = 0; k < v.size(); ++k) v[k] = lines.number(i + k, kNames[k]);
  const Eigen::Quaterniond q(v[0], v[1], v[2], v[3]);
  if (!(std::abs(q.norm() - 1) <= kRotationTolerance))
    lines.fail(
        fmt::format("{}: must be a unit quaternion, got one of length {:.6g}", what, q.norm()));
  return {q, {v[4], v[5], v[6]}};
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
    const Pose pose = read_words(lines, 1, "QW QX QY QZ");
    const std::string id(lines.words()[8]);
    const auto camera = cameras.find(id);
    if (camera == cameras.end())
      lines.fail(fmt::format("CAMERA_ID: must be one of cameras.txt, got {}", shown(id)));
    file.poses.push_back({image, camera->second, pose});
    skip_points(lines, image);
  }
}

std::string camera_line(const FileCamera& camera, std::size_t id) {
  const ColmapLens lens = lens_of_colmap(camera);
  const ImageSize& size = camera.calibration.camera.image_size;
  return fmt::format("{} {} {} {} {}\n", id, lens.name, size.width, size.height,
                     fmt::join(lens.values, " "));
}

std::string images_text(const std::vector<ImagePose>& poses) {
  std::string text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# a blank line\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string& image = poses[i].image;
    if (image.empty() || image.find_first_of(" \t\r\n") != std::string::npos)
      throw Error(fmt::format("COLMAP ends the name of a picture at a space: {} must have none",
                              shown(image)));
    text += fmt::format("{} {} {} {}\n\n", i + 1, colmap_pose(poses[i].camera_from_world),
                        poses[i].camera + 1, image);
  }
  return text;
}

FileCamera& camera_of_sensor(const TextLines& lines, std::size_t i, const CameraIds& cameras,
                             CameraFile& file) {
  if (lines.words().size() <= i + 1 || lines.words()[i] != "CAMERA")
    lines.fail("must have CAMERA and the id of one in cameras.txt for each sensor");
  const std::string id(lines.words()[i + 1]);
  const auto camera = cameras.find(id);
  if (camera == cameras.end())
    lines.fail(fmt::format("SENSOR_ID: must be one of cameras.txt, got {}", shown(id)));
  return file.cameras[camera->second];
}

// The places of the cameras, if one rig has them all. A rig of one camera says nothing.
void read_rigs(const ColmapText& text, const CameraIds& cameras, CameraFile& file) {
  check_plain_text(text.text, text.name);
  TextLines lines(text.name, text.text);
  int num_rigs = 0;
  while (lines.next()) {
    if (lines.words().size() < 2) lines.fail("must have RIG_ID NUM_SENSORS");
    const int sensors = lines.whole(1, "NUM_SENSORS", 0, static_cast<int>(cameras.size()));
    if (sensors < 2) continue;
    if (++num_rigs > 1) lines.fail("is a second rig of several cameras: tagcal takes one a file");
    camera_of_sensor(lines, 2, cameras, file).camera_from_rig = Pose();
    file.notes.emplace_back(
        "places have the unit of the reconstruction, which is the metre only if it was scaled");
    std::size_t at = 4;
    for (int i = 1; i < sensors; ++i) {
      FileCamera& camera = camera_of_sensor(lines, at, cameras, file);
      if (camera.camera_from_rig) lines.fail("SENSOR_ID: must differ from those before it");
      const int has_pose = lines.whole(at + 2, "HAS_POSE", 0, 1);
      at += 3;
      if (has_pose == 0) continue;
      camera.camera_from_rig = read_words(lines, at, "SENSORS");
      at += 7;
    }
    if (at != lines.words().size()) lines.fail("has more words than its sensors need");
  }
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

CameraFile read_colmap(const ColmapText& cameras, const std::optional<ColmapText>& images,
                       const std::optional<ColmapText>& rigs) {
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
  if (rigs) read_rigs(*rigs, places, file);
  file.notes.emplace_back(
      "pixel centres are at (0.5, 0.5) in COLMAP and (0, 0) here: cx and cy became 0.5 smaller");
  return file;
}

FormatOutput write_colmap(const CameraFile& file, bool cameras_only) {
  FormatOutput output;
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t i = 0; i < file.cameras.size(); ++i) text += camera_line(file.cameras[i], i + 1);
  output.files = {{cameras_only ? "" : "cameras.txt", text}};
  const std::optional<ColmapRig> rig = colmap_rig(file);
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
  if (rig && !cameras_only) {
    output.files.push_back({"rigs.txt", colmap_rigs_text(file, *rig)});
    output.files.push_back({"frames.txt", colmap_frames_text(file, *rig)});
    output.files.push_back({"rig_config.json", rig_config_text(file, *rig)});
    note_reference(file, *rig, output.notes);
  } else {
    note_no_rig(file, output.notes);
  }
  note_no_uncertainty(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
