#include "tagcal/io/calibration_file.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/io/text/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;
namespace {

std::string number_yaml(double value) {
  if (std::isnan(value)) return ".Nan";
  if (std::isinf(value)) return value > 0 ? ".Inf" : "-.Inf";
  return fmt::format("{}", value);
}

// A matrix of doubles as cv::FileStorage writes it, one row per line; `indent` is that of the key.
std::string matrix_yaml(std::string_view key, const Eigen::MatrixXd& matrix, int indent = 0) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  std::string data;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    data += row == 0 ? " " : ",\n" + margin + "      ";
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      data += (column == 0 ? "" : ", ") + number_yaml(matrix(row, column));
  }
  return fmt::format(
      "{0}: !!opencv-matrix\n{1}   rows: {2}\n{1}   cols: {3}\n{1}   dt: d\n{1}   data: [{4} ]\n",
      key, margin, matrix.rows(), matrix.cols(), data);
}

Eigen::MatrixXd row_of(const std::vector<double>& values) {
  return Eigen::RowVectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

template <typename Texts>
std::string texts_yaml(std::string_view key, const Texts& texts) {
  std::string list;
  for (const auto& text : texts) list += "\n   - " + text_yaml(text);
  return list.empty() ? fmt::format("{}: []\n", key) : fmt::format("{}:{}\n", key, list);
}

// Without a focal length there is no camera matrix that another program could read.
std::string camera_yaml(const Camera& camera, std::string_view model) {
  const std::span<const double> p = parameters(camera.lens);
  const std::string size = fmt::format("image_width: {}\nimage_height: {}\n",
                                       camera.image_size.width, camera.image_size.height);
  if (std::holds_alternative<Parallel>(camera.lens)) return size;
  Eigen::Matrix3d matrix;
  matrix << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1;
  return size + matrix_yaml("camera_matrix", matrix) +
         matrix_yaml("distortion_coefficients", row_of(distortion_of(camera.lens, model)));
}

std::string fixed_yaml(const std::map<std::string, double>& fixed) {
  if (fixed.empty()) return "";
  std::string values;
  for (const auto& [name, value] : fixed)
    values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", name, value);
  return fmt::format("fixed: {{ {} }}\n", values);
}

std::string uncertainty_yaml(const Calibration& calibration) {
  std::string text = fixed_yaml(calibration.fixed);
  const bool weak = std::holds_alternative<Parallel>(calibration.camera->lens);
  if (!weak && !calibration.sigmas.empty()) {
    text += texts_yaml("parameter_names", parameter_names(calibration.camera->lens)) +
            matrix_yaml("sigmas", row_of(calibration.sigmas));
  }
  if (calibration.covariance.size() > 0) {
    std::vector<std::string_view> names;
    const HeldModels models(calibration.fixed, Model::named(calibration.model).lens_type());
    for (const FreeParameter& free : models.named(calibration.model).free())
      names.push_back(free.name);
    text +=
        texts_yaml("covariance_names", names) + matrix_yaml("covariance", calibration.covariance);
  }
  return text;
}

std::string projection_yaml(const Calibration& calibration) {
  std::string text;
  const std::vector<Eigen::Vector2d>& hull = calibration.seen.hull();
  if (!hull.empty()) {
    Eigen::MatrixXd corners(static_cast<Eigen::Index>(hull.size()), 2);
    for (std::size_t i = 0; i < hull.size(); ++i)
      corners.row(static_cast<Eigen::Index>(i)) = hull[i].transpose();
    text += matrix_yaml("seen_region", corners);
  }
  if (calibration.projection.empty()) return text;
  text += "projection_uncertainty:\n";
  for (const ProjectionUncertainty& p : calibration.projection)
    text += fmt::format("   - distance_m: {}\n     ", number_yaml(p.distance_m)) +
            matrix_yaml("sigma_px", p.sigma_px, 5);
  return text;
}

double camera_error_px(const Calibration& c) {
  double projection = 0;
  for (const ProjectionUncertainty& p : c.projection)
    if (std::isfinite(p.distance_m) || projection == 0) projection = p.region_px;
  const double noise = c.sigma_of_corners ? c.model_error_px : c.sigma_px;
  return std::hypot(noise, std::isfinite(projection) ? projection : 0);
}

std::string pose_yaml(const Pose& pose, std::string_view prefix) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  return fmt::format(
      "     {0}rotation: [ {1}, {2}, {3}, {4} ]\n     {0}translation_m: [ {5}, {6}, {7} ]\n",
      prefix, q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
}

// The further keys of a view of model weak: its scale, and the uncertainty.
std::string weak_view_yaml(const CalibratedView& view) {
  if (!view.scale_px_per_m) return "";
  return (view.mirrored ? pose_yaml(*view.mirrored, "mirrored_") : "") +
         fmt::format("     scale_px_per_m: {}\n     scale_sigma_px_per_m: {}\n     ",
                     *view.scale_px_per_m, number_yaml(view.scale_sigma_px_per_m)) +
         matrix_yaml("pose_covariance", view.covariance, 5);
}

std::string views_yaml(const std::vector<CalibratedView>& views) {
  std::string text = views.empty() ? "views: []\n" : "views:\n";
  for (const CalibratedView& view : views)
    text += fmt::format("   - image: {}\n", text_yaml(view.image)) +
            pose_yaml(view.camera_from_world, "") + weak_view_yaml(view) +
            fmt::format("     num_corners: {}\n     rms_px: {}\n", view.num_corners, view.rms_px);
  return text;
}

// {rows, cols, data}, with or without OpenCV's tag.
Eigen::MatrixXd read_matrix(const YamlValue& value) {
  const int rows = value.at("rows").whole(1, 1000);
  const int cols = value.at("cols").whole(1, 1000);
  const YamlValue data = value.at("data");
  const std::vector<double> numbers = data.numbers(static_cast<std::size_t>(rows) * cols);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return RowMajor::Map(numbers.data(), rows, cols);
}

std::vector<double> read_row(const YamlValue& value) {
  const Eigen::MatrixXd matrix = read_matrix(value);
  if (matrix.rows() != 1 && matrix.cols() != 1) {
    value.fail_plainly(
        fmt::format("must have one row or one column, got {} x {}", matrix.rows(), matrix.cols()));
  }
  return {matrix.data(), matrix.data() + matrix.size()};
}

void read_camera_matrix(const YamlValue& value, CameraNumbers& numbers) {
  const Eigen::MatrixXd k = read_matrix(value);
  if (k.rows() != 3 || k.cols() != 3) {
    value.fail_plainly(fmt::format("must be 3 x 3, got {} x {}", k.rows(), k.cols()));
  }
  for (int i = 0; i < 2; ++i) {
    if (k(i, i) > 0) continue;
    value.fail_plainly(fmt::format("f{}: must be > 0, got {}", i == 0 ? 'x' : 'y', k(i, i)));
  }
  if (k(0, 1) != 0) value.fail_plainly(fmt::format("the skew must be 0, got {}", k(0, 1)));
  if (k(1, 0) != 0 || k(2, 0) != 0 || k(2, 1) != 0 || k(2, 2) != 1) {
    value.fail_plainly("must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  }
  numbers.fx = k(0, 0);
  numbers.fy = k(1, 1);
  numbers.cx = k(0, 2);
  numbers.cy = k(1, 2);
}

// Returns true if a key of another program says that the lens is a fisheye.
bool is_marked_fisheye(const YamlValue& top) {
  const auto flag = top.find("fisheye_model");  // OpenCV's calibration sample
  if (flag && flag->whole(0, 1) == 1) return true;
  const auto ros = top.find("distortion_model");
  if (!ros) return false;
  const std::string name = ros->text();
  if (name == "equidistant" || name == "fisheye") return true;
  if (name == "plumb_bob" || name == "rational_polynomial") return false;
  ros->fail("must be plumb_bob, rational_polynomial or equidistant");
}

std::vector<double> read_distortion(const YamlValue& value, bool fisheye) {
  std::vector<double> k = read_row(value);
  const auto size_is = [&](std::size_t n) { return k.size() == n; };
  if (fisheye && !size_is(4)) {
    value.fail_plainly(fmt::format("must have the 4 coefficients of a fisheye, got {}", k.size()));
  }
  if (!size_is(4) && !size_is(5) && !size_is(8) && !size_is(12) && !size_is(14)) {
    value.fail_plainly(fmt::format("must have 4, 5 or 8 coefficients, got {}", k.size()));
  }
  for (std::size_t i = 8; i < k.size(); ++i) {
    if (k[i] == 0) continue;
    value.fail_plainly(fmt::format(
        "coefficient {} (thin prism, tilt) must be 0: no lens here has it, got {}", i + 1, k[i]));
  }
  k.resize(std::min<std::size_t>(k.size(), 8));
  return k;
}

void read_fixed(const YamlValue& values, CalibrationFile& file) {
  for (const std::string_view name : parameter_names(file.camera.lens))
    if (const auto value = values.find(name))
      file.fixed.emplace(name, parameter_kind(name) == ParameterKind::focal_length
                                   ? value->positive()
                                   : value->number());
}

void read_uncertainty(const YamlValue& top, CalibrationFile& file) {
  const std::size_t num_parameters = parameters(file.camera.lens).size();
  if (const auto fixed = top.find("fixed")) read_fixed(*fixed, file);
  if (const auto sigmas = top.find("sigmas")) {
    file.sigmas = read_row(*sigmas);
    if (file.sigmas.size() != num_parameters) {
      sigmas->fail_plainly(
          fmt::format("must have {} values, got {}", num_parameters, file.sigmas.size()));
    }
    for (const double sigma : file.sigmas) {
      if (sigma < 0) sigmas->fail_plainly(fmt::format("must be >= 0, got {}", sigma));
    }
  }
  if (const auto covariance = top.find("covariance")) {
    if (file.model.empty()) covariance->fail_plainly("needs the key model, which is missing");
    file.covariance = read_matrix(*covariance);
    const HeldModels models(file.fixed, Model::named(file.model).lens_type());
    const int n = models.named(file.model).num_free();
    if (file.covariance.rows() != n || file.covariance.cols() != n) {
      covariance->fail_plainly(fmt::format("must be {0} x {0} with model {1}, got {2} x {3}", n,
                                           file.model, file.covariance.rows(),
                                           file.covariance.cols()));
    }
  }
}

}  // namespace

std::string calibration_yaml(const Calibration& calibration) {
  assert(calibration.camera && is_answer(calibration.status));
  return "%YAML:1.0\n---\n" + camera_yaml(*calibration.camera, calibration.model) +
         fmt::format(
             "avg_reprojection_error: {}\nmodel: {}\nstatus: {}\nrms_px: {}\nsigma_px: {}\n"
             "sigma_from_residuals: {}\ncamera_error_px: {}\n",
             calibration.rms_px, text_yaml(calibration.model),
             text_yaml(status_name(calibration.status)), calibration.rms_px, calibration.sigma_px,
             int{calibration.sigma_from_residuals}, camera_error_px(calibration)) +
         uncertainty_yaml(calibration) + projection_yaml(calibration) +
         fmt::format("num_views: {}\nnum_corners: {}\nnum_outliers: {}\n", calibration.views.size(),
                     calibration.num_corners, calibration.outliers.size()) +
         views_yaml(calibration.views) + texts_yaml("warnings", sentences(calibration.findings));
}

CalibrationFile read_calibration(const std::filesystem::path& file) {
  const YamlValue top = YamlValue::read(file);
  CameraNumbers numbers;
  numbers.image_size = {top.at("image_width").whole(1, 100'000),
                        top.at("image_height").whole(1, 100'000)};
  const auto name = top.find("model");
  const Model* model = name ? &read_model(*name) : nullptr;
  const bool fisheye = model ? model->lens_type() == LensType::fisheye : is_marked_fisheye(top);
  read_camera_matrix(top.at("camera_matrix"), numbers);
  numbers.distortion = read_distortion(top.at("distortion_coefficients"), fisheye);
  const Model& holds_all = Model::named(fisheye ? "fisheye4" : "opencv8");
  CalibrationFile read{make_camera(numbers, model ? *model : holds_all, top),
                       model ? std::string(model->name()) : "",
                       {},
                       {},
                       {},
                       {}};
  read_uncertainty(top, read);
  if (const auto error = top.find("camera_error_px")) read.camera_error_px = error->not_negative();
  if (const auto region = top.find("seen_region")) {
    const Eigen::MatrixXd corners = read_matrix(*region);
    if (corners.rows() < 3 || corners.cols() != 2)
      region->fail_plainly(
          fmt::format("must be 3 or more x 2, got {} x {}", corners.rows(), corners.cols()));
    std::vector<Eigen::Vector2d> pixels;
    for (const auto& row : corners.rowwise()) pixels.emplace_back(row.transpose());
    read.seen = SeenRegion(numbers.image_size, pixels);
  }
  return read;
}

}  // namespace tagcal
