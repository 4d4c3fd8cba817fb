#include "tagcal/io/scene/scene_parts.hpp"

#include <algorithm>
#include <cctype>
#include <set>

#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

// The name of a camera is that of its folder.
std::string read_folder_name(const YamlValue& value) {
  constexpr std::size_t kMostCharacters = 64;
  const std::string name = value.text();
  const bool is_plain = std::ranges::all_of(name, [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '-' || c == '_');
  });
  if (!is_plain || name.size() > kMostCharacters)
    value.fail("names a folder: must be at most 64 letters, digits, - and _");
  return name;
}

RigSceneCamera read_rig_camera(const YamlValue& value, const std::optional<YamlValue>& shared) {
  value.allow_only({"name", "camera", "rig_from_camera", "time_offset_ms", "sensor"});
  const YamlValue lens = value.at("camera");
  const SceneCamera camera = read_camera(lens);
  if (camera.behind_window)
    lens.at("model").fail_plainly("a window's lens differs from view to view: a rig has none");
  RigSceneCamera result{read_folder_name(value.at("name")), camera.camera, camera.model, {}};
  if (const auto pose = value.find("rig_from_camera"))
    result.rig_from_camera = read_rigid_placement(*pose);
  if (const auto offset = value.find("time_offset_ms"))
    result.time_offset_s = offset->number_in(-kMostMilliseconds, kMostMilliseconds) * 1e-3;
  const auto own = value.find("sensor");
  if (own || shared) result.sensor = read_sensor(own ? *own : *shared, camera.camera);
  return result;
}

bool read_boards_move(const YamlValue& value) {
  const std::string name = value.text();
  if (name != "rig" && name != "boards") value.fail("must be rig or boards");
  return name == "boards";
}

}  // namespace

void read_rig(const YamlValue& top, RigScene& scene) {
  const YamlValue rig = top.at("rig");
  rig.allow_only({"cameras", "moves", "period_ms"});
  if (top.find("camera")) rig.fail_plainly("takes the place of the scene's camera: give one");
  std::set<std::string> names;
  for (const YamlValue& item : rig.at("cameras").items(1, limits::kMaxRigCameras)) {
    scene.cameras.push_back(read_rig_camera(item, top.find("sensor")));
    if (!names.insert(scene.cameras.back().name).second)
      item.at("name").fail("must differ from the cameras before it");
  }
  if (const auto moves = rig.find("moves")) scene.boards_move = read_boards_move(*moves);
  if (const auto period = rig.find("period_ms")) {
    period->positive();
    scene.period_s = period->number_in(0, kMostMilliseconds) * 1e-3;
  }
}

}  // namespace tagcal::internal
