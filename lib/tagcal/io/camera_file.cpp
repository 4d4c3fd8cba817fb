#include "tagcal/io/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>

#include "tagcal/camera/model.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/formats/basalt_format.hpp"
#include "tagcal/io/formats/colmap_format.hpp"
#include "tagcal/io/formats/kalibr_format.hpp"
#include "tagcal/io/formats/mrcal_format.hpp"
#include "tagcal/io/formats/nerfstudio_format.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/formats/opencv_xml.hpp"
#include "tagcal/io/formats/tagcal_format.hpp"
#include "tagcal/io/formats/tum_format.hpp"
#include "tagcal/io/text/folder_lock.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text/number_text.hpp"
#include "tagcal/io/text/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

std::string format_names() {
  std::string names;
  for (const CameraFormat& format : camera_formats())
    names += (names.empty() ? "" : ", ") + std::string(format.name);
  return names;
}

// Kinds of files that are read. The kind of a file with keys is known by a key that it must have.
enum class FileKind { opencv, xml, kalibr, euroc, colmap, mrcal, nerfstudio, basalt, truth, none };

// Throws Error, with the name of the lens, for a CAHVOR file of JPL.
void refuse_cahvor(const std::string& text, const std::string& name) {
  const std::size_t at = text.substr(0, 4096).find("Model = CAHV");
  if (at == std::string::npos) return;
  const std::size_t begin = at + 8, end = text.find_first_of(" =\r\n", begin);
  throw Error(fmt::format("{}: Model: the lens {} is one that tagcal does not have", name,
                          shown(text.substr(begin, end - begin))));
}

bool is_truth(const YamlValue& top) {
  const auto camera = top.find("camera");
  return camera && camera->is_map() && camera->find("model") && camera->find("image_width") &&
         !top.find("target") && !top.find("boards");
}

bool has_frames(const YamlValue& top) {
  if (top.find("fl_x") || top.find("camera_angle_x")) return true;
  const auto frames = top.find("frames");
  if (!frames || !frames->is_list()) return false;
  const std::vector<YamlValue> items = frames->items(0, limits::kMaxListedPoses);
  return !items.empty() && items[0].is_map() && items[0].find("transform_matrix");
}

FileKind kind_of(const YamlValue& top) {
  if (top.find("value0")) return FileKind::basalt;
  if (const auto cam0 = top.find("cam0"); cam0 && cam0->is_map()) return FileKind::kalibr;
  if (top.find("camera_model") && top.find("intrinsics")) return FileKind::euroc;
  if (is_truth(top)) return FileKind::truth;
  if (has_frames(top)) return FileKind::nerfstudio;
  for (const std::string_view key :
       {"camera_matrix", "Camera_Matrix", "cameraMatrix", "image_width", "image_height",
        "distortion_coefficients", "M1"})
    if (top.find(key)) return FileKind::opencv;
  return FileKind::none;
}

FileKind kind_of(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && text[first] == '<') return FileKind::xml;
  if (is_mrcal_model(text)) return FileKind::mrcal;
  if (is_colmap_cameras(text)) return FileKind::colmap;
  return FileKind::none;
}

// Numbers of pinhole cameras that differ from view to view have no place in a camera.
CameraFile read_truth_camera(const fs::path& path) {
  const Truth truth = read_truth(path);
  CameraFile file;
  file.format = "tagcal";
  FileCamera camera = file_camera("", truth.camera.lens, truth.camera.image_size);
  const bool is_model =
      std::ranges::any_of(Model::all(), [&](const Model& m) { return m.name() == truth.model; });
  if (is_model) camera.calibration.model = truth.model;
  file.cameras.push_back(std::move(camera));
  for (const auto& [image, pose] : truth.camera_from_world) file.poses.push_back({image, 0, pose});
  if (!truth.lenses.empty())
    file.notes.emplace_back("dropped: the lenses of single views, which differ in this file");
  return file;
}

CameraFile read_keys(const YamlValue& top, const fs::path& path) {
  switch (kind_of(top)) {
    case FileKind::basalt:
      return read_basalt(top);
    case FileKind::kalibr:
      return read_kalibr(top);
    case FileKind::euroc:
      return read_euroc(top);
    case FileKind::nerfstudio:
      return read_nerfstudio(top);
    case FileKind::truth:
      return read_truth_camera(path);
    case FileKind::opencv:
      return read_opencv(top);
    default:
      break;
  }
  top.fail_plainly(
      "is no camera's file: it has neither camera_matrix (tagcal, opencv, ros), cam0 "
      "(kalibr), value0 (basalt), fl_x (nerfstudio) nor camera (truth.yaml)");
}

std::optional<ColmapText> images_beside(const fs::path& cameras) {
  const fs::path images = cameras.parent_path() / "images.txt";
  std::error_code error;
  if (!fs::is_regular_file(images, error)) return std::nullopt;
  return ColmapText{images.string(), read_text(images)};
}

CameraFile read_folder(const fs::path& folder) {
  std::error_code error;
  const fs::path cameras = folder / "cameras.txt";
  if (fs::is_regular_file(cameras, error))
    return read_colmap({cameras.string(), read_text(cameras)}, images_beside(cameras));
  for (const char* const name : {"truth.yaml", "transforms.json"})
    if (fs::is_regular_file(folder / name, error)) return read_camera_file(folder / name);
  const bool binary = fs::is_regular_file(folder / "cameras.bin", error);
  throw Error(fmt::format("{}: {}", folder.string(),
                          binary ? "has a binary model of COLMAP only: colmap model_converter "
                                   "--output_type TXT writes the text that is read"
                                 : "is a folder without cameras.txt, truth.yaml or "
                                   "transforms.json"));
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

void write_files(const fs::path& out, const FormatOutput& output) {
  const bool folder = !output.files.front().name.empty();
  std::error_code error;
  if (folder) fs::create_directories(out, error);
  if (error) throw Error(out.string() + ": cannot make the folder: " + error.message());
  // The files belong together: those of another process come before or after all of them.
  std::optional<FolderLock> lock;
  if (folder) lock.emplace(out, std::chrono::seconds(10));
  if (folder) keep_points_of_others(out, output);
  for (const OutputText& file : output.files)
    write_whole(folder ? out / file.name : out, file.text);
}

FormatOutput formatted(const fs::path& out, const CameraFile& file, std::string_view format) {
  if (format == "tagcal") return write_tagcal(file);
  if (format == "opencv") return write_opencv(file, storage_kind(out.extension().string()));
  if (format == "kalibr") return write_kalibr(file);
  if (format == "ros") return write_ros(file);
  if (format == "colmap") return write_colmap(file, out.filename() == "cameras.txt");
  if (format == "mrcal") return write_mrcal(file);
  if (format == "nerfstudio") return write_nerfstudio(file);
  if (format == "basalt") return write_basalt(file);
  if (format == "tum") return write_tum(file);
  throw Error(fmt::format("{}: is no format that is known: {}", shown(format), format_names()));
}

// The poses of one camera, which becomes the only one.
CameraFile only(CameraFile file, std::size_t camera) {
  std::erase_if(file.poses, [&](const ImagePose& pose) { return pose.camera != camera; });
  for (ImagePose& pose : file.poses) pose.camera = 0;
  file.cameras = {file.cameras[camera]};
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

CameraFile read_camera_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return read_folder(path);
  const std::string name = path.string();
  const std::string text = read_text(path);
  refuse_cahvor(text, name);
  switch (kind_of(text)) {
    case FileKind::xml:
      return read_keys(YamlValue::of(parse_opencv_xml(text, name), name), path);
    case FileKind::mrcal:
      return read_mrcal(text, name);
    case FileKind::colmap:
      return read_colmap({name, text}, images_beside(path));
    default:
      return read_keys(YamlValue::parse(text, name), path);
  }
}

CameraFile read_one_camera(const std::string& file_and_name) {
  const std::size_t colon = colon_before_name(file_and_name);
  const bool named = colon != std::string::npos;
  const std::string path = named ? file_and_name.substr(0, colon) : file_and_name;
  const std::string name = named ? file_and_name.substr(colon + 1) : "";
  const CameraFile file = read_camera_file(path);
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
  if (camera.foreign_lens)
    throw Error(
        fmt::format("{}: the lens is a {} one, which tagcal only converts: tagcal convert "
                    "{} camera.yaml --to tagcal --model fisheye4",
                    name, lens_name(*camera.foreign_lens), name));
  if (std::holds_alternative<Parallel>(camera.calibration.camera.lens))
    throw Error(name + ": a parallel camera has no focal length, which is needed here");
  if (camera.calibration.camera.image_size == ImageSize{})
    throw Error(
        fmt::format("{}: image_width: the key is missing: tagcal convert {} camera.yaml "
                    "--to tagcal --image-size WIDTHxHEIGHT adds it",
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
    if (pose && (pose->is_map() || pose->is_list())) poses.push_back({image, 0, read_pose(*pose)});
  }
  if (poses.empty()) top.at("views").fail_plainly("has no view with a pose, camera_from_board");
  return poses;
}

bool is_camera_file(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return fs::is_regular_file(path / "cameras.txt", error);
  const std::string text = read_text(path);
  if (kind_of(text) != FileKind::none) return true;
  return kind_of(YamlValue::parse(text, path.string())) != FileKind::none;
}

std::vector<std::string> write_camera_file(const fs::path& out, const CameraFile& file,
                                           std::string_view format) {
  for (const FileCamera& camera : file.cameras) {
    if (format == "tum" || camera.calibration.camera.image_size != ImageSize{}) continue;
    throw Error(out.string() + ": the image size is not known: give it by --image-size");
  }
  try {
    const FormatOutput output = formatted(out, file, format);
    write_files(out, output);
    return output.notes;
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.starts_with(out.string())) throw;
    throw Error(out.string() + ": " + message);
  }
}

}  // namespace tagcal
