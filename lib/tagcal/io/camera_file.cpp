#include "tagcal/io/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/colmap.hpp"
#include "tagcal/io/formats/format_table.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* kColmapCameras = "cameras.bin";

std::string format_names() { return joined(camera_formats(), ", ", &CameraFormat::name); }

// Throws Error, with the name of the lens, for a CAHVOR file of JPL.
void refuse_cahvor(const std::string& text, const std::string& name) {
  const std::size_t at = text.substr(0, 4096).find("Model = CAHV");
  if (at == std::string::npos) return;
  const std::size_t begin = at + 8, end = text.find_first_of(" =\r\n", begin);
  throw Error(fmt::format("{}: Model: the lens {} is one that tagcal does not have", name,
                          shown(text.substr(begin, end - begin))));
}

// "camera (tagcal), camera_matrix (opencv), .."
std::string keys_of_formats() {
  std::string keys;
  for (const FormatRow& row : format_rows())
    if (!row.key.empty())
      keys += fmt::format("{}{} ({})", keys.empty() ? "" : ", ", row.key, row.format.name);
  return keys;
}

const FormatRow& row_of(std::string_view format) {
  for (const FormatRow& row : format_rows())
    if (row.format.name == format) return row;
  throw Error(fmt::format("{}: is no format that is known: {}", shown(format), format_names()));
}

// COLMAP's binary files, as the text that says the same.
CameraFile read_colmap_binary(const fs::path& cameras) {
  std::optional<ColmapText> images;
  std::error_code error;
  const fs::path beside = cameras.parent_path() / "images.bin";
  if (fs::is_regular_file(beside, error))
    images = {beside.string(), colmap_images_text(read_text(beside), beside.string())};
  return read_colmap({cameras.string(), colmap_cameras_text(read_text(cameras), cameras.string())},
                     images);
}

CameraFile read_folder(const fs::path& folder, const ImageSize& stated) {
  std::error_code error;
  for (const FormatRow& row : format_rows()) {
    const fs::path cameras = folder / row.format.file;
    if (row.format.folder && fs::is_regular_file(cameras, error))
      return row.readers.front().read({cameras, read_text(cameras), {}, stated});
  }
  for (const char* const name : {"truth.yaml", "transforms.json", "intrinsics.yml"})
    if (fs::is_regular_file(folder / name, error)) return read_camera_file(folder / name, stated);
  if (fs::is_regular_file(folder / kColmapCameras, error))
    return read_colmap_binary(folder / kColmapCameras);
  for (const FormatRow& row : format_rows())
    if (!row.format.each.empty())
      if (auto cameras = read_camera_folder(folder, row, stated)) return *cameras;
  throw Error(folder.string() +
              ": is a folder without cameras.txt, cameras.bin, truth.yaml, transforms.json, "
              "intrinsics.yml or a file for each camera (x.cameramodel, x/sensor.yaml, x.yaml of "
              "ROS)");
}

// Two cameras of a rig farther apart than this are taken for a file in millimetres. Chosen by hand:
// longer than a lorry, and less than 31 mm, which no two cameras with common views are apart.
constexpr double kMostMetresApart = 30;

// What all formats must have: names that differ, and places in metres.
void check_cameras(const CameraFile& file, const std::string& name) {
  std::set<std::string> names;
  for (const FileCamera& camera : file.cameras) {
    if (!camera.name.empty() && !names.insert(camera.name).second)
      throw Error(fmt::format("{}: two cameras have the name {}", name, shown(camera.name)));
    const std::optional<Pose>&place = camera.camera_from_rig,
          &first = file.cameras.front().camera_from_rig;
    if (!place || !first || row_of(file.format).any_unit) continue;
    const double metres = (*place * first->inverse()).translation().norm();
    if (metres > kMostMetresApart)
      throw Error(fmt::format(
          "{}: the camera {} is {:.6g} m from {}: places must be in metres, divide those in "
          "millimetres by 1000",
          name, shown(camera.name), metres, shown(file.cameras.front().name)));
  }
}

// COLMAP's points are never written: those of another model must not be lost.
void keep_points_of_others(const fs::path& folder, const FormatOutput& output) {
  for (const OutputText& file : output.files) {
    std::error_code error;
    const fs::path path = folder / file.name;
    if (file.name != "points3D.txt" || !fs::exists(path, error)) continue;
    if (read_text(path) == file.text) continue;
    throw Error(path.string() + ": holds the points of a model: choose another folder");
  }
}

// COLMAP's rigs that would be read beside other cameras.
void keep_rigs_of_others(const fs::path& folder, const FormatOutput& output) {
  const auto writes = [&](std::string_view name) {
    return std::ranges::find(output.files, name, &OutputText::name) != output.files.end();
  };
  std::error_code error;
  if (writes("cameras.txt") && !writes("rigs.txt") && fs::exists(folder / "rigs.txt", error))
    throw Error((folder / "rigs.txt").string() +
                ": holds the rig of other cameras: choose another folder");
}

void write_files(const fs::path& out, const FormatOutput& output) {
  const bool folder = !output.files.front().name.empty();
  std::error_code error;
  if (folder) fs::create_directories(out, error);
  if (error) throw Error(out.string() + ": cannot make the folder: " + error.message());
  // The files belong together: those of another process come before or after all of them.
  std::optional<FolderLock> lock;
  if (folder) lock.emplace(out, std::chrono::seconds(10));
  if (folder) keep_points_of_others(out, output);
  if (folder) keep_rigs_of_others(out, output);
  for (const OutputText& file : output.files) {
    const fs::path path = folder ? out / file.name : out;
    if (folder) fs::create_directories(path.parent_path(), error);
    write_whole(path, file.text);
  }
}

// The poses of one camera, which becomes the only one.
CameraFile only(CameraFile file, std::size_t camera) {
  std::erase_if(file.poses, [&](const ImagePose& pose) { return pose.camera != camera; });
  for (ImagePose& pose : file.poses) pose.camera = 0;
  file.cameras = {file.cameras[camera]};
  file.cameras.front().overlaps.reset();  // numbers of the others
  return file;
}

// The place of the colon between a file and a name, which both may have some: that after the
// longest file that exists. None if all of it is a file.
std::size_t colon_before_name(const std::string& file_and_name) {
  std::error_code error;
  if (fs::exists(file_and_name, error)) return std::string::npos;
  std::size_t colon = file_and_name.rfind(':');
  while (colon != std::string::npos && !fs::exists(file_and_name.substr(0, colon), error))
    colon = colon == 0 ? std::string::npos : file_and_name.rfind(':', colon - 1);
  return colon;
}

}  // namespace

namespace {

CameraFile read_any(const fs::path& path, const ImageSize& stated) {
  std::error_code error;
  if (fs::is_directory(path, error)) return read_folder(path, stated);
  if (path.filename() == kColmapCameras) return read_colmap_binary(path);
  if (path.extension() == ".bin")
    throw Error(path.string() + ": is no camera's file; of COLMAP's model name cameras.bin");
  CameraText file{path, read_text(path), {}, stated};
  refuse_cahvor(file.text, path.string());
  if (const FormatReader* const reader = reader_of(file)) return reader->read(file);
  file.top->refuse_other_kind("a camera's file");
  file.top->fail_plainly("is no camera's file: it has none of the keys " + keys_of_formats());
}

}  // namespace

CameraFile read_camera_file(const fs::path& path, const ImageSize& stated) {
  CameraFile file = read_any(path, stated);
  check_cameras(file, path.string());
  return file;
}

CameraFile read_one_camera(const std::string& file_and_name, const ImageSize& stated) {
  const std::size_t colon = colon_before_name(file_and_name);
  const bool named = colon != std::string::npos;
  const std::string path = named ? file_and_name.substr(0, colon) : file_and_name;
  const std::string name = named ? file_and_name.substr(colon + 1) : "";
  const CameraFile file = read_camera_file(path, stated);
  if (!named && file.cameras.size() == 1) return only(file, 0);
  std::string names;
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    if (named && file.cameras[i].name == name) return only(file, i);
    names += (names.empty() ? "" : ", ") + shown(file.cameras[i].name);
  }
  if (named)
    throw Error(fmt::format("{}: has no camera {}, only {}", path, shown(name),
                            names.empty() ? "one without a name" : names));
  throw Error(fmt::format("{}: has {} cameras ({}): choose one by {}:{}", path, file.cameras.size(),
                          names, path, shown(file.cameras.front().name)));
}

const CalibrationFile& usable_camera(const CameraFile& file, const std::string& name) {
  const FileCamera& camera = file.cameras.front();
  if (!kind_of(camera.calibration.camera.lens).is_central)
    throw Error(name + ": a parallel camera has no focal length, which is needed here");
  if (camera.calibration.camera.image_size == ImageSize{})
    throw Error(
        fmt::format("{}: image_width: the key is missing: tagcal convert {} "
                    "camera.yaml --to tagcal --image-size WIDTHxHEIGHT adds it",
                    name, name));
  return camera.calibration;
}

std::vector<ImagePose> read_poses(const fs::path& file) {
  const YamlValue top = YamlValue::read(file);
  std::vector<ImagePose> poses;
  std::set<std::string> names;
  for (const YamlValue& view : top.at("views").items(0, limits::kMaxListedPoses)) {
    const std::string image = read_image_name(view.at("image"), names);
    const auto pose = view.find("camera_from_board");
    if (!pose || !(pose->is_map() || pose->is_list())) continue;
    poses.push_back({image, 0, read_pose(*pose)});
    if (const auto time = view.find("time_s"); time && time->is_scalar())
      poses.back().time_s = time->number();
  }
  if (poses.empty()) top.at("views").fail_plainly("has no view with a pose, camera_from_board");
  return poses;
}

bool is_camera_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    return fs::is_regular_file(path / "cameras.txt", error) ||
           fs::is_regular_file(path / kColmapCameras, error);
  if (path.filename() == kColmapCameras) return true;
  CameraText file{path, read_text(path), {}, {}};
  return reader_of(file) != nullptr;
}

std::vector<std::string> write_camera_file(const fs::path& out, const CameraFile& file,
                                           std::string_view format) {
  try {
    const FormatRow& row = row_of(format);
    for (const FileCamera& camera : file.cameras)
      if (!row.format.only_poses && camera.calibration.camera.image_size == ImageSize{})
        throw Error("the image size is not known: give it by --image-size");
    const bool each = !row.format.each.empty() && file.cameras.size() > 1 && names_folder(out);
    const FormatOutput output = each ? write_camera_folder(file, row, out) : row.write(file, out);
    write_files(out, output);
    return output.notes;
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.starts_with(out.string())) throw;
    throw Error(out.string() + ": " + message);
  }
}

}  // namespace tagcal
