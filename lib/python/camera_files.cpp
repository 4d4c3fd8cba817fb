#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <map>
#include <variant>

#include "python/arrays.hpp"
#include "python/camera.hpp"
#include "python/files.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/text_file.hpp"

// Files of cameras, of tagcal and of other programs.

namespace tagcal::python {

template <>
inline constexpr bool kHasNoState<CameraFormat> = true;  // a row of a table
namespace {

namespace fs = std::filesystem;
using Poses = std::map<std::string, Pose>;

CalibrationFile camera_of_file(const fs::path& file) {
  CameraFile content;
  {
    py::gil_scoped_release release;
    content = read_one_camera(file.string());
  }
  warn(content.notes);
  return usable_camera(content, file.string());
}

CameraFile cameras_of_file(const fs::path& file) {
  py::gil_scoped_release release;
  std::error_code error;
  if (fs::exists(file, error)) return read_camera_file(file);
  return read_one_camera(file.string());
}

std::string formats_text() {
  std::string text;
  for (const CameraFormat& known : camera_formats())
    text += (text.empty() ? "\"" : ", \"") + std::string(known.name) + "\"";
  return text;
}

// The format that was named, or that the file's name stands for; YAML is tagcal's.
std::string format_for(const fs::path& file, const std::optional<std::string>& format) {
  check_path(file, "file");
  if (format) {
    if (std::ranges::count(camera_formats(), *format, &CameraFormat::name) == 0)
      throw Error("format: must be one of " + formats_text() + ", got \"" + *format + "\"");
    return *format;
  }
  const std::string by_name(format_of_name(file));
  if (!by_name.empty()) return by_name;
  if (file.extension() == ".yaml" || file.extension() == ".yml") return "tagcal";
  throw Error("format: is needed, as the name " + file.filename().string() +
              " stands for none: one of " + formats_text());
}

void check_finite(const Pose& pose, const std::string& name) {
  if (!pose.matrix().allFinite()) throw Error(name + ": must be a finite pose");
}

FileCamera make_file_camera(const CameraLike& camera, const std::string& name,
                            const PoseLike& camera_from_rig) {
  FileCamera made{name, known_camera(camera, "camera")};
  if (!camera_from_rig.is_none())
    made.camera_from_rig = pose_of(camera_from_rig, "camera_from_rig");
  return made;
}

CameraFile make_camera_file(std::vector<FileCamera> cameras, std::vector<ImagePose> poses) {
  if (cameras.empty()) throw Error("cameras: must have one");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string name = "poses[" + std::to_string(i) + "]";
    if (poses[i].camera >= cameras.size())
      throw Error(name + ": has camera " + std::to_string(poses[i].camera) + " of " +
                  std::to_string(cameras.size()));
    check_finite(poses[i].camera_from_world, name);
  }
  return {"tagcal", std::move(cameras), std::move(poses), {}};
}

void check_sizes(const CameraFile& file, const std::string& format) {
  const auto* const known = &*std::ranges::find(camera_formats(), format, &CameraFormat::name);
  for (const FileCamera& camera : file.cameras)
    if (!known->only_poses && camera.calibration.camera.image_size == ImageSize{})
      throw Error("camera: the image size of \"" + camera.name +
                  "\" is not known: set it by with_size((width, height))");
}

std::vector<std::string> write_cameras(const fs::path& file, const CameraFile& cameras,
                                       const std::optional<std::string>& format) {
  const std::string known = format_for(file, format);
  check_sizes(cameras, known);
  py::gil_scoped_release release;
  return write_camera_file(file, cameras, known);
}

std::vector<std::string> write_camera(const fs::path& file, const CameraLike& camera,
                                      const std::optional<std::string>& format,
                                      const Poses& poses) {
  const std::string known = format_for(file, format);
  const CalibrationFile content = known_camera(camera, "camera");
  if (known == "tagcal" && py::isinstance<Calibration>(camera)) {
    const Calibration& calibration = py::cast<const Calibration&>(camera);
    if (!poses.empty()) throw Error("poses: a calibration has its own");
    py::gil_scoped_release release;
    write_whole(file, calibration_yaml(calibration));
    return {};
  }
  std::vector<ImagePose> image_poses;
  for (const auto& [image, pose] : poses) image_poses.push_back({image, 0, pose});
  const CameraFile cameras = make_camera_file({{"", content}}, std::move(image_poses));
  check_sizes(cameras, known);
  py::gil_scoped_release release;
  return write_camera_file(file, cameras, known);
}

std::string yaml_of(const Calibration& calibration) {
  known_camera(calibration);  // throws without an answer
  return calibration_yaml(calibration);
}

FileCamera with_size(const FileCamera& camera, const ArrayLike& size) {
  FileCamera changed = camera;
  changed.calibration.camera.image_size = size_of_argument(size, "size");
  return changed;
}

std::string file_camera_text(const FileCamera& camera) {
  const Lens& lens = camera.calibration.camera.lens;
  const ImageSize& size = camera.calibration.camera.image_size;
  return "\"" + camera.name + "\" " + std::string(kind_of(lens).name) + ", " +
         (size == ImageSize{} ? "size unknown" : size_text(size)) + ", " +
         std::string(parameter_names(lens)[0]) + " " + number(parameters(lens)[0]);
}

void bind_file_camera(py::module_& m) {
  Record<FileCamera>(m, "FileCamera", "One camera of a file of any program.")
      .field("name", &FileCamera::name, "In the file, such as \"cam0\"; may be empty.")
      .field("calibration", &FileCamera::calibration,
             "The UncertainCamera, which has what the file knows of it; its size is (0, 0) if that "
             "is not in the file.")
      .field("camera_from_rig", &FileCamera::camera_from_rig,
             "The Pose of the camera in its rig; None: not in the file.")
      .representation(&file_camera_text)
      .def(py::init(&make_file_camera), py::arg("camera"), py::arg("name") = "",
           py::arg("camera_from_rig") = py::none(),
           "Of a Camera, an UncertainCamera or a Calibration.")
      .def("with_size", &with_size, py::arg("size"),
           "The same with the size (width, height) of its pictures, for files without it.");
}

void bind_camera_file(py::module_& m) {
  Record<ImagePose>(m, "ImagePose", "Where a camera was when it took a picture.")
      .field("image", &ImagePose::image, "The name of the picture.")
      .field("camera", &ImagePose::camera, "The number of the camera in its file.")
      .field("camera_from_world", &ImagePose::camera_from_world, "The Pose.")
      .field("time_s", &ImagePose::time_s,
             "Unix time, or since the first frame of a video; None: not known.")
      .field("findings", &ImagePose::findings, "Of the pose: `write_camera` to MCAP has them.")
      .representation([](const ImagePose& pose) { return "\"" + pose.image + "\""; })
      .def(py::init([](const std::string& image, const PoseLike& pose, std::size_t camera,
                       const std::optional<double>& time_s) {
             return ImagePose{image, camera, pose_of(pose, "camera_from_world"), time_s};
           }),
           py::arg("image"), py::arg("camera_from_world"), py::arg("camera") = 0,
           py::arg("time_s") = py::none());
  Record<CameraFile>(m, "CameraFile", "What a file of cameras holds.")
      .field("format", &CameraFile::format, "A name of `camera_formats()`.")
      .field("cameras", &CameraFile::cameras, "One FileCamera or more.")
      .field("poses", &CameraFile::poses, "Of its pictures; empty: not in the file.")
      .field("notes", &CameraFile::notes, "What was changed or dropped, a sentence each.")
      .representation([](const CameraFile& file) {
        return file.format + ", " + counted(file.cameras.size(), "camera") + ", " +
               counted(file.poses.size(), "pose") +
               (file.notes.empty() ? "" : ", " + counted(file.notes.size(), "note"));
      })
      .def(py::init(&make_camera_file), py::arg("cameras"),
           py::arg("poses") = std::vector<ImagePose>(), "For `write_camera`.");
  Record<CameraFormat>(m, "CameraFormat", "A format of files of cameras.")
      .field("name", &CameraFormat::name, "Such as \"opencv\": the argument `format`.")
      .field("program", &CameraFormat::program, "The program, and its file.")
      .field("lenses", &CameraFormat::lenses, "That are read and written.")
      .field("several", &CameraFormat::several, "True if a file holds several cameras.")
      .field("only_written", &CameraFormat::only_written, "True if files of it are not read.")
      .representation([](const CameraFormat& f) { return std::string(f.name); });
}

}  // namespace

void bind_camera_files(py::module_& m) {
  bind_file_camera(m);
  bind_camera_file(m);
  m.def(
      "camera_formats",
      [] {
        const auto formats = camera_formats();
        return std::vector<CameraFormat>(formats.begin(), formats.end());
      },
      "The formats that cameras are read and written in.");
  m.def("read_camera", &camera_of_file, py::arg("file"),
        "The camera of a file of tagcal or of another program, which is recognised by its content, "
        "with what the file knows of it. \"FILE:NAME\" chooses one of several. What was changed "
        "or dropped is a warning (UserWarning). Raises Error for a lens of other tools and a file "
        "without the image's size, which `read_cameras` reads.");
  m.def("read_cameras", &cameras_of_file, py::arg("file"),
        "All cameras of a file, their poses, and notes on what was changed or dropped.");
  m.def("write_camera", &write_cameras, py::arg("file"), py::arg("camera"),
        py::arg("format") = py::none(), "The same for several cameras, as `read_cameras` returns.");
  m.def("write_camera", &write_camera, py::arg("file"), py::arg("camera"),
        py::arg("format") = py::none(), py::arg("poses") = Poses(),
        "Writes a Camera, an UncertainCamera or a Calibration, whole or not at all, and returns "
        "notes: what was changed or dropped. `format`: a name of `camera_formats()`; None: by the "
        "file's name (.yaml: tagcal, which OpenCV reads too). `poses`: camera_from_world by the "
        "name of an image, for formats that hold them.");
  m.def("calibration_yaml", &yaml_of, py::arg("calibration"),
        "The text of the file that write_camera writes for a Calibration. Raises Error without an "
        "answer.");
  m.def(
      "read_poses",
      [](const fs::path& file) {
        py::gil_scoped_release release;
        return read_poses(file);
      },
      py::arg("file"), "The poses of the output of `tagcal pose --json`, for `CameraFile`.");
}

}  // namespace tagcal::python
