#include "tagcal/estimate/pose.hpp"

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/boards.hpp"
#include "python/camera.hpp"
#include "python/findings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal::python {

std::string refusal(Status status, const std::vector<Finding>& findings) {
  std::string text = "no answer: " + std::string(status_name(status));
  for (const Finding& finding : findings)
    if (finding.severity == Severity::refusal) return text + ": " + in_python(finding.sentence);
  return text;
}

std::string warnings_text(const std::vector<Finding>& findings) {
  const auto count = std::ranges::count(findings, Severity::warning, &Finding::severity);
  return and_counted(static_cast<std::size_t>(count), "warning");
}

PoseOptions pose_options(double sigma_px, bool reject_outliers, int max_iterations,
                         std::uint64_t seed) {
  not_negative(sigma_px, "sigma_px", "estimated");
  check_positive(max_iterations, "max_iterations");
  PoseOptions options;
  options.sigma_px = sigma_px;
  options.reject_outliers = reject_outliers;
  options.max_iterations = max_iterations;
  options.seed = seed;
  return options;
}

namespace {

// The arguments of an estimate, checked and in the library's form.
struct Input {
  std::vector<Correspondence> correspondences;
  std::vector<Matrix2> covariances;
  std::vector<int> groups;
};

std::vector<int> groups_of(const ArrayLike& argument, std::size_t n) {
  if (argument.is_none()) return {};
  const py::array_t<double> array = real_array(argument, "groups");
  if (array.ndim() != 1 || array.shape(0) != static_cast<py::ssize_t>(n))
    throw Error("groups: must have the shape (" + std::to_string(n) + ",)");
  std::vector<int> groups(n);
  for (std::size_t i = 0; i < n; ++i) {
    constexpr double kLargest = 1 << 30;  // numeric: fits an int
    const double group = array.data()[i];
    if (!(std::abs(group) <= kLargest && group == std::floor(group)))
      throw Error("groups: must be whole numbers, got " + number(group));
    groups[i] = static_cast<int>(group);
  }
  return groups;
}

Input input_of(const ArrayLike& points, const ArrayLike& pixels, const ArrayLike& covariances,
               const ArrayLike& groups) {
  const Rows3 x(points, "points");
  const Rows2 p(pixels, "pixels");
  check_same_length(x.size(), "points", p.size(), "pixels");
  Input input;
  input.correspondences.resize(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) input.correspondences[i] = {x[i], p[i]};
  input.covariances = covariances2(covariances, "covariances", x.size());
  input.groups = groups_of(groups, x.size());
  return input;
}

PoseEstimate estimate(const ArrayLike& points, const ArrayLike& pixels, const Camera& camera,
                      double sigma_px, const ArrayLike& covariances, const ArrayLike& groups,
                      bool reject_outliers, int max_iterations, std::uint64_t seed) {
  const Input input = input_of(points, pixels, covariances, groups);
  PoseOptions options = pose_options(sigma_px, reject_outliers, max_iterations, seed);
  options.covariance_px2 = input.covariances;
  options.groups = input.groups;
  py::gil_scoped_release release;
  return estimate_pose(input.correspondences, camera, options);
}

PoseAndFocalEstimate estimate_with_focal(const ArrayLike& points, const ArrayLike& pixels,
                                         const ArrayLike& size, double sigma_px,
                                         const ArrayLike& covariances, const ArrayLike& groups,
                                         double prior_focal_px, bool reject_outliers,
                                         int max_iterations, std::uint64_t seed,
                                         bool exact_pinhole) {
  const Input input = input_of(points, pixels, covariances, groups);
  PoseAndFocalOptions options{pose_options(sigma_px, reject_outliers, max_iterations, seed)};
  options.prior_focal_px = not_negative(prior_focal_px, "prior_focal_px", "none");
  options.exact_pinhole = exact_pinhole;
  options.covariance_px2 = input.covariances;
  options.groups = input.groups;
  const ImageSize image_size = size_of_argument(size, "size");
  py::gil_scoped_release release;
  return estimate_pose_and_focal(input.correspondences, image_size, options);
}

PoseEstimate estimate_of_view(const View& view, const TargetLike& target, const CameraLike& camera,
                              const std::optional<double>& camera_error_px, double sigma_px,
                              bool reject_outliers, int max_iterations, std::uint64_t seed) {
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  const PoseOptions options = pose_options(sigma_px, reject_outliers, max_iterations, seed);
  if (camera_error_px) not_negative(*camera_error_px, "camera_error_px");
  const CalibrationFile known = known_camera(camera, "camera");
  const std::optional<double> error = camera_error_px ? camera_error_px : known.camera_error_px;
  const UncertainCamera uncertain = uncertain_camera(known);
  py::gil_scoped_release release;
  return estimate_pose(view_correspondences(view, boards, error), uncertain, options);
}

// The poses of many targets, as a list and as arrays.
struct PoseEstimates {
  std::vector<PoseEstimate> estimates;
};

// (N, rows, rows); NaN for a target without an answer.
template <typename Matrix>
py::array_t<double> matrices(const PoseEstimates& all, py::ssize_t rows, const Matrix& matrix) {
  py::array_t<double> array({static_cast<py::ssize_t>(all.estimates.size()), rows, rows});
  double* out = array.mutable_data();
  for (const PoseEstimate& estimate : all.estimates) {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> m(out, rows,
                                                                                         rows);
    if (is_answer(estimate.status))
      m = matrix(estimate.hypotheses.front());
    else
      m.setConstant(std::nan(""));
    out += rows * rows;
  }
  return array;
}

// points (M, 3), the same for all, or (N, M, 3); pixels (N, M, 2).
PoseEstimates estimate_many(const ArrayLike& points, const ArrayLike& pixels, const Camera& camera,
                            double sigma_px, bool reject_outliers, int max_iterations,
                            std::uint64_t seed, int threads) {
  const py::array_t<double> x = real_array(points, "points");
  const py::array_t<double> p = real_array(pixels, "pixels");
  const PoseOptions options = pose_options(sigma_px, reject_outliers, max_iterations, seed);
  check_threads(threads);
  if (p.ndim() != 3 || p.shape(2) != 2)
    throw Error("pixels: must have the shape (N, M, 2), got " + shape_text(p));
  const py::ssize_t n = p.shape(0), m = p.shape(1);
  const bool is_common = x.ndim() == 2;
  if (!(is_common && x.shape(0) == m && x.shape(1) == 3) &&
      !(x.ndim() == 3 && x.shape(0) == n && x.shape(1) == m && x.shape(2) == 3))
    throw Error("points: must have the shape (" + std::to_string(m) + ", 3) or (" +
                std::to_string(n) + ", " + std::to_string(m) + ", 3), got " + shape_text(x));
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(x.data(), x.data() + x.size(), is_finite)) throw Error("points: must be finite");
  if (!std::all_of(p.data(), p.data() + p.size(), is_finite)) throw Error("pixels: must be finite");

  PoseEstimates all;
  all.estimates.resize(static_cast<std::size_t>(n));
  const double* const first_point = x.data();
  const double* const first_pixel = p.data();
  py::gil_scoped_release release;
  const auto estimate_one = [&](std::size_t i) {
    const double* point = first_point + (is_common ? 0 : i * static_cast<std::size_t>(3 * m));
    const double* pixel = first_pixel + i * static_cast<std::size_t>(2 * m);
    std::vector<Correspondence> correspondences(static_cast<std::size_t>(m));
    for (Correspondence& c : correspondences) {
      c = {{point[0], point[1], point[2]}, {pixel[0], pixel[1]}};
      point += 3;
      pixel += 2;
    }
    all.estimates[i] = estimate_pose(correspondences, camera, options);
  };
  internal::parallel_for(all.estimates.size(), threads, estimate_one);
  return all;
}

template <typename Estimate>
const Pose& pose_of_answer(const Estimate& estimate) {
  if (!is_answer(estimate.status)) throw Error(refusal(estimate.status, estimate.findings));
  return estimate.camera_from_target();
}

template <typename Estimate>
std::string estimate_text(const Estimate& estimate) {
  std::string text(status_name(estimate.status));
  if (!is_answer(estimate.status)) return refusal(estimate.status, estimate.findings);
  const PoseHypothesis& best = estimate.hypotheses.front();
  const Eigen::Vector3d& t = best.camera_from_target.translation();
  text += ", target at (" + number(t[0], 5) + ", " + number(t[1], 5) + ", " + number(t[2], 5) +
          ") m, rms " + number(best.rms_px, 3) + " px";
  if (estimate.hypotheses.size() > 1)
    text += ", probability " + number(best.probability, 3) + " of " +
            std::to_string(estimate.hypotheses.size()) + " poses";
  return text + warnings_text(estimate.findings);
}

void bind_results(py::module_& m) {
  Record<Finding>(m, "Finding", "A fact that an estimate reports about its data, model or solver.")
      .field("code", &Finding::code, "Stable between versions, such as \"direction_weak\".")
      .field("severity", &Finding::severity, "\"note\", \"warning\" or \"refusal\".")
      .field(
          "sentence", [](const Finding& f) { return in_python(f.sentence); },
          "What was found, what it means, what to do.")
      .representation([](const Finding& f) {
        return std::string(severity_name(f.severity)) + " " + f.code + ": " + in_python(f.sentence);
      });
  Record<PoseHypothesis>(m, "PoseHypothesis", "One pose that fits, with its covariance.")
      .field("camera_from_target", &PoseHypothesis::camera_from_target, "The pose.")
      .field("covariance", &PoseHypothesis::covariance,
             "(6, 6), of (omega rad, tau m) in the camera frame: R <- exp(omega) R, t <- t + tau. "
             "It includes the error of the camera if that is not taken as exact, which all views "
             "by one camera have in common.")
      .field("noise_covariance", &PoseHypothesis::noise_covariance,
             "The part of the corners' noise alone.")
      .field("rms_px", &PoseHypothesis::rms_px, "sqrt(sum |r|^2 / points) over the inliers.")
      .field("probability", &PoseHypothesis::probability, "Among the hypotheses.")
      .field("focal_px", &PoseHypothesis::focal_px, "Of this hypothesis, if estimated; else 0.")
      .representation([](const PoseHypothesis& h) {
        return "probability " + number(h.probability, 3) + ", rms " + number(h.rms_px, 3) + " px";
      });
}

// The fields that both estimates have.
template <typename Estimate>
void add_common_fields(Record<Estimate>& record) {
  record
      .field("status", &Estimate::status,
             "\"ok\" and \"ambiguous\" are answers; \"focal_not_observable\", \"not_observable\", "
             "\"degenerate\", \"no_consensus\" and \"not_converged\" are none.")
      .field("hypotheses", &Estimate::hypotheses, "Best first; two if a plane fits two poses.")
      .field("outliers", &Estimate::outliers, "Rejected correspondences by index, ascending.")
      .field("sigma_px", &Estimate::sigma_px, "Noise per coordinate behind the covariance.")
      .field("findings", &Estimate::findings, "What the estimate found out about its data.");
  record
      .def_property_readonly(
          "is_answer", [](const Estimate& e) { return is_answer(e.status); },
          "True if the status is \"ok\" or \"ambiguous\".")
      .def_property_readonly("camera_from_target", &pose_of_answer<Estimate>,
                             "The likeliest pose. Raises Error if there is no answer.");
  record.representation(&estimate_text<Estimate>);
}

void bind_estimates(py::module_& m) {
  Record<PoseEstimate> pose(m, "PoseEstimate", "The pose of a camera before a target.");
  add_common_fields(pose);
  Record<PoseAndFocalEstimate> focal(m, "PoseAndFocalEstimate",
                                     "Pose and focal length of one view.");
  focal.field("focal_px", &PoseAndFocalEstimate::focal_px, "If the status is an answer; else 0.")
      .field("sigma_focal_px", &PoseAndFocalEstimate::sigma_focal_px, "Its standard deviation.")
      .field("covariance", &PoseAndFocalEstimate::covariance,
             "(7, 7), of (omega rad, tau m, log f) of the likeliest hypothesis.");
  add_common_fields(focal);
}

void bind_many(py::module_& m) {
  py::class_<PoseEstimates> many(
      m, "PoseEstimates", "The poses of many targets: a sequence of PoseEstimate, and arrays.");
  define_pickle<PoseEstimates>(many);
  define_sequence(many, &PoseEstimates::estimates, "target");
  many.def_property_readonly(
          "status",
          [](const PoseEstimates& all) {
            std::vector<std::string> names;
            for (const PoseEstimate& e : all.estimates) names.emplace_back(status_name(e.status));
            return names;
          },
          "The status of each, as text.")
      .def_property_readonly(
          "camera_from_target",
          [](const PoseEstimates& all) {
            return matrices(all, 4,
                            [](const PoseHypothesis& h) { return h.camera_from_target.matrix(); });
          },
          "(N, 4, 4), the likeliest poses; NaN without an answer.")
      .def_property_readonly(
          "covariance",
          [](const PoseEstimates& all) {
            return matrices(all, 6, [](const PoseHypothesis& h) { return h.covariance; });
          },
          "(N, 6, 6), of (omega rad, tau m); NaN without an answer.")
      .def("__repr__", [](const PoseEstimates& all) {
        const auto answers = std::ranges::count_if(
            all.estimates, [](const PoseEstimate& e) { return is_answer(e.status); });
        return "<PoseEstimates " + std::to_string(answers) + " answers of " +
               std::to_string(all.estimates.size()) + ">";
      });
}

}  // namespace

void bind_pose(py::module_& m) {
  bind_results(m);
  bind_estimates(m);
  bind_many(m);
  m.def("estimate_pose", &estimate, py::arg("points"), py::arg("pixels"), py::arg("camera"),
        py::arg("sigma_px") = 0.0, py::arg("covariances") = py::none(),
        py::arg("groups") = py::none(), py::arg("reject_outliers") = true,
        py::arg("max_iterations") = 50, py::arg("seed") = 0,
        "The pose of a camera before a target, from four points (N, 3), metres, or more and their "
        "pixels (N, 2). Noise per coordinate is `sigma_px` (0: estimated), or `covariances` (N, 2, "
        "2), px^2. Points with equal numbers in `groups` (N,), such as the corners of a tag, are "
        "inliers together. Wrong correspondences are rejected by RANSAC.");
  m.def("estimate_poses", &estimate_many, py::arg("points"), py::arg("pixels"), py::arg("camera"),
        py::arg("sigma_px") = 0.0, py::arg("reject_outliers") = true,
        py::arg("max_iterations") = 50, py::arg("seed") = 0, py::arg("threads") = 1,
        "The same for N targets in one call: points (M, 3), the same for all, or (N, M, 3), and "
        "pixels (N, M, 2). `threads` 0: one per core.");
  m.def("estimate_pose_and_focal", &estimate_with_focal, py::arg("points"), py::arg("pixels"),
        py::arg("size"), py::arg("sigma_px") = 0.0, py::arg("covariances") = py::none(),
        py::arg("groups") = py::none(), py::arg("prior_focal_px") = 0.0,
        py::arg("reject_outliers") = true, py::arg("max_iterations") = 50, py::arg("seed") = 0,
        py::arg("exact_pinhole") = false,
        "Pose and focal length of a pinhole with square pixels and its principal point in the "
        "centre of the image of `size` (width, height). The standard deviations include what "
        "lenses are instead, unless it is an `exact_pinhole`, as of rendered pictures. Refused "
        "(\"focal_not_observable\") if the view does not determine the focal length to 10 %.");
  m.def("estimate_view_pose", &estimate_of_view, py::arg("view"), py::arg("target"),
        py::arg("camera"), py::arg("camera_error_px") = py::none(), py::arg("sigma_px") = 0.0,
        py::arg("reject_outliers") = true, py::arg("max_iterations") = 50, py::arg("seed") = 0,
        "The pose of the camera of a view, from the corners that the target has. Their covariances "
        "are used if the error of the camera is known, from `camera` (a Calibration or an "
        "UncertainCamera) or `camera_error_px`: they do not include the errors of lens and "
        "target. The pose's covariance includes that of the camera.");
}

}  // namespace tagcal::python
