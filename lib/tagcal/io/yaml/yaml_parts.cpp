#include "tagcal/io/yaml/yaml_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "tagcal/internal/text.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

Pose read_rigid_matrix(const YamlValue& value) {
  const Eigen::Matrix4d matrix = read_affine_matrix(value);
  return value.within([&] {
    return Pose(rotation_from_matrix(matrix.topLeftCorner<3, 3>(), "the upper left 3x3"),
                matrix.topRightCorner<3, 1>());
  });
}

std::vector<int> held_parameters(const Model& model, int num_parameters) {
  std::vector<int> held;
  for (int i = 0; i < num_parameters; ++i) {
    const bool is_free = std::any_of(model.free().begin(), model.free().end(), [&](const auto& p) {
      return std::find(p.lens_parameters.begin(), p.lens_parameters.end(), i) !=
             p.lens_parameters.end();
    });
    if (!is_free) held.push_back(i);
  }
  return held;
}

// Throws if the model cannot represent the lens.
void check_held(const Lens& lens, const ImageSize& size, const Model& model,
                const YamlValue& where) {
  const std::span<const double> values = parameters(lens);
  const Eigen::Vector2d centre = image_centre(size);
  for (const int i : held_parameters(model, static_cast<int>(values.size()))) {
    const auto fixed = model.held().find(i);
    const double held_at = fixed != model.held().end() ? fixed->second
                           : i == 2                    ? centre.x()
                           : i == 3                    ? centre.y()
                                    : kind_of(lens).parameters[static_cast<std::size_t>(i)].plain;
    const double value = values[static_cast<std::size_t>(i)];
    if (value == held_at) continue;
    where.fail_plainly(fmt::format("{} must be {} with model {}, got {}",
                                   parameter_names(lens)[static_cast<std::size_t>(i)], held_at,
                                   model.name(), value));
  }
  for (const FreeParameter& parameter : model.free()) {
    if (parameter.lens_parameters.size() > 1 && values[0] != values[1]) {
      where.fail_plainly(fmt::format("fx and fy must be equal with model {}, got {} and {}",
                                     model.name(), values[0], values[1]));
    }
  }
}

}  // namespace

Eigen::Vector3d read_vector(const YamlValue& value) {
  return Eigen::Vector3d::Map(value.numbers(3).data());
}

Eigen::Quaterniond read_rotation(const YamlValue& value) {
  const std::vector<double> q = value.numbers(4);
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(std::abs(rotation.norm() - 1) <= kRotationTolerance))
    value.fail_plainly(fmt::format(
        "must be a unit quaternion [w, x, y, z], got one of length {:.6g}", rotation.norm()));
  return rotation;
}

Eigen::Matrix4d read_affine_matrix(const YamlValue& value) {
  Eigen::Matrix4d matrix;
  int row = 0;
  for (const YamlValue& item : value.items(4, 4)) {
    const std::vector<double> numbers = item.numbers(4);
    matrix.row(row++) = Eigen::RowVector4d::Map(numbers.data());
  }
  if ((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-9) {
    value.fail_plainly("the last row must be [0, 0, 0, 1]");
  }
  return matrix;
}

Pose read_pose(const YamlValue& value) {
  if (value.is_list()) return read_rigid_matrix(value);
  value.allow_only({"rotation", "translation_m"});
  const auto rotation = value.find("rotation"), translation = value.find("translation_m");
  return {rotation ? read_rotation(*rotation) : Eigen::Quaterniond::Identity(),
          translation ? read_vector(*translation) : Eigen::Vector3d::Zero()};
}

std::string pose_yaml(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  return fmt::format("{{rotation: [{}, {}, {}, {}], translation_m: [{}, {}, {}]}}", q.w(), q.x(),
                     q.y(), q.z(), t.x(), t.y(), t.z());
}

std::string list_yaml(std::span<const double> values) {
  return fmt::format("[{}]", fmt::join(values, ", "));
}

std::string text_yaml(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += byte < 0x20 || byte == 0x7f ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
  }
  return quoted + '"';
}

std::string read_image_name(const YamlValue& value, std::set<std::string>& names) {
  std::string name = value.text();
  if (!names.insert(name).second) value.fail("must differ from the names before it");
  return name;
}

ImageSize read_image_size_value(const YamlValue& value) {
  const std::vector<YamlValue> items = value.items(2, 2);
  return {items[0].whole(1, limits::kMaxSidePx), items[1].whole(1, limits::kMaxSidePx)};
}

const Model& read_model(const YamlValue& value) {
  const std::string name = value.text();
  std::string known;
  for (const Model& model : Model::all()) {
    if (!model.kind().is_central) continue;
    if (model.name() == name) return model;
    known += (known.empty() ? "" : ", ") + std::string(model.name());
  }
  value.fail("must be one of " + known);
}

Camera make_camera(const CameraNumbers& numbers, const Model& model, const YamlValue& where) {
  std::vector<double> values = {numbers.fx, numbers.fy, numbers.cx, numbers.cy};
  const std::span<const LensParameter> all = model.kind().parameters;
  if (numbers.distortion.size() > all.size() - values.size()) {
    where.fail_plainly(
        fmt::format("distortion: must have at most {} coefficients with model {}, got {}",
                    all.size() - values.size(), model.name(), numbers.distortion.size()));
  }
  values.insert(values.end(), numbers.distortion.begin(), numbers.distortion.end());
  while (values.size() < all.size()) values.push_back(all[values.size()].plain);
  const Lens lens = where.within([&] { return make_lens(model.kind(), values); });
  check_held(lens, numbers.image_size, model, where);
  return {lens, numbers.image_size};
}

std::vector<double> distortion_of(const Lens& lens, std::string_view model) {
  const LensKind& kind = kind_of(lens);
  if (!kind.is_central) return {};
  const Model& full = full_model(lens);
  const Model& largest = full.sibling(kind, ModelRole::largest);
  const int n = (model == largest.name() ? largest : full).num_free();
  const std::span<const double> all = parameters(lens);
  return {all.begin() + 4, all.begin() + n};
}

}  // namespace tagcal::internal
