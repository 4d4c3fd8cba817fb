#include <fmt/format.h>

#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/text/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;

Truth read_truth(const std::filesystem::path& file) {
  const YamlValue top = YamlValue::read(file);
  top.allow_only({"camera", "poses"});
  const YamlValue camera = top.at("camera");
  camera.allow_only({"image_width", "image_height", "model", "fx", "fy", "cx", "cy", "distortion"});
  const Model& model = read_model(camera.at("model"));
  CameraNumbers numbers;
  numbers.image_size = {camera.at("image_width").whole(1, 100'000),
                        camera.at("image_height").whole(1, 100'000)};
  numbers.fx = camera.at("fx").positive();
  numbers.fy = camera.at("fy").positive();
  numbers.cx = camera.at("cx").number();
  numbers.cy = camera.at("cy").number();
  if (const auto distortion = camera.find("distortion")) {
    numbers.distortion = distortion->numbers(0, 8);
  }
  Truth truth{make_camera(numbers, model, camera), std::string(model.name()), {}};
  const auto poses = top.find("poses");
  if (!poses) return truth;
  for (const YamlValue& item : poses->items(0, 1'000'000)) {
    item.allow_only({"image", "camera_from_world"});
    const YamlValue image = item.at("image");
    const Pose pose = read_pose(item.at("camera_from_world"));
    if (!truth.camera_from_world.emplace(image.text(), pose).second) {
      image.fail("must differ from the images before it");
    }
  }
  return truth;
}

void write_truth(const std::filesystem::path& file, const Truth& truth) {
  const std::span<const double> values = parameters(truth.camera.lens);
  std::string text = fmt::format(
      "camera:\n  image_width: {}\n  image_height: {}\n  model: {}\n  fx: {}\n  fy: {}\n  cx: {}\n"
      "  cy: {}\n  distortion: {}\n",
      truth.camera.image_size.width, truth.camera.image_size.height, text_yaml(truth.model),
      values[0], values[1], values[2], values[3],
      list_yaml(distortion_of(truth.camera.lens, truth.model)));
  text += truth.camera_from_world.empty() ? "poses: []\n" : "poses:\n";
  for (const auto& [image, pose] : truth.camera_from_world) {
    text += fmt::format("  - {{image: {}, camera_from_world: {}}}\n", text_yaml(image),
                        pose_yaml(pose));
  }
  write_whole(file, text);
}

}  // namespace tagcal
