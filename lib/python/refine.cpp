#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/arrays.hpp"
#include "python/detect_options.hpp"
#include "python/grey_image.hpp"
#include "python/records.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine.hpp"
#include "tagcal/error.hpp"

namespace tagcal::python {

template <>
inline constexpr auto kMembers<TagFit> = std::tuple(&TagFit::status, &TagFit::blur_px,
                                                    &TagFit::black, &TagFit::white,
                                                    &TagFit::noise_levels, &TagFit::num_pixels,
                                                    &TagFit::corners, &TagFit::covariance_px2,
                                                    &TagFit::shift_px, &TagFit::iterations,
                                                    &TagFit::is_by_corner);
template <>
inline constexpr auto kMembers<CornerFit> = std::tuple(&CornerFit::status, &CornerFit::blur_px,
                                                       &CornerFit::black, &CornerFit::white,
                                                       &CornerFit::noise_levels,
                                                       &CornerFit::num_pixels, &CornerFit::corner,
                                                       &CornerFit::covariance_px2);

namespace {

const char* status_text(TagFitStatus status) {
  switch (status) {
    case TagFitStatus::converged:
      return "converged";
    case TagFitStatus::not_converged:
      return "not_converged";
    case TagFitStatus::out_of_image:
      return "out_of_image";
    case TagFitStatus::too_small:
      return "too_small";
  }
  return "";
}

TagFitOptions fit_options(const std::optional<Camera>& camera, double gamma) {
  TagFitOptions options;
  if (camera) options.camera = &*camera;
  options.processing.gamma = positive(gamma, "gamma");
  return options;
}

// Calls `refine` with the picture, of 16 bits if it has them.
template <typename Refine>
auto in_picture(const ImageLike& image, const Refine& refine) {
  GreyImage grey(image, "image");
  py::gil_scoped_release release;
  if (const ImageView16* wide = grey.wide_view()) return refine(*wide);
  grey.load();
  return refine(grey.view());
}

TagFit refine_one_tag(const ImageLike& image, int id, const ArrayLike& corners,
                      const std::string& family, int border_bits,
                      const std::optional<bool>& corner_squares, double tag_spacing,
                      const std::optional<Camera>& camera, double gamma) {
  const Rows2 rows(corners, "corners");
  if (rows.size() != 4)
    throw Error("corners: must have the shape (4, 2), got " + std::to_string(rows.size()) +
                " rows");
  not_negative(tag_spacing, "tag_spacing");
  const TagPattern pattern = tag_pattern(tag_family(family, border_bits), id, border_bits,
                                         {tag_spacing, corner_squares.value_or(border_bits == 2)});
  const TagFitOptions options = fit_options(camera, gamma);
  return in_picture(image, [&](const auto& picture) {
    return refine_tag(picture, pattern, {rows[0], rows[1], rows[2], rows[3]}, options);
  });
}

// A checkerboard of squares of side 1 about its corner (0, 0).
CornerPattern squares_about_corner(int squares, bool starts_black) {
  constexpr int kMost = 11;  // of refine_corner: 24 lines
  if (squares < 1 || squares > kMost)
    throw Error("squares: must be 1 to " + std::to_string(kMost) + ", got " +
                std::to_string(squares));
  CornerPattern pattern;
  for (int i = -squares; i <= squares; ++i) pattern.columns.push_back(i);
  pattern.rows = pattern.columns;
  for (int row = -squares; row < squares; ++row)
    for (int column = -squares; column < squares; ++column)
      pattern.cells.push_back(((row + column) % 2 == 0) == starts_black ? TagPattern::black
                                                                        : TagPattern::white);
  return pattern;
}

CornerFit refine_one_corner(const ImageLike& image, const ArrayLike& image_from_squares,
                            int squares, bool starts_black, const std::optional<Camera>& camera,
                            double gamma) {
  const Eigen::Matrix3d homography = matrix3(image_from_squares, "image_from_squares");
  const CornerPattern pattern = squares_about_corner(squares, starts_black);
  const TagFitOptions options = fit_options(camera, gamma);
  return in_picture(image, [&](const auto& picture) {
    return refine_corner(picture, pattern, homography, options);
  });
}

template <typename Fit>
void add_common_fields(Record<Fit>& record) {
  record
      .field(
          "status", [](const Fit& fit) { return std::string(status_text(fit.status)); },
          "\"converged\"; without corners: \"not_converged\" (the pixels do not look like the "
          "pattern near the start), \"out_of_image\" or \"too_small\".")
      .field("blur_px", &Fit::blur_px, "Standard deviation of the Gaussian blur.")
      .field("black", &Fit::black, "Grey level of black.")
      .field("white", &Fit::white, "Grey level of white.")
      .field("noise_levels", &Fit::noise_levels,
             "Standard deviation of a pixel about the model, grey levels.")
      .field("num_pixels", &Fit::num_pixels, "Number of pixels that were fitted.");
}

bool converged(TagFitStatus status) { return status == TagFitStatus::converged; }

void bind_tag_fit(py::module_& m) {
  Record<TagFit> tag(m, "TagFit", "The corners of a tag, by a fit of all its pixels.");
  tag.field(
         "corners",
         [](const TagFit& fit) -> std::optional<py::array_t<double>> {
           if (!converged(fit.status)) return std::nullopt;
           return array_of(std::span<const Eigen::Vector2d>(fit.corners));
         },
         "(4, 2), px, in the order of View.ids; None if not converged.")
      .field(
          "covariance",
          [](const TagFit& fit) -> std::optional<Eigen::MatrixXd> {
            if (!converged(fit.status)) return std::nullopt;
            return Eigen::MatrixXd(fit.covariance_px2);
          },
          "(8, 8), px^2, of (x0, y0, x1, ..); None if not converged.")
      .field("is_by_corner", &TagFit::is_by_corner,
             "True if the tag is strongly bent: a camera would improve the corners.");
  add_common_fields(tag);
  tag.representation([](const TagFit& fit) {
    return std::string(status_text(fit.status)) + ", blur " + number(fit.blur_px, 3) + " px";
  });
}

void bind_corner_fit(py::module_& m) {
  Record<CornerFit> corner(m, "CornerFit", "A corner of a checkerboard, by a fit of its pixels.");
  corner
      .field(
          "corner",
          [](const CornerFit& fit) -> std::optional<Eigen::Vector2d> {
            if (!converged(fit.status)) return std::nullopt;
            return fit.corner;
          },
          "(2,), px; None if not converged.")
      .field(
          "covariance",
          [](const CornerFit& fit) -> std::optional<Eigen::Matrix2d> {
            if (!converged(fit.status)) return std::nullopt;
            return fit.covariance_px2;
          },
          "(2, 2), px^2; None if not converged.");
  add_common_fields(corner);
  corner.representation([](const CornerFit& fit) {
    return std::string(status_text(fit.status)) + ", blur " + number(fit.blur_px, 3) + " px";
  });
}

}  // namespace

void bind_refine(py::module_& m) {
  bind_tag_fit(m);
  bind_corner_fit(m);
  m.def(
      "refine_tag", &refine_one_tag, py::arg("image"), py::arg("id"), py::arg("corners"),
      py::arg("family") = "tag36h11", py::arg("border_bits") = 1,
      py::arg("corner_squares") = py::none(), py::arg("tag_spacing") = 0.0,
      py::arg("camera") = py::none(), py::arg("gamma") = 1.0,
      "The corners of a tag whose id is known, by a fit of all its pixels, from corners (4, 2) "
      "within about half a cell. `corner_squares`: Kalibr's black squares touch the corners (None: "
      "with a border of 2), `tag_spacing` tag sizes wide (0: unknown). `gamma`: grey level = "
      "light to this power.");
  m.def("refine_corner", &refine_one_corner, py::arg("image"), py::arg("image_from_squares"),
        py::arg("squares") = 1, py::arg("starts_black") = true, py::arg("camera") = py::none(),
        py::arg("gamma") = 1.0,
        "The corner of a checkerboard where four squares meet, by a fit of the pixels about it. "
        "`image_from_squares` (3, 3) takes the plane of the squares, of side 1 with the corner at "
        "(0, 0), to pixels: right to a quarter of a square and 3 % in scale. `squares`: number of "
        "squares known on each side of the corner. `starts_black`: the square between +x and +y "
        "is black.");
}

}  // namespace tagcal::python
