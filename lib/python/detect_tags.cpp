#include "tagcal/detect/detector.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "python/detect_options.hpp"
#include "python/grey_image.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {

template <>
inline constexpr auto kMembers<DetectedTag> = std::tuple(&DetectedTag::id, &DetectedTag::corners,
                                                         &DetectedTag::covariance_px2);

py::array_t<double> corners_array(const std::array<Eigen::Vector2d, 4>& corners) {
  return array_of(std::span<const Eigen::Vector2d>(corners));
}

std::string centre_text(const std::array<Eigen::Vector2d, 4>& corners) {
  const Eigen::Vector2d centre = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
  return "(" + number(centre.x(), 5) + ", " + number(centre.y(), 5) + ")";
}

namespace {

std::vector<DetectedTag> find_tags(const ImageLike& image, const std::string& family,
                                   int border_bits, const std::optional<Camera>& camera,
                                   const std::string& refinement, int max_hamming) {
  const DetectOptions options = detect_options(camera, refinement, max_hamming, 1);
  GreyImage grey(image, "image");
  py::gil_scoped_release release;
  grey.load();
  return detect_tags(grey.view(), {family, border_bits}, options);
}

// (4, 2, 2), the blocks of the corners.
std::optional<py::array_t<double>> corner_covariances(const DetectedTag& tag) {
  if (!tag.covariance_px2) return std::nullopt;
  py::array_t<double> array({4, 2, 2});
  double* out = array.mutable_data();
  for (int i = 0; i < 4; ++i) {
    const Matrix2 block = tag.covariance_px2->block<2, 2>(2 * i, 2 * i);
    out = std::copy_n(block.data(), 4, out);
  }
  return array;
}

void bind_detected_tag(py::module_& m) {
  Record<DetectedTag>(m, "DetectedTag", "A tag in a picture, which may be on no known board.")
      .field("id", &DetectedTag::id, "Its id in the family.")
      .field(
          "corners", [](const DetectedTag& tag) { return corners_array(tag.corners); },
          "(4, 2), px: lower-left, lower-right, upper-right, upper-left of the upright tag.")
      .field(
          "covariance",
          [](const DetectedTag& tag) -> std::optional<Eigen::MatrixXd> {
            if (!tag.covariance_px2) return std::nullopt;
            return Eigen::MatrixXd(*tag.covariance_px2);
          },
          "(8, 8), px^2, of (x0, y0, x1, ..); None if the pattern was not fitted.")
      .representation([](const DetectedTag& tag) {
        return std::to_string(tag.id) + " at " + centre_text(tag.corners);
      })
      .def_property_readonly("covariances", &corner_covariances,
                             "(4, 2, 2), px^2, of each corner; None as `covariance`.");
}

}  // namespace

void bind_detect_tags(py::module_& m) {
  bind_detected_tag(m);
  m.def("detect_tags", &find_tags, py::arg("image"), py::arg("family") = "tag36h11",
        py::arg("border_bits") = 1, py::arg("camera") = py::none(), py::arg("refinement") = "fit",
        py::arg("max_hamming") = 1,
        "All tags of a family in one picture, without a board; ids may repeat. `border_bits`: "
        "width of the black border in cells, 1 for plain tags, 2 on Kalibr's boards. The other "
        "arguments are those of `detect`.");
}

}  // namespace tagcal::python
