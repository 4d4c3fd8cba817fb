#include "tagcal/io/formats/opencv_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

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
  const HeldModels models = top.within([&] { return HeldModels(values, model.kind()); });
  const Model& held = models.named(model.name());
  check_fixed(*fixed, held, numbers);
  return make_camera(numbers, held, top);
}

// 0 x 0 if the file has none.
ImageSize read_size(const YamlValue& top, const OpencvKeys& keys) {
  if (!top.find(keys.width) && !top.find(keys.height)) return {};
  return {top.at(keys.width).whole(1, limits::kMaxSidePx),
          top.at(keys.height).whole(1, limits::kMaxSidePx)};
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

std::vector<double> read_row(const YamlValue& value) {
  const Eigen::MatrixXd matrix = read_matrix(value);
  if (matrix.rows() != 1 && matrix.cols() != 1) {
    value.fail_plainly(
        fmt::format("must have one row or one column, got {} x {}", matrix.rows(), matrix.cols()));
  }
  return {matrix.data(), matrix.data() + matrix.size()};
}

std::map<std::string, double> fixed_values(const YamlValue& top) {
  std::map<std::string, double> fixed;
  if (const auto values = top.find("fixed"))
    for (const auto& [name, value] : values->members()) fixed.emplace(shown(name), value.number());
  return fixed;
}

OpencvKeys opencv_keys_of(const YamlValue& top) {
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

CalibrationFile read_opencv_camera(const YamlValue& top, const OpencvKeys& keys,
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

}  // namespace tagcal::internal
