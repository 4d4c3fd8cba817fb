#include "tagcal/io/formats/format_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::internal {
namespace {

namespace fs = std::filesystem;

std::string file_of_camera(const FormatRow& row, std::string_view name) {
  return fmt::format(fmt::runtime(row.format.each), name);
}

// The files of a folder that have the names of cameras' files, by the cameras' names.
std::map<std::string, fs::path> files_of_cameras(const fs::path& folder, const FormatRow& row) {
  const std::string end = file_of_camera(row, "");
  std::map<std::string, fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::string name = entry.path().filename().string();
    if (end.front() != '/') {
      if (!name.ends_with(end) || name.size() == end.size()) continue;
      name.resize(name.size() - end.size());
    }
    const fs::path file = folder / file_of_camera(row, name);
    if (fs::is_regular_file(file, error)) files.emplace(name, file);
  }
  return files;
}

void add_notes(std::vector<std::string>& notes, const std::vector<std::string>& others) {
  for (const std::string& note : others)
    if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
}

// Files of single cameras, none of which was placed, all say the same place.
void remove_equal_places(CameraFile& file) {
  if (file.cameras.size() < 2) return;
  const std::optional<Pose>& first = file.cameras.front().camera_from_rig;
  for (const FileCamera& camera : file.cameras)
    if (!first || !camera.camera_from_rig || !minus(*first, *camera.camera_from_rig).isZero())
      return;
  for (FileCamera& camera : file.cameras) camera.camera_from_rig.reset();
  file.rig_is_imu = false;
  file.notes.emplace_back("dropped: the places of the cameras, which are all the same");
}

// Throws Error unless the name is that of a file.
void need_file_name(const std::string& name) {
  const bool plain =
      name != "." && name != ".." && name.find_first_of("/\\") == name.npos && is_image_name(name);
  if (!plain)
    throw Error(fmt::format("the camera {} cannot name its file: rename it in IN", shown(name)));
}

}  // namespace

bool names_folder(const fs::path& out) {
  std::error_code error;
  return fs::is_directory(out, error) || !out.has_extension();
}

std::optional<CameraFile> read_camera_folder(const fs::path& folder, const FormatRow& row,
                                             const ImageSize& stated) {
  CameraFile all;
  bool all_of_imu = true;
  for (const auto& [name, path] : files_of_cameras(folder, row)) {
    CameraText text{path, read_text(path), {}, stated};
    const FormatReader* const reader = reader_of(text);
    if (!reader) continue;  // sensor.yaml of an IMU
    CameraFile one = reader->read(text);
    if (one.format != row.format.name) continue;
    one.cameras.front().name = name;
    all.format = one.format;
    all_of_imu = all_of_imu && one.rig_is_imu;
    all.cameras.push_back(std::move(one.cameras.front()));
    add_notes(all.notes, one.notes);
    if (all.cameras.size() > limits::kMaxRigCameras)
      throw Error(fmt::format("{}: has files of more than {} cameras", folder.string(),
                              limits::kMaxRigCameras));
  }
  if (all.cameras.empty()) return std::nullopt;
  all.rig_is_imu = all_of_imu;
  remove_equal_places(all);
  return all;
}

FormatOutput write_camera_folder(const CameraFile& given, const FormatRow& row,
                                 const fs::path& folder) {
  std::map<std::string, fs::path> others = files_of_cameras(folder, row);
  CameraFile file = given;
  FormatOutput output;
  if (row.format.rectified) {
    set_rectification(file);
    output.notes.assign(file.notes.begin() + std::ssize(given.notes), file.notes.end());
  }
  for (std::size_t i = 0; i < file.cameras.size(); ++i) {
    const std::string name = camera_name(file, i);
    need_file_name(name);
    CameraFile one = file;
    one.cameras = {file.cameras[i]};
    std::erase_if(one.poses, [&](const ImagePose& pose) { return pose.camera != i; });
    for (ImagePose& pose : one.poses) pose.camera = 0;
    const FormatOutput part = row.write(one, folder);
    const std::string path = file_of_camera(row, name);
    if (std::ranges::find(output.files, path, &OutputText::name) != output.files.end())
      throw Error(fmt::format("two cameras have the name {}", shown(name)));
    output.files.push_back({path, part.files.front().text});
    add_notes(output.notes, part.notes);
    others.erase(name);
  }
  if (!others.empty())
    throw Error(others.begin()->second.string() +
                ": would be read as a camera of the rig: choose another folder");
  return output;
}

}  // namespace tagcal::internal
