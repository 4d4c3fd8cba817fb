#include "tagcal/io/scene/scene_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::internal {
namespace {

struct FieldOfViewKey {
  const char* name;
  double extent_px;
};

std::vector<FieldOfViewKey> field_of_view_keys(const ImageSize& size) {
  return {{"field_of_view_deg", size.width * 1.0},
          {"field_of_view_height_deg", size.height * 1.0},
          {"field_of_view_diagonal_deg", std::hypot(size.width, size.height)}};
}

// Focal length of a lens of this kind, without radial distortion but of the given shape, with this
// field of view over the extent.
double focal_of(const YamlValue& field_of_view_deg, const Model& model,
                const CameraNumbers& numbers, double extent_px) {
  const LensKind& kind = model.kind();
  const double degrees = field_of_view_deg.positive();
  const double limit = kind.reaches_behind ? 360 : 180;
  if (degrees >= limit) field_of_view_deg.fail(fmt::format("must be below {}", limit));
  if (!kind.reaches_behind) return focal_from_field_of_view_px(radians(degrees), extent_px);
  CameraNumbers unit;
  unit.fx = unit.fy = 1;
  if (kind.parameters[4].role == ParameterRole::shape) unit.distortion = numbers.distortion;
  const Lens lens =
      make_camera(unit, model.sibling(kind, ModelRole::largest), field_of_view_deg).lens;
  const double half = radians(degrees) / 2;
  const auto edge = project(lens, {std::sin(half), 0, std::cos(half)});
  if (!edge) field_of_view_deg.fail("must be within what the lens sees");
  return extent_px / (2 * edge->x());
}

void read_focal(const YamlValue& value, const Model& model, CameraNumbers& numbers) {
  std::vector<double> focals;
  if (const auto f = value.find("f")) focals.push_back(f->positive());
  for (const FieldOfViewKey& key : field_of_view_keys(numbers.image_size))
    if (const auto angle = value.find(key.name))
      focals.push_back(focal_of(*angle, model, numbers, key.extent_px));
  const bool has_both = value.find("fx").has_value() || value.find("fy").has_value();
  if (focals.size() + (has_both ? 1 : 0) != 1)
    value.fail_plainly(
        "needs one of f, fx and fy, field_of_view_deg, field_of_view_height_deg, "
        "field_of_view_diagonal_deg");
  numbers.fx = has_both ? value.at("fx").positive() : focals[0];
  numbers.fy = has_both ? value.at("fy").positive() : focals[0];
}

void read_centre(const YamlValue& value, CameraNumbers& numbers) {
  const Eigen::Vector2d centre = image_centre(numbers.image_size);
  const auto cx = value.find("cx"), cy = value.find("cy");
  numbers.cx = cx ? cx->number() : centre.x();
  numbers.cy = cy ? cy->number() : centre.y();
}

std::size_t num_free_distortion(const Model& model) {
  std::size_t count = 0;
  for (const FreeParameter& parameter : model.free()) count += parameter.lens_parameters[0] >= 4;
  return count;
}

SceneCamera read_model_camera(const YamlValue& value, CameraNumbers numbers) {
  value.allow_only({"image_size", "model", "f", "fx", "fy", "field_of_view_deg",
                    "field_of_view_height_deg", "field_of_view_diagonal_deg", "cx", "cy",
                    "distortion", "sector", "binned", "resized"});
  const Model& model = read_model(value.at("model"));
  if (const auto distortion = value.find("distortion")) {
    const std::size_t most = num_free_distortion(model);
    numbers.distortion = distortion->numbers(0, 100);
    if (numbers.distortion.size() > most) {
      distortion->fail(
          fmt::format("must have at most the {} coefficients of model {}", most, model.name()));
    }
  }
  read_focal(value, model, numbers);
  return {make_camera(numbers, model, value), std::string(model.name())};
}

// The recession of depth in the picture: the third column of the projection's matrix.
Eigen::Vector2d read_recession(const YamlValue& value) {
  const auto projection = value.find("projection");
  const std::string name = projection ? projection->text() : "orthographic";
  const auto angle = value.find("recedes_deg"), direction = value.find("direction");
  const bool named = name == "cavalier" || name == "cabinet";
  if (angle && !named) angle->fail_plainly("belongs to cavalier and cabinet only");
  if (direction && name != "oblique") direction->fail_plainly("belongs to oblique only");
  const double recedes = radians(angle ? angle->number() : 45);
  if (name == "orthographic") return orthographic_projection().col(2).head<2>();
  if (name == "cavalier") return cavalier_projection(recedes).col(2).head<2>();
  if (name == "cabinet") return cabinet_projection(recedes).col(2).head<2>();
  if (name != "oblique") projection->fail("must be orthographic, cavalier, cabinet or oblique");
  const YamlValue along = value.at("direction");
  try {
    return oblique_projection(read_vector(along)).col(2).head<2>();
  } catch (const Error&) {
    along.fail_plainly("must leave the plane of projection: its z must not be 0");
  }
}

SceneCamera read_parallel_camera(const YamlValue& value, CameraNumbers numbers) {
  value.allow_only({"image_size", "model", "scale_px_per_m", "cx", "cy", "projection",
                    "recedes_deg", "direction", "sector", "binned", "resized"});
  const double scale = value.at("scale_px_per_m").positive();
  const Eigen::Vector2d recession = read_recession(value);
  return {{Parallel({scale, scale, numbers.cx, numbers.cy, recession.x(), recession.y()}),
           numbers.image_size},
          kParallelModel};
}

SceneCamera read_window_camera(const YamlValue& value, const ImageSize& size) {
  value.allow_only({"image_size", "model"});
  const Eigen::Vector2d centre = image_centre(size);
  return {{pinhole(1, 1, centre.x(), centre.y()), size}, "pinhole", true};
}

// One display of a tiled wall: {columns, rows, column, row} from the top left.
void cut_sector(const YamlValue& value, SceneCamera& camera) {
  value.allow_only({"columns", "rows", "column", "row"});
  const ImageSize& whole = camera.camera.image_size;
  const int columns = value.at("columns").whole(1, whole.width);
  const int rows = value.at("rows").whole(1, whole.height);
  const int column = value.at("column").whole(0, columns - 1);
  const int row = value.at("row").whole(0, rows - 1);
  const std::vector<PixelRectangle> all = sectors(whole, columns, rows);
  camera.camera = cropped(camera.camera, all[static_cast<std::size_t>(row * columns + column)]);
}

// The camera of a part of the picture, of one with larger pixels, or of another size; its principal
// point need not be in the middle, nor its pixels square.
void change_pixels(const YamlValue& value, SceneCamera& camera) {
  if (const auto sector = value.find("sector")) cut_sector(*sector, camera);
  if (const auto bins = value.find("binned")) {
    const std::vector<YamlValue> counts = bins->items(2, 2);
    const ImageSize& size = camera.camera.image_size;
    const int columns = counts[0].whole(1, size.width), rows = counts[1].whole(1, size.height);
    camera.camera = binned(camera.camera, columns, rows);
  }
  if (const auto size = value.find("resized"))
    camera.camera = resized(camera.camera, read_image_size_value(*size));
  if (camera.model == kParallelModel) return;
  if (Model::named(camera.model).contains(camera.camera)) return;
  const auto smallest = std::ranges::find_if(
      Model::all(), [&](const Model& model) { return model.contains(camera.camera); });
  camera.model = smallest->name();  // one exists: that with all parameters of the lens
}

// The name of a camera is that of its folder.
std::string read_folder_name(const YamlValue& value) {
  constexpr std::size_t kMostCharacters = 64;  // numeric: file systems allow 255 bytes
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

SceneCamera read_camera(const YamlValue& value) {
  CameraNumbers numbers;
  numbers.image_size = read_image_size_value(value.at("image_size"));
  const std::string model = value.at("model").text();
  if (model == "window") return read_window_camera(value, numbers.image_size);
  read_centre(value, numbers);
  SceneCamera camera = model == kParallelModel ? read_parallel_camera(value, numbers)
                                               : read_model_camera(value, numbers);
  change_pixels(value, camera);
  return camera;
}

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
