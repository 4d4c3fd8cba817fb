#include "python/files.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <utility>
#include <variant>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/sequence_file.hpp"
#include "tagcal/io/target_file.hpp"

// Files of pictures, targets and scenes.

namespace tagcal::python {

namespace fs = std::filesystem;

void warn(const std::vector<std::string>& remarks) {
  for (const std::string& remark : remarks)
    if (PyErr_WarnEx(PyExc_UserWarning, remark.c_str(), 1) != 0) throw py::error_already_set();
}

void check_path(const fs::path& file, const char* name) {
  if (file.empty()) throw Error(std::string(name) + ": must be the path of a file, got \"\"");
}

namespace {

using AnyPictureArray = std::variant<py::array_t<std::uint8_t>, py::array_t<std::uint16_t>>;

py::array_t<std::uint8_t> read_grey(const fs::path& file) {
  Image8 image;
  {
    py::gil_scoped_release release;
    image = read_image(file);
  }
  return array_of(image);
}

// As a variant, so that the types of Python name both.
AnyPictureArray read_any(const fs::path& file) {
  Picture picture;
  {
    py::gil_scoped_release release;
    picture = read_picture(file);
  }
  const py::array array = array_of(picture);
  if (array.itemsize() == 1) return py::array_t<std::uint8_t>(array);
  return py::array_t<std::uint16_t>(array);
}

std::pair<int, int> size_of_file(const fs::path& file) {
  py::gil_scoped_release release;
  const ImageSize size = read_image_size(file);
  return {size.width, size.height};
}

std::vector<std::string> pictures_of_folder(const fs::path& folder) {
  py::gil_scoped_release release;
  std::vector<std::string> files;
  for (const fs::path& file : list_pictures(folder)) files.push_back(file.string());
  return files;
}

void write_image(const fs::path& file, const ArrayLike& image) {
  const Picture picture = picture_of(image, "image");
  py::gil_scoped_release release;
  write_picture(file, picture);
}

constexpr int kLargestId = 1 << 24;  // numeric: more ids than any family has; sums stay in an int

Board target_of_file(const fs::path& file, const std::optional<int>& first_id,
                     const std::optional<double>& tag_size_m) {
  if (first_id && (*first_id < 0 || *first_id > kLargestId))
    throw Error("first_id: must be >= 0, got " + std::to_string(*first_id));
  if (tag_size_m && !(*tag_size_m > 0 && *tag_size_m < 1e6))  // numeric: finite
    throw Error("tag_size_m: must be > 0, got " + internal::short_number(*tag_size_m));
  std::vector<std::string> warnings;
  Board board;
  {
    py::gil_scoped_release release;
    board = read_target(file, first_id, &warnings, tag_size_m);
  }
  warn(warnings);
  return board;
}

void write_board(const fs::path& file, const Board& board) {
  check_path(file, "file");
  py::gil_scoped_release release;
  write_target(file, board);
}

MovingScene scene_of_file(const fs::path& file) {
  std::vector<std::string> warnings;
  MovingScene scene;
  {
    py::gil_scoped_release release;
    scene = read_moving_scene(file, &warnings);
  }
  warn(warnings);
  return scene;
}

}  // namespace

void bind_picture_files(py::module_& m) {
  m.def("read_image", &read_grey, py::arg("file"),
        "The picture of a PNG, JPEG, TIFF, BMP, WebP, PGM or PPM file as grey, (height, width), "
        "uint8. Colour becomes grey by Rec. 601; 16-bit values are scaled. It is turned as its "
        "Exif tag says.");
  m.def("read_picture", &read_any, py::arg("file"),
        "The same in its own kind: (height, width), or (height, width, 3) with red first; uint8, "
        "or uint16 as stored.");
  m.def("read_image_size", &size_of_file, py::arg("file"),
        "(width, height) of the picture that read_image returns, from the file's header.");
  m.def("list_pictures", &pictures_of_folder, py::arg("folder"),
        "The paths of a folder's pictures, by the ends of their names, sorted by name.");
  Record<ImageSequence>(m, "ImageSequence",
                        "What a video or a bag says of its frames; `read_sequence`.")
      .field("image_size", &ImageSequence::size,
             "(width, height) of a frame, turned as a video says.")
      .field("times_s", &ImageSequence::times_s, "Of each frame, from the first one on.")
      .field("start_s", &ImageSequence::start_s, "The Unix time of the first frame; 0: not known.")
      .field("is_interlaced", &ImageSequence::is_interlaced,
             "Odd and even rows were taken at different times.")
      .field("is_uneven", &ImageSequence::is_uneven,
             "Frames do not follow one another at equal times.")
      .field("is_cut_off", &ImageSequence::is_cut_off,
             "The file ends within a frame; those until there are read.");
  m.def("read_sequence", &read_sequence, py::arg("file"), py::call_guard<py::gil_scoped_release>(),
        "The size and the times of the frames of a video (MP4, MOV, AVI, Matroska, WebM, MJPEG) or "
        "of a bag's topic (\"a.bag:/topic\", .mcap, .db3). Frame 123 is the picture "
        "\"clip.mp4@000123\" for all functions that take files.");
  m.def("write_picture", &write_image, py::arg("file"), py::arg("image"),
        "Writes a picture, (height, width) or (height, width, 3) with red first, uint8 or uint16, "
        "whole or not at all, as the name ends: .png, .tif, .tiff, .jpg, .jpeg (8-bit), .pgm "
        "(grey), .ppm.");
}

void bind_files(py::module_& m) {
  bind_picture_files(m);
  m.def("read_target", &target_of_file, py::arg("file"), py::arg("first_id") = py::none(),
        py::arg("tag_size_m") = py::none(),
        "The board of a target file (Kalibr's YAML, tagcal's, or WPILib's JSON of a field). "
        "`first_id` overrides the file's; `tag_size_m` is for a field only. Warns of unknown keys "
        "(UserWarning).");
  m.def("write_target", &write_board, py::arg("file"), py::arg("board"),
        "Writes a target file, whole or not at all.");
  m.def("read_scene", &scene_of_file, py::arg("file"),
        "The scene of a recipe for `render`. Warns of unknown keys in target files "
        "(UserWarning).");
  bind_camera_files(m);
  bind_dataset_files(m);
}

}  // namespace tagcal::python
