#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

struct LensModel {
  std::string_view name;
  std::size_t num_parameters;
};
constexpr std::array<LensModel, 5> kLensModels = {{{"LENSMODEL_PINHOLE", 4},
                                                   {"LENSMODEL_OPENCV4", 8},
                                                   {"LENSMODEL_OPENCV5", 9},
                                                   {"LENSMODEL_OPENCV8", 12},
                                                   {"LENSMODEL_OPENCV12", 16}}};
// From the newest to the oldest.
constexpr std::array<std::string_view, 3> kLensKeys = {"lensmodel", "lens_model",
                                                       "distortion_model"};
constexpr std::string_view kWhitespace = " \t\r\n";

// The quote that ends the text that begins at `first`, or the end of everything.
std::size_t closing_quote(std::string_view text, std::size_t first) {
  std::size_t i = first + 1;
  while (i < text.size() && text[i] != text[first]) i += text[i] == '\\' ? 2 : 1;
  return std::min(i, text.size());
}

// The dictionary as a YAML flow map, which it is but for comments and its strings of bytes
// (b'...'): they are emptied, because they hold any punctuation.
std::string as_yaml(std::string_view text) {
  std::string yaml;
  bool comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') comment = false;
    if (c == '#') comment = true;
    if (comment) continue;
    if (c != '\'' && c != '"') {
      yaml += c;
      continue;
    }
    const bool bytes = yaml.ends_with('b');
    if (bytes) yaml.pop_back();
    const std::size_t end = closing_quote(text, i);
    yaml += bytes ? "''" : std::string(text.substr(i, end + 1 - i));
    i = end;
  }
  return yaml;
}

YamlValue lens_name(const YamlValue& top) {
  for (const std::string_view key : kLensKeys)
    if (const auto value = top.find(key)) return *value;
  return top.at("lensmodel");
}

Lens read_lens(const YamlValue& top, std::vector<std::string>& notes) {
  const YamlValue model = lens_name(top);
  std::string name = model.text();
  if (name.starts_with("DISTORTION")) name.replace(0, 10, "LENSMODEL");
  const auto kind = std::ranges::find(
      kLensModels, name == "LENSMODEL_NONE" ? "LENSMODEL_PINHOLE" : name, &LensModel::name);
  if (kind == kLensModels.end())
    model.fail_plainly(fmt::format("the lens {} is one that tagcal does not have", shown(name)));
  const YamlValue intrinsics = top.at("intrinsics");
  std::vector<double> p = intrinsics.numbers(kind->num_parameters);
  for (std::size_t i = 12; i < p.size(); ++i)
    if (p[i] != 0)
      intrinsics.fail_plainly(fmt::format(
          "the lens {} has a thin prism, which tagcal does not have: value {} must be 0, got {}",
          name, i + 1, p[i]));
  if (p.size() > 12) {
    p.resize(12);
    notes.emplace_back("dropped: 4 coefficients of thin prism, which are 0");
  }
  return lens_of(kind_of<Perspective>(), p, place(top, "intrinsics"));
}

std::optional<Pose> read_extrinsics(const YamlValue& top) {
  auto value = top.find("rt_cam_ref");
  if (!value) value = top.find("extrinsics");
  if (!value) return std::nullopt;
  const std::vector<double> rt = value->numbers(6);
  return Pose(exp_rotation({rt[0], rt[1], rt[2]}), {rt[3], rt[4], rt[5]});
}

// A key of the lens' name, before `rest` of the dictionary. ROS has the last one, too.
bool names_lens(std::string_view key, std::string_view rest) {
  if (std::ranges::find(kLensKeys, key) == kLensKeys.end()) return false;
  const std::size_t colon = rest.find_first_not_of(kWhitespace);
  if (colon == rest.npos || rest[colon] != ':') return false;
  const std::size_t value = rest.find_first_not_of(kWhitespace, colon + 1);
  return key != kLensKeys.back() ||
         (value != rest.npos && rest.substr(value + 1).starts_with("DISTORTION_"));
}

}  // namespace

bool is_mrcal_model(std::string_view text) {
  const std::string yaml = as_yaml(text.substr(0, 4096));
  const std::size_t first = yaml.find_first_not_of(kWhitespace);
  if (first == std::string::npos || yaml[first] != '{') return false;
  // Names of pictures in other formats may contain anything: only whole texts are keys.
  for (std::size_t i = yaml.find_first_of("'\""); i < yaml.size();) {
    const std::size_t end = closing_quote(yaml, i);
    const std::string_view key = std::string_view(yaml).substr(i + 1, end - i - 1);
    i = yaml.find_first_of("'\"", std::min(end + 1, yaml.size()));
    if (names_lens(key, std::string_view(yaml).substr(std::min(end + 1, yaml.size())))) return true;
  }
  return false;
}

CameraFile read_mrcal(const CameraText& model) {
  const YamlValue top = YamlValue::parse(as_yaml(model.text), model.path.string());
  CameraFile file;
  file.format = "mrcal";
  const YamlValue size = top.at("imagersize");
  const Lens lens = read_lens(top, file.notes);
  file.cameras.push_back(file_camera("", lens, read_image_size_value(size)));
  file.cameras.front().camera_from_rig = read_extrinsics(top);
  if (top.find("optimization_inputs"))
    file.notes.emplace_back("dropped: optimization_inputs, from which mrcal knows the uncertainty");
  if (top.find("valid_intrinsics_region"))
    file.notes.emplace_back("dropped: valid_intrinsics_region");
  return file;
}

FormatOutput write_mrcal(const CameraFile& file) {
  const FileCamera& camera = only_camera(file, "mrcal");
  const std::span<const double> p = perspective_numbers(camera, "mrcal", "opencv8");
  const auto zero_from = [&](std::size_t first) {
    return std::all_of(p.begin() + static_cast<std::ptrdiff_t>(first), p.end(),
                       [](double k) { return k == 0; });
  };
  const auto kind = std::ranges::find_if(kLensModels, [&](const LensModel& k) {
    return k.num_parameters >= 12 || zero_from(k.num_parameters);
  });
  const auto list = [](std::span<const double> values) {
    std::string text;
    for (const double value : values) text += fmt::format(" {},", dotted_number(value));
    return text;
  };
  const Pose pose = camera.camera_from_rig.value_or(Pose());
  Eigen::Matrix<double, 6, 1> rt;
  rt << log_rotation(pose.rotation()), pose.translation();
  const ImageSize& size = camera.calibration.camera.image_size;
  FormatOutput output;
  output.files = {{"", fmt::format("{{\n    'lensmodel':  '{}',\n\n"
                                   "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
                                   "    'intrinsics': [{}],\n\n    # extrinsics are rt_fromref\n"
                                   "    'extrinsics': [{}],\n\n    'imagersize': [ {}, {},],\n}}\n",
                                   kind->name, list(p.first(kind->num_parameters)),
                                   list({rt.data(), 6}), size.width, size.height)}};
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
