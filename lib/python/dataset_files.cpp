#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <set>

#include "python/boards.hpp"
#include "python/files.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/corners_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/text_file.hpp"

// Files of data sets: folders, corners, truth.

namespace tagcal::python {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_of(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.string());
  return names;
}

DatasetFolder dataset_of_folder(const fs::path& folder) {
  py::gil_scoped_release release;
  return read_dataset(folder);
}

// Throws Error for views that a table by names of images cannot tell apart. Returns a note on
// those that it cannot hold.
std::vector<std::string> check_table(const std::vector<View>& views, const std::string& name) {
  std::set<std::string> images;
  std::size_t empty = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!images.insert(views[v].image).second)
      throw Error(name + "[" + std::to_string(v) + "]: two views have the image \"" +
                  views[v].image + "\", which tells them apart in the file");
    empty += views[v].observations.empty();
  }
  if (empty == 0) return {};
  return {"dropped: " + std::to_string(empty) + (empty == 1 ? " view" : " views") +
          " without corners"};
}

std::vector<std::string> write_folder(const fs::path& folder, const Dataset& dataset,
                                      const std::string& images) {
  check_path(folder, "folder");
  const std::vector<std::string> notes = check_table(dataset.views, "views");
  const bool has_views = !dataset.views.empty() || images.empty();
  py::gil_scoped_release release;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(folder.string() + ": cannot make the folder: " + error.message());
  constexpr const char* kFile = "observations.csv";
  if (has_views) write_whole(folder / kFile, observations_csv(dataset.views));
  write_dataset(folder, dataset, images, has_views ? kFile : "");
  return notes;
}

std::vector<View> views_of_file(const fs::path& file, const TargetLike& target) {
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  std::vector<std::string> notes;
  std::vector<View> views;
  {
    py::gil_scoped_release release;
    views = read_observations(file, boards, &notes);
  }
  warn(notes);
  return views;
}

std::vector<std::string> write_views(const fs::path& file, const std::vector<View>& views,
                                     const TargetLike& target,
                                     const std::optional<std::string>& format) {
  check_path(file, "file");
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  const std::string known = format.value_or(std::string(corners_format_of_name(file)));
  if (known != "tagcal" && known != "mrcal" && known != "opencv")
    throw Error(
        "format: must be \"tagcal\" (.csv), \"mrcal\" (.vnl) or \"opencv\" (.yaml, .xml, "
        ".json), got " +
        (format ? "\"" + *format + "\"" : "the name " + file.filename().string()));
  const auto points = points_in_world(boards);
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const Observation& seen : views[v].observations)
      if (!points.contains(seen.id))
        throw Error("views[" + std::to_string(v) + "]: has the corner (" +
                    std::to_string(seen.id.tag_id) + ", " + std::to_string(seen.id.corner) +
                    "), which the target does not have");
  std::vector<std::string> notes = check_table(views, "views");
  if (known != "tagcal") notes.clear();
  py::gil_scoped_release release;
  const std::vector<std::string> dropped = write_corners(file, views, boards, known);
  notes.insert(notes.end(), dropped.begin(), dropped.end());
  return notes;
}

// A Dataset from a folder, so that functions of a data set take what read_dataset returns.
void make_convertible() {
  auto dataset = py::reinterpret_borrow<py::class_<Dataset>>(py::type::of<Dataset>());
  dataset.def(py::init([](const DatasetFolder& folder) { return folder.dataset; }),
              py::arg("folder"), "That of a folder, as `read_dataset` returns it.");
  py::implicitly_convertible<DatasetFolder, Dataset>();
}

void bind_folder(py::module_& m) {
  Record<DatasetFolder>(m, "DatasetFolder", "A data set on disk.")
      .field("dataset", &DatasetFolder::dataset,
             "The Dataset, for `calibrate`; without views if there are only images.")
      .field(
          "observations",
          [](const DatasetFolder& f) {
            return f.observations.empty() ? std::nullopt : std::optional(f.observations.string());
          },
          "The file of its views; None: there is none.")
      .field(
          "images", [](const DatasetFolder& f) { return names_of(f.images); },
          "The files of its pictures, sorted by name.")
      .field("unreadable", &DatasetFolder::unreadable,
             "Pictures that are not in `images`: file and reason.")
      .field(
          "depths", [](const DatasetFolder& f) { return names_of(f.depths); },
          "The files of its depths, sorted by name.")
      .field("depth_unit_m", &DatasetFolder::depth_unit_m, "Of their values; 0: no depths.")
      .field("warnings", &DatasetFolder::warnings, "Sentences.")
      .representation([](const DatasetFolder& f) {
        const std::size_t n = f.warnings.size(), out = f.unreadable.size();
        return std::to_string(f.dataset.views.size()) + " views, " +
               std::to_string(f.images.size()) + " images" +
               (out == 0 ? "" : ", " + std::to_string(out) + " unreadable") +
               and_counted(n, "warning");
      });
  make_convertible();
}

}  // namespace

void bind_dataset_files(py::module_& m) {
  bind_folder(m);
  m.def("read_dataset", &dataset_of_folder, py::arg("folder"),
        "The data set of a folder with dataset.yaml: its target, views and truth are in "
        "`.dataset`; pictures that cannot be opened are named in `unreadable`, remarks in "
        "`warnings`.");
  m.def("write_dataset", &write_folder, py::arg("folder"), py::arg("dataset"),
        py::arg("images") = "",
        "Writes dataset.yaml, the target's files, observations.csv, and truth.yaml if the truth is "
        "known. `images`: the folder of its pictures, relative to this one. Returns notes: what "
        "was dropped.");
  m.def("read_observations", &views_of_file, py::arg("file"), py::arg("target"),
        "The views of a file of corners: tagcal's CSV, mrcal's corners.vnl or OpenCV's "
        "image_points, by their content. Remarks on the last two are warnings (UserWarning).");
  m.def("write_corners", &write_views, py::arg("file"), py::arg("views"), py::arg("target"),
        py::arg("format") = py::none(),
        "Writes views as \"tagcal\" (CSV), \"mrcal\" (vnl) or \"opencv\" (image_points; one "
        "checkerboard or list of points); None: by the file's name. Returns notes: what was "
        "dropped.");
  m.def(
      "read_truth",
      [](const fs::path& file) {
        py::gil_scoped_release release;
        return read_truth(file);
      },
      py::arg("file"), "The true camera and poses of truth.yaml.");
  m.def(
      "write_truth",
      [](const fs::path& file, const Truth& truth) {
        check_path(file, "file");
        py::gil_scoped_release release;
        write_truth(file, truth);
      },
      py::arg("file"), py::arg("truth"), "Writes truth.yaml, whole or not at all.");
}

}  // namespace tagcal::python
