#include "python/uncertain_camera.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "python/calibration.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "tagcal/error.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::python {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<Eigen::MatrixXd> covariance_matrices(const std::optional<ArrayLike>& argument,
                                                 const char* name, std::size_t n, py::ssize_t k) {
  if (!argument) return std::vector<Eigen::MatrixXd>(n, Eigen::MatrixXd::Zero(k, k));
  const py::array_t<double> array = real_array(*argument, name);
  const bool is_one = array.ndim() == 2;
  const py::ssize_t count = is_one ? 1 : static_cast<py::ssize_t>(n);
  if ((array.ndim() != 2 && array.ndim() != 3) || array.shape(array.ndim() - 1) != k ||
      array.shape(array.ndim() - 2) != k || (!is_one && array.shape(0) != count)) {
    const std::string shape = std::to_string(k) + ", " + std::to_string(k) + ")";
    throw Error(std::string(name) + ": must have the shape (" + std::to_string(n) + ", " + shape +
                " or (" + shape + ", got " + shape_text(array));
  }
  std::vector<Eigen::MatrixXd> matrices;
  for (std::size_t i = 0; i < n; ++i) {
    const double* const values = array.data() + (is_one ? 0 : static_cast<py::ssize_t>(i) * k * k);
    const Eigen::MatrixXd m = Eigen::Map<const RowMajor>(values, k, k);
    const std::string defect = covariance_defect(m);
    if (!defect.empty())
      throw Error(std::string(name) + ": " + defect + " in matrix " + std::to_string(i));
    matrices.push_back(m);
  }
  return matrices;
}

namespace {

using Fixed = std::map<std::string, double>;
// Rows of vectors and their covariances, as a result; NaN where there is none.
template <int K>
class UncertainRows {
 public:
  explicit UncertainRows(std::size_t n)
      : rows_({static_cast<py::ssize_t>(n), py::ssize_t{K}}),
        covariances_({static_cast<py::ssize_t>(n), py::ssize_t{K}, py::ssize_t{K}}),
        row_(rows_.mutable_data()),
        covariance_(covariances_.mutable_data()) {}

  template <typename Vector, typename Matrix>
  void set(std::size_t i, const Vector& x, const Matrix& covariance) {
    std::copy_n(x.data(), K, row_ + i * K);
    Eigen::Map<RowMajor>(covariance_ + i * K * K, K, K) = covariance;
  }
  void set_none(std::size_t i) {
    std::fill_n(row_ + i * K, K, std::nan(""));
    std::fill_n(covariance_ + i * K * K, K * K, std::nan(""));
  }

  std::pair<py::array_t<double>, py::array_t<double>> arrays(bool is_single) {
    if (is_single) return {rows_.reshape({K}), covariances_.reshape({K, K})};
    return {rows_, covariances_};
  }

 private:
  py::array_t<double> rows_, covariances_;
  double* row_;
  double* covariance_;
};

using UncertainArrays = std::pair<py::array_t<double>, py::array_t<double>>;

UncertainArrays project_uncertain(const CalibrationFile& known, const ArrayLike& points,
                                  const std::optional<ArrayLike>& covariances) {
  const Rows3 rows(points, "points");
  const auto noise = covariance_matrices(covariances, "covariances", rows.size(), 3);
  UncertainRows<2> result(rows.size());
  {
    py::gil_scoped_release release;
    const UncertainCamera lens = uncertain_camera(known);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (const auto pixel = project(lens, UncertainPoint{rows[i], noise[i]}))
        result.set(i, pixel->pixel, pixel->covariance_px2);
      else
        result.set_none(i);
    }
  }
  return result.arrays(rows.is_single());
}

// The points of pixels; `point`: a function of (lens, pixel, index) that may have no value.
template <typename Point>
UncertainArrays points_of_pixels(const CalibrationFile& known, const ArrayLike& pixels,
                                 const std::optional<ArrayLike>& covariances, const Point& point) {
  const Rows2 rows(pixels, "pixels");
  const auto noise = covariance_matrices(covariances, "covariances", rows.size(), 2);
  UncertainRows<3> result(rows.size());
  {
    py::gil_scoped_release release;
    const UncertainCamera lens = uncertain_camera(known);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const UncertainPixel pixel{rows[i], noise[i]};
      const std::optional<UncertainPoint> x = point(lens, pixel, i);
      if (x)
        result.set(i, x->x, x->covariance);
      else
        result.set_none(i);
    }
  }
  return result.arrays(rows.is_single());
}

UncertainArrays directions(const CalibrationFile& known, const ArrayLike& pixels,
                           const std::optional<ArrayLike>& covariances) {
  return points_of_pixels(
      known, pixels, covariances,
      [](const auto& lens, const auto& pixel, std::size_t) { return direction(lens, pixel); });
}

// One number, or (N,) of them, all finite and >= 0.
std::vector<double> lengths_of(const ArrayLike& argument, const char* name, std::size_t n) {
  const py::array_t<double> array = real_array(argument, name);
  if (array.ndim() > 1 || (array.ndim() == 1 && array.shape(0) != static_cast<py::ssize_t>(n)))
    throw Error(std::string(name) + ": must be a number or have the shape (" + std::to_string(n) +
                ",), got the shape " + shape_text(array));
  std::vector<double> lengths(n);
  for (std::size_t i = 0; i < n; ++i)
    lengths[i] = not_negative(array.data()[array.ndim() == 0 ? 0 : i], name);
  return lengths;
}

UncertainArrays points_at_depth(const CalibrationFile& known, const ArrayLike& pixels,
                                const ArrayLike& depth_m, const ArrayLike& sigma_depth_m,
                                const std::optional<ArrayLike>& covariances) {
  const std::size_t n = Rows2(pixels, "pixels").size();
  const std::vector<double> depths = lengths_of(depth_m, "depth_m", n);
  const std::vector<double> sigmas = lengths_of(sigma_depth_m, "sigma_depth_m", n);
  if (std::ranges::count(depths, 0.0) > 0) throw Error("depth_m: must be > 0, got 0");
  return points_of_pixels(known, pixels, covariances,
                          [&](const auto& lens, const auto& pixel, std::size_t i) {
                            return point_at_depth(lens, pixel, depths[i], sigmas[i]);
                          });
}

UncertainArrays points_on_plane(const CalibrationFile& known, const ArrayLike& pixels,
                                const PoseLike& camera_from_plane,
                                const std::optional<ArrayLike>& covariances) {
  const Pose pose = pose_of(camera_from_plane, "camera_from_plane");
  return points_of_pixels(known, pixels, covariances,
                          [&](const auto& lens, const auto& pixel, std::size_t) {
                            return point_on_plane(lens, pixel, pose);
                          });
}

CalibrationFile uncertain_camera(const Camera& camera, const std::optional<std::string>& model,
                                 const std::optional<ArrayLike>& covariance, const Fixed& fixed,
                                 const std::optional<SeenRegion>& seen,
                                 const std::optional<double>& camera_error_px) {
  CalibrationFile known;
  known.camera = camera;
  known.model = model.value_or("");
  known.fixed = fixed;
  if (seen) known.seen = *seen;
  if (camera_error_px) not_negative(*camera_error_px, "camera_error_px");
  known.camera_error_px = camera_error_px;
  if (!model) {
    if (covariance) throw Error("covariance: needs the model whose parameters it is of");
    return known;
  }
  const Model& named = Model::named(*model);
  if (&named.kind() != &kind_of(camera.lens))
    throw Error("model: " + *model + " has another kind of lens than the camera");
  const HeldModels held(fixed, named.kind());
  if (!covariance) return known;
  const Model& of_model = held.named(*model);
  known.covariance = covariance_matrices(covariance, "covariance", 1, of_model.num_free()).front();
  known.sigmas = lens_sigmas({&of_model, camera, known.covariance});
  return known;
}

std::optional<py::array_t<double>> covariance_or_none(const CalibrationFile& known) {
  if (known.covariance.size() == 0) return std::nullopt;
  return matrix_array(known.covariance);
}

std::optional<UncertainCamera> claim_or_none(const CalibrationFile& known) {
  const UncertainCamera claim = uncertain_camera(known);
  return claim.model ? std::optional(claim) : std::nullopt;
}

void bind_claim(py::module_& m) {
  Record<UncertainCamera>(m, "Claim",
                          "What is known of a lens: the covariance of the free parameters of a "
                          "model. Of a calibration it is the largest model that the data need, not "
                          "only that of the answer.")
      .field(
          "model", [](const UncertainCamera& c) { return std::string(c.model->name()); },
          "The name of that model.")
      .field(
          "parameters",
          [](const UncertainCamera& c) {
            std::vector<std::string> names;
            for (const FreeParameter& free : c.model->free()) names.emplace_back(free.name);
            return names;
          },
          "The names of its free parameters: the rows of `covariance`.")
      .field("covariance", &UncertainCamera::covariance,
             "(K, K); zero for parameters that were held.")
      .representation([](const UncertainCamera& c) {
        return std::string(c.model->name()) + ", " + counted(c.model->free().size(), "parameter");
      });
}

void define_knowledge(Record<CalibrationFile>& record) {
  record.field(
      "camera", [](const CalibrationFile& k) { return k.camera; }, "The Camera.");
  record.field("model", &CalibrationFile::model, "Its model, such as \"opencv5\"; \"\": unknown.");
  record.field("fixed", &CalibrationFile::fixed, "Lens parameters that were held, by name.");
  record.field(
      "sigmas", [](const CalibrationFile& k) { return by_name(k.camera.lens, k.sigmas); },
      "Standard deviation of each lens parameter by name, 0 for a held one; empty: unknown.");
  record.field("covariance", &covariance_or_none,
               "(K, K), of the model's free parameters; None: unknown, taken as exact.");
  record.field("claim", &claim_or_none,
               "The Claim, from which all uncertainties of points follow; None: unknown, taken as "
               "exact.");
  record.field("seen", &CalibrationFile::seen, "The region of the corners; empty: unknown.");
  record.field("camera_error_px", &CalibrationFile::camera_error_px,
               "Error of a projection per coordinate, besides the noise of a corner; None: "
               "unknown. `estimate_view_pose` takes it.");
  record.representation([](const CalibrationFile& k) {
    const auto p = parameters(k.camera.lens);
    return (k.model.empty() ? std::string("model unknown") : k.model) + ", " +
           std::string(parameter_names(k.camera.lens)[0]) + " " + number(p[0]) +
           (k.sigmas.empty() ? "" : " +- " + number(k.sigmas[0], 2)) + ", " +
           size_text(k.camera.image_size);
  });
}

void define_points(Record<CalibrationFile>& record) {
  record.def("project", &project_uncertain, py::arg("points"), py::arg("covariances") = py::none(),
             "The pixels (N, 2) of points (N, 3), metres, in the camera frame, and their "
             "covariances (N, 2, 2), px^2: of the lens and of the points, whose own are "
             "`covariances` (N, 3, 3) or (3, 3). NaN where the lens has no pixel.");
  record.def("direction", &directions, py::arg("pixels"), py::arg("covariances") = py::none(),
             "The unit directions (N, 3) of the rays of pixels (N, 2), and their covariances (N, "
             "3, 3), of rank 2. `covariances` (N, 2, 2) or (2, 2): of the pixels. NaN where a "
             "pixel has no ray.");
  record.def("point_at_depth", &points_at_depth, py::arg("pixels"), py::arg("depth_m"),
             py::arg("sigma_depth_m") = 0.0, py::arg("covariances") = py::none(),
             "The points (N, 3) of pixels (N, 2) at a depth (z in the camera frame), one for all "
             "or (N,), and their covariances (N, 3, 3).");
  record.def("point_on_plane", &points_on_plane, py::arg("pixels"), py::arg("camera_from_plane"),
             py::arg("covariances") = py::none(),
             "The points (N, 3) of pixels (N, 2) on the plane z = 0 of a frame, in that frame (the "
             "Pose is exact), and their covariances (N, 3, 3). NaN where the ray does not meet "
             "the plane in front of the camera.");
}

}  // namespace

void bind_uncertain_camera(py::module_& m) {
  bind_claim(m);
  Record<CalibrationFile> record(m, "UncertainCamera",
                                 "A camera with what is known of it: as `Calibration` and files of "
                                 "cameras have it. It projects points with covariances.");
  record.def(py::init(&uncertain_camera), py::arg("camera"), py::arg("model") = py::none(),
             py::arg("covariance") = py::none(), py::arg("fixed") = Fixed(),
             py::arg("seen") = py::none(), py::arg("camera_error_px") = py::none(),
             "`covariance` (K, K): of the free parameters of the model of that name, without those "
             "in `fixed`. Without it the camera is taken as exact.");
  define_knowledge(record);
  define_points(record);
}

}  // namespace tagcal::python
