#include <fmt/format.h>

#include <algorithm>

#include "tagcal/camera/model.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;

namespace {

struct TruthCamera {
  Camera camera;
  std::string model;
};

// [[sx, 0, sx ox, cx], [0, sy, sy oy, cy]], from homogeneous points in the camera frame to pixels.
Parallel read_parallel(const YamlValue& value) {
  const std::vector<YamlValue> rows = value.items(2, 2);
  const std::vector<double> u = rows[0].numbers(4), v = rows[1].numbers(4);
  if (!(u[0] > 0 && v[1] > 0 && u[1] == 0 && v[0] == 0))
    value.fail_plainly("must be [[sx, 0, ., .], [0, sy, ., .]] with sx, sy > 0");
  return Parallel({u[0], v[1], u[3], v[3], u[2] / u[0], v[2] / v[1]});
}

std::string parallel_yaml(const Parallel& lens) {
  const auto& p = lens.parameters();
  return fmt::format("  image_from_camera: [[{}, 0, {}, {}], [0, {}, {}, {}]]\n", p[0], p[0] * p[4],
                     p[2], p[1], p[1] * p[5], p[3]);
}

CameraNumbers read_numbers(const YamlValue& camera, const ImageSize& size) {
  CameraNumbers numbers;
  numbers.image_size = size;
  numbers.fx = camera.at("fx").positive();
  numbers.fy = camera.at("fy").positive();
  numbers.cx = camera.at("cx").number();
  numbers.cy = camera.at("cy").number();
  if (const auto distortion = camera.find("distortion"))
    numbers.distortion = distortion->numbers(0, 8);
  return numbers;
}

TruthCamera read_truth_camera(const YamlValue& camera) {
  const YamlValue model_name = camera.at("model");
  if (model_name.text() == kParallelModel)
    camera.allow_only({"image_width", "image_height", "model", "image_from_camera"});
  else
    camera.allow_only(
        {"image_width", "image_height", "model", "fx", "fy", "cx", "cy", "distortion"});
  const ImageSize size{camera.at("image_width").whole(1, limits::kMaxSidePx),
                       camera.at("image_height").whole(1, limits::kMaxSidePx)};
  if (model_name.text() == kParallelModel)
    return {{read_parallel(camera.at("image_from_camera")), size}, kParallelModel};
  const Model& model = read_model(model_name);
  return {make_camera(read_numbers(camera, size), model, camera), std::string(model.name())};
}

std::string camera_yaml(const Truth& truth) {
  const std::string model = truth.model.empty() ? smallest_model(truth.camera) : truth.model;
  const std::string head =
      fmt::format("camera:\n  image_width: {}\n  image_height: {}\n  model: {}\n",
                  truth.camera.image_size.width, truth.camera.image_size.height, text_yaml(model));
  if (const auto* parallel = std::get_if<Parallel>(&truth.camera.lens))
    return head + parallel_yaml(*parallel);
  const std::span<const double> values = parameters(truth.camera.lens);
  return head + fmt::format("  fx: {}\n  fy: {}\n  cx: {}\n  cy: {}\n  distortion: {}\n", values[0],
                            values[1], values[2], values[3],
                            list_yaml(distortion_of(truth.camera.lens, model)));
}

// A rigid transform as a pose, another one as a 4x4 matrix by rows.
std::string transform_yaml(const Affine& transform) {
  try {
    return pose_yaml(rigid(transform));
  } catch (const Error&) {
    const Eigen::Matrix4d m = transform.matrix();
    std::string rows;
    for (int r = 0; r < 4; ++r)
      rows += fmt::format("{}[{}, {}, {}, {}]", r ? ", " : "", m(r, 0), m(r, 1), m(r, 2), m(r, 3));
    return "[" + rows + "]";
  }
}

// A name as the key of a line. YAML's plain keys end after 1024 characters, those after a `?` do
// not.
std::string key_yaml(std::string_view name, std::string_view indent) {
  constexpr std::size_t kMaxPlainKey = 1000;
  const std::string key = text_yaml(name);
  return key.size() <= kMaxPlainKey ? fmt::format("{}{}: ", indent, key)
                                    : fmt::format("{}? {}\n{}: ", indent, key, indent);
}

std::string hierarchy_yaml(const HierarchyTruth& hierarchy) {
  std::string text = "    camera_from_frame:\n";
  for (const auto& [name, transform] : hierarchy.camera_from_frame)
    text += key_yaml(name, "      ") + transform_yaml(transform) + "\n";
  text += "    camera_from_board:\n";
  for (const Pose& pose : hierarchy.camera_from_board)
    text += fmt::format("      - {}\n", pose_yaml(pose));
  return text;
}

Affine read_transform(const YamlValue& value) {
  return value.is_list() ? Affine(read_affine_matrix(value)) : affine(read_pose(value));
}

HierarchyTruth read_hierarchy(const YamlValue& item) {
  HierarchyTruth hierarchy;
  for (const auto& [name, value] : item.at("camera_from_frame").members())
    hierarchy.camera_from_frame[name] = read_transform(value);
  for (const YamlValue& pose : item.at("camera_from_board").items(0, limits::kMaxBoards))
    hierarchy.camera_from_board.push_back(read_pose(pose));
  return hierarchy;
}

void read_view(const YamlValue& item, Truth& truth) {
  item.allow_only({"image", "camera_from_world", "camera_from_frame", "camera_from_board", "fx",
                   "fy", "cx", "cy"});
  const YamlValue image = item.at("image");
  const Pose pose = read_pose(item.at("camera_from_world"));
  if (!truth.camera_from_world.emplace(image.text(), pose).second)
    image.fail("must differ from the images before it");
  if (item.find("camera_from_frame")) truth.hierarchy[image.text()] = read_hierarchy(item);
  constexpr std::string_view kNumbers[] = {"fx", "fy", "cx", "cy"};
  if (std::ranges::none_of(kNumbers, [&](auto key) { return item.find(key).has_value(); })) return;
  const CameraNumbers numbers = read_numbers(item, truth.camera.image_size);
  truth.lenses.emplace(image.text(), pinhole(numbers.fx, numbers.fy, numbers.cx, numbers.cy));
}

std::size_t num_transforms_of(const Truth& truth, const std::string& image) {
  const auto found = truth.hierarchy.find(image);
  if (found == truth.hierarchy.end()) return 0;
  return found->second.camera_from_frame.size() + found->second.camera_from_board.size();
}

}  // namespace

std::string smallest_model(const Camera& camera) {
  if (!kind_of(camera.lens).is_central) return kParallelModel;
  // One has all parameters of the lens.
  return std::string(std::ranges::find_if(Model::all(), [&](const Model& model) {
                       return model.contains(camera);
                     })->name());
}

Truth read_truth(const std::filesystem::path& file) {
  const YamlValue top = YamlValue::read(file);
  top.allow_only({"camera", "poses"});
  const TruthCamera camera = read_truth_camera(top.at("camera"));
  Truth truth{camera.camera, camera.model, {}, {}, {}};
  std::size_t num_transforms = 0;  // an alias in the file is a copy of all of them here
  if (const auto poses = top.find("poses"))
    for (const YamlValue& item : poses->items(0, limits::kMaxListedPoses)) {
      read_view(item, truth);
      num_transforms += num_transforms_of(truth, item.at("image").text());
      if (num_transforms > limits::kMaxListedPoses)
        poses->fail_plainly(fmt::format("the views have more than {} frames and boards in all",
                                        limits::kMaxListedPoses));
    }
  return truth;
}

void write_truth(const std::filesystem::path& file, const Truth& truth) {
  std::string text = camera_yaml(truth);
  text += truth.camera_from_world.empty() ? "poses: []\n" : "poses:\n";
  for (const auto& [image, pose] : truth.camera_from_world) {
    const auto hierarchy = truth.hierarchy.find(image);
    const auto lens = truth.lenses.find(image);
    if (hierarchy == truth.hierarchy.end() && lens == truth.lenses.end()) {
      text += fmt::format("  - {{image: {}, camera_from_world: {}}}\n", text_yaml(image),
                          pose_yaml(pose));
      continue;
    }
    text += fmt::format("  - image: {}\n    camera_from_world: {}\n", text_yaml(image),
                        pose_yaml(pose));
    if (lens != truth.lenses.end()) {
      const std::span<const double> p = parameters(lens->second);
      text +=
          fmt::format("    fx: {}\n    fy: {}\n    cx: {}\n    cy: {}\n", p[0], p[1], p[2], p[3]);
    }
    if (hierarchy != truth.hierarchy.end()) text += hierarchy_yaml(hierarchy->second);
  }
  write_whole(file, text);
}

}  // namespace tagcal
