#include "tagcal/io/formats/opencv_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/corner_order.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text/number_text.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostTexts = 1000;  // more is no list of tagcal's; chosen by hand

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

std::vector<double> read_distortion(const YamlValue& value, const LensKind& kind,
                                    std::vector<std::string>& notes) {
  const auto data = value.find("data");  // ROS: an empty list for no distortion
  if (data && data->is_list() && data->items(0, 1'000).empty()) return {};
  std::vector<double> k = read_row(value);
  const auto size_is = [&](std::size_t n) { return k.size() == n; };
  const std::size_t all = kind.parameters.size() - 4;
  if (kind.reaches_behind && !size_is(all))
    value.fail_plainly(fmt::format("must have the {} coefficients of a {} lens, got {}", all,
                                   kind.name, k.size()));
  if (kind.reaches_behind) return k;
  if (!size_is(4) && !size_is(5) && !size_is(8) && !size_is(12) && !size_is(14)) {
    value.fail_plainly(fmt::format("must have 4, 5 or 8 coefficients, got {}", k.size()));
  }
  for (std::size_t i = 8; i < k.size(); ++i) {
    if (k[i] == 0) continue;
    value.fail_plainly(fmt::format(
        "coefficient {} (thin prism, tilt) must be 0: no lens here has it, got {}", i + 1, k[i]));
  }
  if (k.size() > 8)
    notes.push_back(
        fmt::format("dropped: {} coefficients of thin prism and tilt, which are 0", k.size() - 8));
  k.resize(std::min<std::size_t>(k.size(), 8));
  return k;
}

std::map<std::string, double> fixed_values(const YamlValue& top) {
  std::map<std::string, double> fixed;
  if (const auto values = top.find("fixed"))
    for (const auto& [name, value] : values->members()) fixed.emplace(shown(name), value.number());
  return fixed;
}

// Throws Error unless each held parameter has the value of the camera.
void check_fixed(const YamlValue& fixed, const Model& model, const CameraNumbers& numbers) {
  std::vector<double> camera = {numbers.fx, numbers.fy, numbers.cx, numbers.cy};
  camera.insert(camera.end(), numbers.distortion.begin(), numbers.distortion.end());
  const std::span<const LensParameter> all = model.kind().parameters;
  while (camera.size() < all.size()) camera.push_back(all[camera.size()].plain);
  for (const auto& [i, held] : model.held()) {
    const auto at = static_cast<std::size_t>(i);
    if (held == camera[at]) continue;
    fixed.fail_plainly(
        fmt::format("{} must be {} as in the camera, got {}", all[at].name, camera[at], held));
  }
}

// The camera of a model, of which some parameters may be fixed, at values that the model alone
// would not have.
Camera camera_of(const YamlValue& top, const CameraNumbers& numbers, const Model& model) {
  const auto fixed = top.find("fixed");
  if (!fixed) return make_camera(numbers, model, top);
  const std::map<std::string, double> values = fixed_values(top);
  std::optional<HeldModels> models;
  try {
    models.emplace(values, model.kind());
  } catch (const Error& error) {
    top.fail_plainly(error.what());
  }
  const Model& held = models->named(model.name());
  check_fixed(*fixed, held, numbers);
  return make_camera(numbers, held, top);
}

// The key may be missing: the order of the values is always the same.
void check_names(const YamlValue& top, std::string_view key,
                 std::span<const std::string_view> names, std::string_view of_model) {
  const auto value = top.find(key);
  if (!value) return;
  std::vector<std::string> given;
  for (const YamlValue& item : value->items(0, kMostTexts)) given.push_back(item.text());
  if (std::ranges::equal(given, names)) return;
  value->fail_plainly(fmt::format("must be {}{}, got {}", fmt::join(names, ", "), of_model,
                                  shown(fmt::format("{}", fmt::join(given, ", ")))));
}

// Throws Error unless the standard deviations are those of the covariance, up to the rounding of
// numbers with six digits, and zero for held parameters: else one of the two is of another camera.
void check_sigmas(const YamlValue& top, const Model& model, const CalibrationFile& file) {
  constexpr double kRounding = 1e-5;  // of two numbers, relative
  const std::vector<double> expected = lens_sigmas({&model, file.camera, file.covariance});
  const std::span<const std::string_view> names = parameter_names(file.camera.lens);
  for (std::size_t k = 0; k < expected.size(); ++k)
    if (!(std::abs(file.sigmas[k] - expected[k]) <= kRounding * expected[k]))
      top.at("sigmas").fail_plainly(
          fmt::format("must be {:.6g} for {} by the covariance, got {:.6g}", expected[k], names[k],
                      file.sigmas[k]));
}

// The covariance of the free parameters of a model; `names`: the key of their names.
MatrixX covariance_of(const YamlValue& top, const YamlValue& value, const Model& model,
                      std::string_view names) {
  MatrixX covariance = read_matrix(value);
  const int n = model.num_free();
  if (covariance.rows() != n || covariance.cols() != n)
    value.fail_plainly(fmt::format("must be {0} x {0} with model {1}, got {2} x {3}", n,
                                   model.name(), covariance.rows(), covariance.cols()));
  std::vector<std::string_view> of_model;
  for (const FreeParameter& free : model.free()) of_model.push_back(free.name);
  check_names(top, names, of_model, fmt::format(" with model {}", model.name()));
  const std::string defect = covariance_defect(covariance);
  if (!defect.empty()) value.fail_plainly(defect);
  return covariance;
}

// Throws Error unless the covariance of the model is that of the claim, up to the rounding of
// numbers with six digits: else one of the two is of another camera.
void check_covariance(const YamlValue& covariance, const Model& model,
                      const CalibrationFile& file) {
  constexpr double kRounding = 1e-5;  // of two numbers, relative
  const MatrixX expected = covariance_by(model, uncertain_camera(file));
  const auto unit = [&](Eigen::Index i) {
    return std::sqrt(std::max({file.covariance(i, i), expected(i, i), 0.0}));
  };
  const auto name = [&](Eigen::Index i) { return model.free()[static_cast<std::size_t>(i)].name; };
  for (Eigen::Index i = 0; i < expected.rows(); ++i)
    for (Eigen::Index j = 0; j < expected.cols(); ++j)
      if (!(std::abs(file.covariance(i, j) - expected(i, j)) <= kRounding * unit(i) * unit(j)))
        covariance.fail_plainly(
            fmt::format("must be {:.6g} for {} and {} by claim_covariance, "
                        "got {:.6g}",
                        expected(i, j), name(i), name(j), file.covariance(i, j)));
}

void read_claim(const YamlValue& top, const YamlValue& covariance, const Model& answer,
                CalibrationFile& file) {
  const auto name = top.find("claim_model"), claim = top.find("claim_covariance");
  if (name && !claim) name->fail_plainly("needs the key claim_covariance, which is missing");
  if (!claim) return;
  if (!name) claim->fail_plainly("needs the key claim_model, which is missing");
  const Model& model = read_model(*name);
  if (&model.kind() != &answer.kind())
    name->fail_plainly(
        fmt::format("must have the kind of lens of model {}, got {}", answer.name(), model.name()));
  file.claim_model = model.name();
  file.claim_covariance = covariance_of(top, *claim, model, "claim_names");
  check_covariance(covariance, answer, file);
}

void read_covariance(const YamlValue& top, CalibrationFile& file) {
  const auto covariance = top.find("covariance");
  if (!covariance) {
    for (const char* key : {"claim_covariance", "claim_model"})
      if (const auto value = top.find(key))
        value->fail_plainly("needs the key covariance, which is missing");
    return;
  }
  if (file.model.empty()) covariance->fail_plainly("needs the key model, which is missing");
  const HeldModels models(file.fixed, Model::named(file.model).kind());
  const Model& model = models.named(file.model);
  file.covariance = covariance_of(top, *covariance, model, "covariance_names");
  if (!file.sigmas.empty()) check_sigmas(top, model, file);
  read_claim(top, *covariance, model, file);
}

// Files of other programs may mean something else by a key: only a list of texts is taken.
std::vector<std::string> texts_of(const YamlValue& top, std::string_view key) {
  std::vector<std::string> texts;
  const auto list = top.find(key);
  if (!list || !list->is_list()) return texts;
  for (const YamlValue& item : list->items(0, kMostTexts))
    if (item.is_scalar()) texts.push_back(item.text());
  return texts;
}

// Older files have the sentences only.
void read_findings(const YamlValue& top, CalibrationFile& file) {
  std::vector<std::string> codes = texts_of(top, "warning_codes");
  std::vector<std::string> severities = texts_of(top, "warning_severities");
  const std::vector<std::string> sentences = texts_of(top, "warnings");
  codes.resize(sentences.size());
  severities.resize(sentences.size());
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    const bool is_note = severities[i] == severity_name(Severity::note);
    file.findings.push_back({codes[i], is_note ? Severity::note : Severity::warning, sentences[i]});
  }
}

void read_uncertainty(const YamlValue& top, CalibrationFile& file) {
  read_findings(top, file);
  const std::size_t num_parameters = parameters(file.camera.lens).size();
  file.fixed = fixed_values(top);
  if (const auto sigmas = top.find("sigmas")) {
    check_names(top, "parameter_names", parameter_names(file.camera.lens), "");
    file.sigmas = read_row(*sigmas);
    if (file.sigmas.size() != num_parameters) {
      sigmas->fail_plainly(
          fmt::format("must have {} values, got {}", num_parameters, file.sigmas.size()));
    }
    for (const double sigma : file.sigmas) {
      if (sigma < 0) sigmas->fail_plainly(fmt::format("must be >= 0, got {}", sigma));
    }
  }
  read_covariance(top, file);
  if (const auto error = top.find("camera_error_px")) file.camera_error_px = error->not_negative();
  if (const auto region = top.find("seen_region")) {
    const Eigen::MatrixXd corners = read_matrix(*region);
    if (corners.rows() < 3 || corners.cols() != 2)
      region->fail_plainly(
          fmt::format("must be 3 or more x 2, got {} x {}", corners.rows(), corners.cols()));
    std::vector<Eigen::Vector2d> pixels;
    for (const auto& row : corners.rowwise()) pixels.emplace_back(row.transpose());
    file.seen = SeenRegion(file.camera.image_size, pixels);
  }
}

// The keys of a file: those of the sample program, of the same before OpenCV 3, and of people who
// name them after OpenCV's arguments.
struct Keys {
  std::string_view width = "image_width";
  std::string_view height = "image_height";
  std::string_view matrix = "camera_matrix";
  std::string_view distortion = "distortion_coefficients";
};

Keys keys_of(const YamlValue& top) {
  const auto first = [&](std::initializer_list<std::string_view> names) {
    std::string_view found;
    for (const std::string_view name : names) {
      if (!top.find(name)) continue;
      if (!found.empty())
        top.at(name).fail_plainly(fmt::format("is given beside {}: only one is possible", found));
      found = name;
    }
    return found.empty() ? *names.begin() : found;
  };
  return {
      first({"image_width", "image_Width"}), first({"image_height", "image_Height"}),
      first({"camera_matrix", "Camera_Matrix", "cameraMatrix"}),
      first({"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs"})};
}

// 0 x 0 if the file has none.
ImageSize read_size(const YamlValue& top, const Keys& keys) {
  if (!top.find(keys.width) && !top.find(keys.height)) return {};
  return {top.at(keys.width).whole(1, limits::kMaxSidePx),
          top.at(keys.height).whole(1, limits::kMaxSidePx)};
}

CalibrationFile read_camera(const YamlValue& top, const Keys& keys,
                            std::vector<std::string>& notes) {
  CameraNumbers numbers;
  numbers.image_size = read_size(top, keys);
  const auto name = top.find("model");
  const Model* model = name ? &read_model(*name) : nullptr;
  const bool marked = is_marked_fisheye(top);
  const Model& named = model ? *model : Model::named(marked ? "fisheye4" : "opencv8");
  if (marked && &named.kind() != &kind_of<Fisheye>())
    name->fail("must be fisheye4 with a key that says that it is a fisheye");
  read_camera_matrix(top.at(keys.matrix), numbers);
  numbers.distortion = read_distortion(top.at(keys.distortion), named.kind(), notes);
  return {camera_of(top, numbers, named), model ? std::string(model->name()) : "", {}, {}, {}, {}};
}

// tagcal's.
void read_views(const YamlValue& views, CameraFile& file) {
  std::set<std::string> names;
  for (const YamlValue& view : views.items(0, limits::kMaxListedPoses)) {
    const std::vector<double> q = view.at("rotation").numbers(4);
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (!(std::abs(rotation.norm() - 1) <= kRotationTolerance))
      view.at("rotation")
          .fail_plainly(fmt::format(
              "must be a unit quaternion [w, x, y, z], got one of length {:.6g}", rotation.norm()));
    file.poses.push_back(
        {read_image_name(view.at("image"), names), 0,
         Pose(rotation, Eigen::Vector3d::Map(view.at("translation_m").numbers(3).data()))});
  }
}

// OpenCV's sample program: a rotation vector and a translation per picture, without its name.
void read_extrinsics(const YamlValue& value, CameraFile& file) {
  const Eigen::MatrixXd rows = read_matrix(value);
  if (rows.cols() != 6)
    value.fail_plainly(
        fmt::format("must have 6 columns (rotation vector, translation), got {}", rows.cols()));
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Eigen::RowVectorXd row = rows.row(i);
    file.poses.push_back({view_name(static_cast<std::size_t>(i)), 0,
                          Pose(exp_rotation(row.head<3>().transpose()), row.tail<3>())});
  }
  file.notes.push_back(
      fmt::format("extrinsic_parameters has no names of pictures: they are view0000 to {}",
                  file.poses.back().image));
}

// A stereo pair by OpenCV's stereo_calib: intrinsics.yml.
CameraFile read_stereo(const YamlValue& top) {
  CameraFile file;
  file.format = "opencv";
  for (const auto& [name, matrix, distortion] :
       {std::array{"left", "M1", "D1"}, std::array{"right", "M2", "D2"}}) {
    const Keys keys{"image_width", "image_height", matrix, distortion};
    FileCamera camera;
    camera.name = name;
    camera.calibration = read_camera(top, keys, file.notes);
    file.cameras.push_back(std::move(camera));
  }
  if (!top.find("R") || !top.find("T")) return file;
  const Eigen::MatrixXd r = read_matrix(top.at("R")), t = read_matrix(top.at("T"));
  if (r.rows() != 3 || r.cols() != 3) top.at("R").fail_plainly("must be 3 x 3");
  if (t.size() != 3) top.at("T").fail_plainly("must have 3 values");
  file.cameras[0].camera_from_rig = Pose();
  try {
    file.cameras[1].camera_from_rig = Pose(rotation_from_matrix(r, "R"), {t(0), t(1), t(2)});
  } catch (const Error& error) {
    top.at("R").fail_plainly(error.what());
  }
  return file;
}

}  // namespace

Eigen::MatrixXd read_matrix(const YamlValue& value) {
  const int rows = value.at("rows").whole(1, limits::kMaxMatrixSide);
  const int cols = value.at("cols").whole(1, limits::kMaxMatrixSide);
  const auto type = value.find("dt");
  const bool pixels = type && type->text().starts_with("2");  // two numbers an element
  const YamlValue data = value.at("data");
  const std::size_t per_row = static_cast<std::size_t>(cols) * (pixels ? 2 : 1);
  const std::vector<double> numbers = data.numbers(static_cast<std::size_t>(rows) * per_row);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return RowMajor::Map(numbers.data(), rows, static_cast<Eigen::Index>(per_row));
}

bool has_opencv_keys(const YamlValue& top) {
  constexpr std::string_view kKeys[] = {"camera_matrix",
                                        "Camera_Matrix",
                                        "cameraMatrix",
                                        "image_width",
                                        "image_height",
                                        "distortion_coefficients",
                                        "M1"};
  return std::ranges::any_of(kKeys,
                             [&](std::string_view key) { return top.find(key).has_value(); });
}

CameraFile read_opencv(const YamlValue& top) {
  if (top.find("M1")) return read_stereo(top);
  CameraFile file;
  FileCamera camera;
  camera.calibration = read_camera(top, keys_of(top), file.notes);
  read_uncertainty(top, camera.calibration);
  if (const auto name = top.find("camera_name")) camera.name = name->text();
  file.cameras.push_back(std::move(camera));
  if (const auto views = top.find("views"); views && top.find("model")) read_views(*views, file);
  if (const auto rows = top.find("extrinsic_parameters")) {
    if (!file.poses.empty()) rows->fail_plainly("is given beside views: only one is possible");
    read_extrinsics(*rows, file);
  }
  const bool ros = top.find("distortion_model") || top.find("camera_name");
  file.format = top.find("model") ? "tagcal" : ros ? "ros" : "opencv";
  if (ros && top.find("projection_matrix"))
    file.notes.emplace_back("dropped: rectification_matrix and projection_matrix");
  return file;
}

}  // namespace tagcal::internal
