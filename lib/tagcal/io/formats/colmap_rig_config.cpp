#include "tagcal/io/formats/colmap.hpp"

#include <fmt/format.h>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostParameters = 16;  // of any lens of COLMAP

// The folder's last part: "rig1/left/" is "left".
std::string name_of_prefix(std::string prefix) {
  while (prefix.size() > 1 && prefix.ends_with('/')) prefix.pop_back();
  return prefix.substr(prefix.rfind('/') + 1);
}

std::optional<Pose> read_place(const YamlValue& camera) {
  const auto reference = camera.find("ref_sensor");
  const bool is_reference = reference && reference->truth();
  const auto rotation = camera.find("cam_from_rig_rotation");
  const auto translation = camera.find("cam_from_rig_translation");
  if (is_reference && (rotation || translation))
    (rotation ? *rotation : *translation)
        .fail_plainly("is given for the reference (ref_sensor), whose place is the rig's frame");
  if (is_reference) return Pose();
  if (!rotation && !translation) return std::nullopt;
  const std::vector<double> q = camera.at("cam_from_rig_rotation").numbers(4);
  return place_of_quaternion({q[0], q[1], q[2], q[3]},
                             read_vector(camera.at("cam_from_rig_translation")), *rotation);
}

FileCamera read_item(const YamlValue& item) {
  const YamlValue model = item.at("camera_model_name"), values = item.at("camera_params");
  const std::string where = place(item, "camera_params");
  FileCamera camera =
      file_camera(name_of_prefix(item.at("image_prefix").text()),
                  colmap_lens(model.text(), values.numbers(1, kMostParameters), where), {});
  camera.camera_from_rig = read_place(item);
  return camera;
}

std::string item_json(const FileCamera& camera, const std::string& name,
                      const Pose* camera_from_rig) {
  const ColmapLens lens = lens_of_colmap(camera);
  std::string text =
      fmt::format("      {{\n        \"image_prefix\": {},\n", json_text(name + "/"));
  if (!camera_from_rig) {
    text += "        \"ref_sensor\": true,\n";
  } else {
    const Eigen::Quaterniond q = camera_from_rig->rotation();
    const double rotation[] = {q.w(), q.x(), q.y(), q.z()};
    text += fmt::format(
        "        \"cam_from_rig_rotation\": {},\n        \"cam_from_rig_translation\": {},\n",
        dotted_list(rotation), dotted_list({camera_from_rig->translation().data(), 3}));
  }
  return text + fmt::format(
                    "        \"camera_model_name\": \"{}\",\n        \"camera_params\": {}\n"
                    "      }}",
                    lens.name, dotted_list(lens.values));
}

}  // namespace

bool is_rig_config(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '[' &&
         text.find("\"cameras\"") != std::string_view::npos &&
         text.find("\"image_prefix\"") != std::string_view::npos;
}

CameraFile read_rig_config(const CameraText& config) {
  // A file is a map elsewhere; this one is a list of rigs.
  const YamlValue top = YamlValue::parse("{\"rigs\": " + config.text + "\n}", config.path.string());
  CameraFile file;
  file.format = "colmap";
  const auto rigs = top.at("rigs").items(1, limits::kMaxRigCameras);
  if (rigs.size() > 1)
    rigs[1].fail_plainly("is a second rig: tagcal takes one a file, remove the others");
  for (const YamlValue& item : rigs[0].at("cameras").items(1, limits::kMaxRigCameras))
    file.cameras.push_back(read_item(item));
  file.notes.emplace_back(
      "pixel centres are at (0.5, 0.5) in COLMAP and (0, 0) here: cx and cy became 0.5 smaller");
  return file;
}

std::string rig_config_text(const CameraFile& file, const ColmapRig& rig) {
  std::string items;
  for (std::size_t i = 0; i < file.cameras.size(); ++i)
    items +=
        (i == 0 ? "" : ",\n") + item_json(file.cameras[i], camera_name(file, i),
                                          i == rig.reference ? nullptr : &rig.camera_from_rig[i]);
  return fmt::format("[\n  {{\n    \"cameras\": [\n{}\n    ]\n  }}\n]\n", items);
}

FormatOutput write_rig_config(const CameraFile& file) {
  const std::optional<ColmapRig> rig = colmap_rig(file);
  if (!rig) throw Error("rig_config.json needs several cameras and their places in a rig");
  FormatOutput output;
  output.files = {{"", rig_config_text(file, *rig)}};
  output.notes.emplace_back(
      "pixel centres are at (0.5, 0.5) in COLMAP and (0, 0) here: cx and cy became 0.5 larger");
  output.notes.emplace_back(
      "dropped: the sizes of the pictures, which rig_config.json has no key for");
  note_reference(file, *rig, output.notes);
  note_no_uncertainty(file, output.notes);
  note_no_poses(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
