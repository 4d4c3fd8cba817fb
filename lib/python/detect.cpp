#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <deque>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/boards.hpp"
#include "python/detect_options.hpp"
#include "python/grey_image.hpp"
#include "python/records.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/explain.hpp"
#include "tagcal/detect/refine_views.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {

DetectOptions detect_options(const std::optional<Camera>& camera, const std::string& refinement,
                             int max_hamming, int threads) {
  DetectOptions options;
  if (camera) options.camera = &*camera;
  if (refinement == "stock")
    options.refinement = Refinement::stock;
  else if (refinement == "edges")
    options.refinement = Refinement::edges;
  else if (refinement != "fit")
    throw Error("refinement: must be fit, edges or stock, got \"" + refinement + "\"");
  if (max_hamming < 0 || max_hamming > 2)
    throw Error("max_hamming: must be 0, 1 or 2, got " + std::to_string(max_hamming));
  options.max_hamming = max_hamming;
  check_threads(threads);
  options.threads = threads;
  return options;
}

namespace {

// A view with all that its search said.
struct DetectedView : View {
  std::vector<UnfittedTag> unfitted;
  std::vector<std::string> warnings;
  std::string unreadable;
};

struct DetectedViews {
  std::vector<DetectedView> views;
  std::vector<std::string> warnings;  // of all pictures together first, then of each
};

}  // namespace

template <>
inline constexpr auto kMembers<DetectedView> = std::tuple(&View::image, &View::observations,
                                                          &DetectedView::unfitted,
                                                          &DetectedView::warnings,
                                                          &DetectedView::unreadable);

namespace {

// The boards of a target that can be searched for.
std::vector<PlacedBoard> detectable_boards(const TargetLike& target) {
  std::vector<PlacedBoard> boards = boards_of(target, "target");
  const auto can_be_seen = [](const PlacedBoard& placed) {
    return point_kind(placed.board) != PointKind::measured;
  };
  if (std::ranges::none_of(boards, can_be_seen))
    throw Error("target: has no tags, squares or circles to detect, only points");
  return boards;
}

// Pictures to be searched. Their addresses do not change.
class Batch {
 public:
  Batch(const std::vector<ImageLike>& images,
        const std::optional<std::vector<std::string>>& names) {
    if (names) check_same_length(images.size(), "images", names->size(), "names");
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::string place = "images[" + std::to_string(i) + "]";
      images_.emplace_back(images[i], place);
      const std::string file = images_.back().file_name();
      sources_.push_back(images_.back().source(names ? (*names)[i] : file.empty() ? place : file));
    }
  }
  Batch(const ImageLike& image, const std::optional<std::string>& name) {
    images_.emplace_back(image, "image");
    const std::string file = images_.back().file_name();
    sources_.push_back(images_.back().source(name.value_or(file.empty() ? "picture" : file)));
  }

  const std::vector<ImageSource>& sources() const { return sources_; }

 private:
  std::deque<GreyImage> images_;
  std::vector<ImageSource> sources_;
};

// Without the GIL.
DetectedViews detect_batch(const std::vector<ImageSource>& sources,
                           const std::vector<PlacedBoard>& boards, const DetectOptions& options) {
  DetectedViews found;
  std::vector<DetectedPicture> pictures = detect_all(sources, boards, options);
  found.warnings = board_warnings(boards, target_mistakes(sources, pictures, boards, options));
  for (DetectedPicture& picture : pictures) {
    found.warnings.insert(found.warnings.end(), picture.warnings.begin(), picture.warnings.end());
    found.views.push_back({std::move(picture.view), std::move(picture.unfitted),
                           std::move(picture.warnings), std::move(picture.unreadable)});
  }
  return found;
}

DetectedViews detect_many(const std::vector<ImageLike>& images, const TargetLike& target,
                          const std::optional<Camera>& camera,
                          const std::optional<std::vector<std::string>>& names,
                          const std::string& refinement, int max_hamming, bool skip_unreadable,
                          int threads) {
  const std::vector<PlacedBoard> boards = detectable_boards(target);
  DetectOptions options = detect_options(camera, refinement, max_hamming, threads);
  options.skip_unreadable = skip_unreadable;
  const Batch batch(images, names);
  py::gil_scoped_release release;
  return detect_batch(batch.sources(), boards, options);
}

std::vector<View> refine_again(const std::vector<ImageLike>& images, const Dataset& dataset,
                               const Camera& camera,
                               const std::optional<std::vector<std::string>>& names, int threads) {
  const Batch batch(images, names);
  py::gil_scoped_release release;
  return refine_views(dataset, batch.sources(), camera, threads).views;
}

DetectedView detect_one(const ImageLike& image, const TargetLike& target,
                        const std::optional<Camera>& camera, const std::optional<std::string>& name,
                        const std::string& refinement, int max_hamming) {
  const std::vector<PlacedBoard> boards = detectable_boards(target);
  const DetectOptions options = detect_options(camera, refinement, max_hamming, 1);
  const Batch batch(image, name);
  py::gil_scoped_release release;
  DetectedViews found = detect_batch(batch.sources(), boards, options);
  found.views.front().warnings = std::move(found.warnings);
  return std::move(found.views.front());
}

void bind_views(py::module_& m) {
  Record<UnfittedTag>(m, "UnfittedTag",
                      "A tag that was read but is not reported: its pattern could not be fitted.")
      .field("id", &UnfittedTag::id, "Its id.")
      .field(
          "corners", [](const UnfittedTag& tag) { return corners_array(tag.corners); },
          "(4, 2), approximate, px.")
      .representation([](const UnfittedTag& tag) {
        return std::to_string(tag.id) + " at " + centre_text(tag.corners);
      });
  Record<DetectedView, View> view(m, "DetectedView", "The corners that `detect` found.");
  view.attr("_fields") = py::type::of<View>().attr("_fields");
  view.field("warnings", &DetectedView::warnings,
             "What the search found out: tags of other boards, tags seen twice, a wrong border; "
             "empty if there is nothing to say.")
      .field("unfitted", &DetectedView::unfitted, "Tags that were read but are not reported.")
      .field("unreadable", &DetectedView::unreadable,
             "Why the file could not be read, if `skip_unreadable` was given; else empty.")
      .representation([](const DetectedView& v) {
        if (!v.unreadable.empty()) return v.unreadable;
        return "\"" + v.image + "\" " + std::to_string(v.observations.size()) + " corners" +
               and_counted(v.warnings.size(), "warning");
      });
}

void bind_view_list(py::module_& m) {
  py::class_<DetectedViews> views(m, "DetectedViews",
                                  "A sequence of DetectedView, and all warnings.");
  define_pickle<DetectedViews>(views);
  define_sequence(views, &DetectedViews::views, "picture");
  views.def_readonly("views", &DetectedViews::views, "A DetectedView for each picture.")
      .def_readonly("warnings", &DetectedViews::warnings,
                    "Those about all pictures, then those of each, which begin with its name.")
      .def("__repr__", [](const DetectedViews& all) {
        std::size_t corners = 0;
        for (const DetectedView& v : all.views) corners += v.observations.size();
        return "<DetectedViews " + std::to_string(all.views.size()) + " pictures, " +
               std::to_string(corners) + " corners" + and_counted(all.warnings.size(), "warning") +
               ">";
      });
}

void bind_functions(py::module_& m) {
  m.def("detect", &detect_one, py::arg("image"), py::arg("target"), py::arg("camera") = py::none(),
        py::arg("name") = py::none(), py::arg("refinement") = "fit", py::arg("max_hamming") = 1,
        "The corners of a target in one picture: an array (height, width) of uint8 or uint16, or "
        "the path of a file. 16 bits are scaled as in files: white is the brightest value, or "
        "twice the 99.9 % quantile. With the `camera` of the picture, tags are fitted under its "
        "lens. `refinement`: \"fit\" (the whole pattern, with covariances), \"edges\" or \"stock\" "
        "(AprilTag's corners). `max_hamming`: wrong bits accepted in a tag, 0 to 2. Read "
        "`warnings` of the answer, and `explain` if tags are missing.");
  m.def("detect_all", &detect_many, py::arg("images"), py::arg("target"),
        py::arg("camera") = py::none(), py::arg("names") = py::none(),
        py::arg("refinement") = "fit", py::arg("max_hamming") = 1,
        py::arg("skip_unreadable") = false, py::arg("threads") = 0,
        "The same for a list of pictures, arrays or paths, in parallel (`threads` 0: one per "
        "core). `names`: of the views; by default those of the files, or \"images[3]\". With "
        "`skip_unreadable`, a file that cannot be read becomes a view without corners.");
  m.def("refine_views", &refine_again, py::arg("images"), py::arg("dataset"), py::arg("camera"),
        py::arg("names") = py::none(), py::arg("threads") = 0,
        "The views of a data set with the corners fitted again in their pictures under a known "
        "lens, that of a first calibration for example: large tags, and corners near the border, "
        "become more accurate. Pictures are found by the views' names; `names` as of detect_all.");
}

}  // namespace

void bind_detect(py::module_& m) {
  bind_views(m);
  bind_view_list(m);
  bind_functions(m);
  bind_detect_tags(m);
  bind_explain(m);
  bind_refine(m);
}

}  // namespace tagcal::python
