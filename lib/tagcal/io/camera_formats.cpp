#include <algorithm>
#include <ranges>

#include "tagcal/camera/model.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/formats/colmap.hpp"
#include "tagcal/io/formats/format_table.hpp"
#include "tagcal/io/formats/formats.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/formats/tagcal_format.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

bool is_truth(const YamlValue& top) {
  const auto camera = top.find("camera");
  return camera && camera->is_map() && camera->find("model") && camera->find("image_width") &&
         !top.find("target") && !top.find("boards");
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

CameraFile read_colmap_beside_images(const CameraText& cameras) {
  const auto beside = [&](const char* name) -> std::optional<ColmapText> {
    const fs::path file = cameras.path.parent_path() / name;
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return std::nullopt;
    return ColmapText{file.string(), read_text(file)};
  };
  return read_colmap({cameras.path.string(), cameras.text}, beside("images.txt"),
                     beside("rigs.txt"));
}

// intrinsics.yml of a stereo pair has its extrinsics.yml beside it.
CameraFile read_opencv_beside_extrinsics(const CameraText& file) {
  fs::path beside = file.path.parent_path() / "extrinsics";
  beside += file.path.extension();
  std::error_code error;
  if (!is_pair_without_place(*file.top) || !fs::is_regular_file(beside, error))
    return read_opencv(*file.top);
  return read_opencv(*file.top, parse_storage(read_text(beside), beside.string()));
}

template <CameraFile (*Read)(const YamlValue&)>
CameraFile by_keys(const CameraText& file) {
  return Read(*file.top);
}

template <FormatOutput (*Write)(const CameraFile&)>
FormatOutput by_content(const CameraFile& file, const fs::path& /*out*/) {
  return Write(file);
}

// The files of tagcal, OpenCV and ROS have the same keys, and one reader, in the row of OpenCV.
constexpr FormatRow kRows[] = {
    {.format = {.name = "tagcal",
                .program = "tagcal's calibration, of a camera or a rig; truth.yaml is read too",
                .lenses = "all of tagcal",
                .several = true,
                .file = "camera.yaml"},
     .key = "camera",
     .readers = {{{.has_keys = is_truth,
                   .read = [](const CameraText& file) { return read_truth_camera(file.path); }},
                  {.has_keys = has_rig_keys, .read = by_keys<read_rig_cameras>}}},
     .write = by_content<write_tagcal>,
     .any_unit = true},
    {.format = {.name = "opencv",
                .program = "cv::FileStorage: YAML, .xml, .json; a stereo pair is M1 D1 M2 D2 R T E "
                           "F in one file, or "
                           "a folder with intrinsics.yml and extrinsics.yml",
                .lenses = "4, 5 or 8 coefficients, fisheye (12 and 14 are read if the rest is 0)",
                .pair = true,
                .file = "camera_opencv.yaml",
                .ending = ".xml"},
     .key = "camera_matrix",
     .readers = {{{.has_keys = has_opencv_keys, .read = read_opencv_beside_extrinsics}}},
     .write =
         [](const CameraFile& file, const fs::path& out) {
           return write_opencv(file, storage_kind(out.extension().string()), names_folder(out));
         }},
    {.format =
         {.name = "kalibr",
          .program = "camchain.yaml",
          .lenses =
              "pinhole with radtan or equidistant (ds, eucm, omni without distortion: read only)",
          .several = true,
          .file = "camchain.yaml",
          .ending = "camchain.yaml"},
     .key = "cam0",
     .readers = {{{.has_keys = has_kalibr_keys, .read = by_keys<read_kalibr>}}},
     .write = by_content<write_kalibr>},
    {.format = {.name = "euroc",
                .program = "sensor.yaml with T_BS; of a rig a folder with x/sensor.yaml",
                .lenses = "as kalibr",
                .file = "sensor.yaml",
                .ending = "sensor.yaml",
                .each = "{}/sensor.yaml"},
     .readers = {{{.has_keys = has_euroc_keys, .read = by_keys<read_euroc>}}},
     .write = by_content<write_euroc>},
    {.format = {.name = "ros",
                .program = "camera_info YAML; ost.ini and the text of `ros2 topic echo` or "
                           "`rostopic echo` are read too",
                .lenses = "plumb_bob, rational_polynomial, equidistant",
                .file = "camera_info.yaml",
                .each = "{}.yaml",
                .rectified = true},
     .key = "distortion_model",
     .readers = {{{.has_text = is_ros_ini, .read = read_ros_ini},
                  {.has_text = is_ros_message, .read = read_ros_message}}},
     .write = by_content<write_ros>},
    {.format = {.name = "colmap",
                .program = "a folder with cameras.txt, images.txt, points3D.txt, and rigs.txt, "
                           "frames.txt, rig_config.json of a rig; or cameras.txt, or "
                           "rig_config.json; cameras.bin and images.bin are read too",
                .lenses = "PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE (SIMPLE_PINHOLE, "
                          "SIMPLE_RADIAL, RADIAL and their _FISHEYE are read too)",
                .several = true,
                .folder = true,
                .file = "cameras.txt",
                .ending = "cameras.txt"},
     .readers = {{{.has_text = is_colmap_cameras, .read = read_colmap_beside_images},
                  {.has_text = is_rig_config, .read = read_rig_config}}},
     .write =
         [](const CameraFile& file, const fs::path& out) {
           if (out.string().ends_with("rig_config.json")) return write_rig_config(file);
           return write_colmap(file, out.string().ends_with("cameras.txt"));
         },
     .any_unit = true},
    {.format = {.name = "mrcal",
                .program = "x.cameramodel; of a rig a folder with one for each camera",
                .lenses = "PINHOLE, OPENCV4, 5, 8 (12 is read without thin prism)",
                .file = "camera.cameramodel",
                .ending = ".cameramodel",
                .each = "{}.cameramodel"},
     .readers = {{{.has_text = is_mrcal_model, .read = read_mrcal}}},
     .write = by_content<write_mrcal>},
    {.format = {.name = "nerfstudio",
                .program = "transforms.json, of instant-ngp too",
                .lenses = "OPENCV, OPENCV_FISHEYE",
                .several = true,
                .file = "transforms.json",
                .ending = "transforms.json"},
     .key = "fl_x",
     .readers = {{{.has_keys = has_nerfstudio_keys, .read = read_nerfstudio}}},
     .write = by_content<write_nerfstudio>,
     .any_unit = true},
    {.format = {.name = "basalt",
                .program = "calibration.json",
                .lenses = "pinhole, pinhole-radtan8, kb4, ds, eucm (ucm: read only)",
                .several = true,
                .file = "calibration.json"},
     .key = "value0",
     .readers = {{{.has_keys = has_basalt_keys, .read = by_keys<read_basalt>}}},
     .write = by_content<write_basalt>},
    {.format = {.name = "wpilib",
                .program = "camera calibration.json of WPIcal",
                .lenses = "4, 5 or 8 coefficients",
                .file = "camera_calibration.json"},
     .readers = {{{.has_keys = has_wpilib_keys, .read = by_keys<read_wpilib>}}},
     .write = by_content<write_wpilib>},
    {.format = {.name = "mcap",
                .program = "a bag of Foxglove's messages CameraCalibration and FrameTransform, for "
                           "Foxglove and rerun; written only",
                .lenses = "as ros",
                .only_written = true,
                .file = "poses.mcap",
                .ending = ".mcap"},
     .write = by_content<write_mcap>},
    {.format = {.name = "tum",
                .program = "a trajectory; written only",
                .lenses = "none: poses only",
                .only_poses = true,
                .only_written = true,
                .file = "poses.tum",
                .ending = ".tum"},
     .write = by_content<write_tum>},
};

}  // namespace

namespace internal {

std::span<const FormatRow> format_rows() { return kRows; }

const FormatReader* reader_of(CameraText& file) {
  for (const FormatRow& row : format_rows())
    for (const FormatReader& reader : row.readers)
      if (reader.has_text && reader.has_text(file.text)) return &reader;
  file.top = parse_storage(file.text, file.path.string());
  for (const FormatRow& row : std::views::reverse(format_rows()))
    for (const FormatReader& reader : row.readers)
      if (reader.has_keys && reader.has_keys(*file.top)) return &reader;
  return nullptr;
}

}  // namespace internal

std::span<const CameraFormat> camera_formats() {
  static const std::vector<CameraFormat> formats = [] {
    std::vector<CameraFormat> all;
    for (const FormatRow& row : format_rows()) all.push_back(row.format);
    return all;
  }();
  return formats;
}

std::string_view format_of_name(const fs::path& file) {
  const std::string name = file.filename().string();
  for (const CameraFormat& format : camera_formats())
    if (!format.ending.empty() && name.ends_with(format.ending)) return format.name;
  return "";
}

}  // namespace tagcal
