#include "tagcal/detect/explain.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "python/boards.hpp"
#include "python/detect_options.hpp"
#include "python/grey_image.hpp"
#include "python/records.hpp"

namespace tagcal::python {
namespace {

Explanation explain_image(const ImageLike& image, const TargetLike& target) {
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  GreyImage grey(image, "image");
  py::gil_scoped_release release;
  grey.load();
  return explain(grey.view(), boards);
}

std::string kind_text(const SeenKind& kind) {
  return std::to_string(kind.ids.size()) + " tags of " + kind.family + ", border of " +
         std::to_string(kind.border_bits) + (kind.border_bits == 1 ? " bit" : " bits");
}

std::string explanation_text(const Explanation& e) {
  std::string text = std::to_string(e.reported.size()) + " tags reported, " +
                     std::to_string(e.not_reported.size()) + " not; in the picture: ";
  if (e.decoded.empty()) text += "no tags";
  for (std::size_t i = 0; i < e.decoded.size(); ++i)
    text += (i == 0 ? "" : "; ") + kind_text(e.decoded[i]);
  for (const std::string& sentence : e.checkerboards) text += "; " + sentence;
  for (const std::string& sentence : e.mistakes) text += "; " + sentence;
  return text;
}

}  // namespace

void bind_explain(py::module_& m) {
  Record<SeenKind>(m, "SeenKind", "The tags of one family and border in a picture.")
      .field("family", &SeenKind::family, "The family.")
      .field("border_bits", &SeenKind::border_bits, "Width of the black border in cells.")
      .field("ids", &SeenKind::ids, "Ascending; an id that was seen twice is listed twice.")
      .representation(&kind_text);
  Record<NotReported>(m, "NotReported", "A tag of the target that `detect` does not report.")
      .field("id", &NotReported::id, "Its id.")
      .field("why", &NotReported::why, "The reason.")
      .representation(
          [](const NotReported& tag) { return std::to_string(tag.id) + ": " + tag.why; });
  Record<Explanation>(m, "Explanation", "The content of a picture, and why tags are missing.")
      .field("size", &Explanation::size, "(width, height), px.")
      .field("quads", &Explanation::quads, "Number of black shapes with four sides, tags or not.")
      .field("decoded", &Explanation::decoded,
             "A SeenKind for each known family and border with tags in the picture.")
      .field("reported", &Explanation::reported, "The target's tags that `detect` reports, by id.")
      .field("not_reported", &Explanation::not_reported, "The target's other tags, by id.")
      .field("checkerboards", &Explanation::checkerboards,
             "A sentence for each checkerboard and ChArUco board.")
      .field("mistakes", &Explanation::mistakes, "Probable mistakes of the target or picture.")
      .representation(&explanation_text);
  m.def("explain", &explain_image, py::arg("image"), py::arg("target"),
        "The content of a picture, and the reasons why tags of the target are missing. Searches "
        "for all families and borders, mirrored and inverted too: about ten times the time of "
        "`detect`.");
}

}  // namespace tagcal::python
