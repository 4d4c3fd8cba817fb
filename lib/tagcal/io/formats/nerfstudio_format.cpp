#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

constexpr const char* kHalfPixelNote =
    "pixel centres are at (0.5, 0.5) in nerfstudio and (0, 0) here: cx and cy became 0.5 {}";
// The numbers of a camera, of the whole file or of each frame.
constexpr auto kCameraKeys =
    std::to_array<std::string_view>({"w", "h", "fl_x", "fl_y", "camera_angle_x", "camera_angle_y",
                                     "cx", "cy", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"});
constexpr std::array<std::string_view, 4> kNotOfFisheye = {"k5", "k6", "p1", "p2"};
constexpr std::array<std::string_view, 3> kNotOfPerspective = {"k4", "k5", "k6"};
constexpr const char* kNoCentreNote = "cx, cy are not given: the centre of the image is taken";

// A half turn about x: from x right, y up, z backward to x right, y down, z forward.
Pose opencv_from_opengl() { return {Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()}; }

std::optional<double> number_of(const YamlValue& values, std::string_view key) {
  const auto value = values.find(key);
  if (!value) return std::nullopt;
  return value->number();
}

const LensKind* named_lens_kind(const YamlValue& value) {
  const std::string name = value.text();
  for (const std::string_view known :
       {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"})
    if (name == known) return &kind_of<Perspective>();
  if (name == "OPENCV_FISHEYE") return &kind_of<Fisheye>();
  value.fail("must be PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV or OPENCV_FISHEYE");
}

const LensKind* lens_kind(const YamlValue& top) {
  const auto name = top.find("camera_model");
  const auto flag = top.find("is_fisheye");  // instant-ngp
  std::optional<const LensKind*> flagged;
  if (flag) flagged = flag->truth() ? &kind_of<Fisheye>() : &kind_of<Perspective>();
  if (!name) return flagged.value_or(&kind_of<Perspective>());
  const LensKind* named = named_lens_kind(*name);
  if (flagged && *flagged != named)
    flag->fail(
        fmt::format("must be {} with camera_model {}", named == &kind_of<Fisheye>(), name->text()));
  return named;
}

// fl_x, or the field of view along x that instant-ngp gives.
double focal(const YamlValue& values, std::string_view length, std::string_view angle, int extent) {
  if (const auto value = values.find(length)) return value->positive();
  if (const auto value = values.find(angle)) {
    const double field = value->positive();
    if (!(field < std::acos(-1.0))) value->fail("must be less than pi");
    return focal_from_field_of_view_px(field, extent);
  }
  return values.at(length).positive();
}

// w and h, or what the user states: instant-ngp takes the size of the pictures. 0 x 0 if the
// numbers of the lens need no size.
ImageSize size_of(const YamlValue& values, const ImageSize& stated) {
  if (values.find("w") || values.find("h"))
    return {values.at("w").whole(1, limits::kMaxSidePx),
            values.at("h").whole(1, limits::kMaxSidePx)};
  if (stated == ImageSize() && !(values.find("fl_x") && values.find("cx") && values.find("cy")))
    values.fail_plainly(
        "w: the key is missing: state the size of the pictures, --image-size "
        "WIDTHxHEIGHT");
  return stated;
}

FileCamera read_camera(const YamlValue& values, const LensKind* kind, const ImageSize& stated,
                       std::vector<std::string>& notes) {
  const ImageSize size = size_of(values, stated);
  const double fx = focal(values, "fl_x", "camera_angle_x", size.width);
  const bool one_focal = !values.find("fl_y") && !values.find("camera_angle_y");
  const double fy = one_focal ? fx : focal(values, "fl_y", "camera_angle_y", size.height);
  const auto cx = number_of(values, "cx"), cy = number_of(values, "cy");
  if ((!cx || !cy) && std::ranges::find(notes, kNoCentreNote) == notes.end())
    notes.emplace_back(kNoCentreNote);  // once, not for every frame
  const auto k = [&](std::string_view key) { return number_of(values, key).value_or(0); };
  const double x = cx.value_or(size.width / 2.0) - kHalfPixel;
  const double y = cy.value_or(size.height / 2.0) - kHalfPixel;
  const std::string where = place(values, "fl_x");
  // k4 of OPENCV is a fourth power series coefficient there, which OpenCV's lens does not have.
  const bool fisheye = kind == &kind_of<Fisheye>();
  for (const std::string_view key :
       fisheye ? std::span<const std::string_view>(kNotOfFisheye) : kNotOfPerspective)
    if (k(key) != 0)
      values.at(key).fail(fmt::format("must be 0: no {} lens here has this coefficient",
                                      fisheye ? "fisheye" : "perspective"));
  if (fisheye) {
    const double p[] = {fx, fy, x, y, k("k1"), k("k2"), k("k3"), k("k4")};
    return file_camera("", lens_of(kind_of<Fisheye>(), p, where), size);
  }
  const double p[] = {fx, fy, x, y, k("k1"), k("k2"), k("p1"), k("p2"), k("k3")};
  return file_camera("", lens_of(kind_of<Perspective>(), p, where), size);
}

void read_frame(const YamlValue& frame, std::size_t camera, CameraFile& file,
                std::set<std::string>& names) {
  const Pose world_from_opengl = read_pose(frame.at("transform_matrix"));
  file.poses.push_back({read_image_name(frame.at("file_path"), names), camera,
                        opencv_from_opengl() * world_from_opengl.inverse()});
}

// Throws Error for a number of the lens in the place that is not read: in a frame beside the lens
// of the whole file, or the other way round. An equal number adds nothing.
void need_one_lens(const YamlValue& other, const YamlValue& read, std::string_view must) {
  for (const std::string_view key : kCameraKeys) {
    const auto number = number_of(other, key);
    if (number && number != number_of(read, key)) other.at(key).fail_plainly(std::string(must));
  }
}

// The cameras of frames that have their own numbers, by these, and the name that tagcal adds: equal
// ones are one camera.
using CamerasByNumbers = std::map<std::pair<std::vector<double>, std::string>, std::size_t>;

std::vector<double> numbers_of(const FileCamera& camera) {
  const auto& [lens, size] = camera.calibration.camera;
  const std::span<const double> p = parameters(lens);
  std::vector<double> numbers(p.begin(), p.end());
  numbers.insert(numbers.end(), {double(size.width), double(size.height)});
  return numbers;
}

std::size_t camera_of(const YamlValue& frame, const LensKind* kind, const ImageSize& stated,
                      CamerasByNumbers& known, CameraFile& file) {
  FileCamera camera = read_camera(frame, kind, stated, file.notes);
  if (const auto name = frame.find("camera"); name && name->is_scalar()) camera.name = name->text();
  const auto [place, is_new] =
      known.emplace(std::pair(numbers_of(camera), camera.name), file.cameras.size());
  if (is_new) {
    const bool is_new_name =
        !camera.name.empty() &&
        std::ranges::find(file.cameras, camera.name, &FileCamera::name) == file.cameras.end();
    if (!is_new_name) camera.name = fmt::format("cam{}", place->second);
    file.cameras.push_back(std::move(camera));
  }
  return place->second;
}

// The frames of a rig without pictures, one a camera with its name: the world is the rig.
void take_places(CameraFile& file) {
  if (file.cameras.size() < 2 || file.poses.size() != file.cameras.size()) return;
  for (const ImagePose& pose : file.poses)
    if (pose.image != file.cameras[pose.camera].name) return;
  for (const ImagePose& pose : file.poses)
    file.cameras[pose.camera].camera_from_rig = pose.camera_from_world;
  file.poses.clear();
}

}  // namespace

bool has_nerfstudio_keys(const YamlValue& top) {
  if (top.find("fl_x") || top.find("camera_angle_x")) return true;
  const auto frames = top.find("frames");
  if (!frames || !frames->is_list()) return false;
  const std::vector<YamlValue> items = frames->items(0, limits::kMaxListedPoses);
  return !items.empty() && items[0].is_map() && items[0].find("transform_matrix");
}

CameraFile read_nerfstudio(const CameraText& transforms) {
  const YamlValue& top = *transforms.top;
  const ImageSize& stated = transforms.stated_size;
  CameraFile file;
  file.format = "nerfstudio";
  const LensKind* kind = lens_kind(top);
  const bool shared = top.find("fl_x") || top.find("camera_angle_x");
  if (shared) file.cameras.push_back(read_camera(top, kind, stated, file.notes));
  if (const auto frames = top.find("frames")) {
    std::set<std::string> names;
    CamerasByNumbers known;
    for (const YamlValue& frame : frames->items(0, limits::kMaxListedPoses)) {
      const std::size_t camera = shared ? 0 : camera_of(frame, kind, stated, known, file);
      if (shared)
        need_one_lens(frame, top, "is one of a lens beside that of the whole file, the only one");
      else
        need_one_lens(top, frame, "is not read without fl_x beside it: each frame has its own");
      read_frame(frame, camera, file, names);
    }
  }
  if (file.cameras.empty()) top.at("fl_x");  // throws
  take_places(file);
  file.notes.push_back(fmt::format(fmt::runtime(kHalfPixelNote), "smaller"));
  return file;
}

namespace {

// "key: value" of a camera, with the ends of lines as they stand in the file or in a frame.
std::string lens_keys(const FileCamera& camera, std::string_view end) {
  const bool fisheye = is_fisheye(camera);
  if (!fisheye)
    need_zero_from(9, perspective_numbers(camera, "nerfstudio"),
                   "nerfstudio's lens OPENCV (k1 k2 p1 p2 k3)");
  const Camera& c = camera.calibration.camera;
  const std::span<const double> p = parameters(c.lens);
  std::string text = fmt::format(
      "\"w\": {1},{0}\"h\": {2},{0}\"fl_x\": {3},{0}\"fl_y\": {4},{0}\"cx\": {5},{0}\"cy\": "
      "{6},{0}",
      end, c.image_size.width, c.image_size.height, dotted_number(p[0]), dotted_number(p[1]),
      dotted_number(p[2] + kHalfPixel), dotted_number(p[3] + kHalfPixel));
  constexpr std::array<std::string_view, 5> kPerspective = {"k1", "k2", "p1", "p2", "k3"};
  constexpr std::array<std::string_view, 4> kFisheye = {"k1", "k2", "k3", "k4"};
  const std::span<const std::string_view> names =
      fisheye ? std::span<const std::string_view>(kFisheye) : kPerspective;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("\"{}\": {},{}", names[i], dotted_number(p[4 + i]), end);
  return text;
}

std::string frame_json(const std::string& image, const Pose& camera_from_world,
                       const std::string& keys) {
  const Pose world_from_opengl = (opencv_from_opengl() * camera_from_world).inverse();
  return fmt::format("\n    {{{}\"file_path\": {}, \"transform_matrix\": {}}}", keys,
                     json_text(image), rows_text(world_from_opengl.matrix()));
}

// The pictures; of a rig without any, a frame for each camera at its place.
std::vector<ImagePose> frames_to_write(const CameraFile& file, std::vector<std::string>& notes) {
  const bool several = file.cameras.size() > 1;
  std::vector<ImagePose> frames = file.poses;
  if (several && frames.empty()) {
    for (std::size_t i = 0; i < file.cameras.size(); ++i)
      frames.push_back({camera_name(file, i), i, file.cameras[i].camera_from_rig.value_or(Pose())});
    notes.emplace_back(
        "there are no pictures: each camera has a frame with its name, and the world "
        "is the rig");
    return frames;
  }
  for (std::size_t i = 0; several && i < file.cameras.size(); ++i)
    if (std::ranges::find(frames, i, &ImagePose::camera) == frames.end())
      notes.push_back(
          fmt::format("dropped: the camera {}, which has no picture", shown(camera_name(file, i))));
  note_no_rig(file, notes);
  return frames;
}

// One kind of lens for all frames, as nerfstudio has it.
std::string_view model_of_frames(const CameraFile& file) {
  const bool fisheye = is_fisheye(file.cameras.front());
  for (const FileCamera& camera : file.cameras)
    if (is_fisheye(camera) != fisheye)
      throw Error(
          "nerfstudio has one kind of lens a file, and some of these are fisheyes: --model "
          "fits another lens");
  return fisheye ? "OPENCV_FISHEYE" : "OPENCV";
}

}  // namespace

FormatOutput write_nerfstudio(const CameraFile& file) {
  FormatOutput output;
  const bool several = file.cameras.size() > 1;
  std::string text =
      fmt::format("{{\n  \"camera_model\": \"{}\",\n  {}\"frames\": [", model_of_frames(file),
                  several ? "" : lens_keys(file.cameras.front(), "\n  "));
  std::vector<std::string> keys(file.cameras.size());
  for (std::size_t i = 0; several && i < keys.size(); ++i)
    keys[i] = fmt::format("\"camera\": {}, {}", json_text(camera_name(file, i)),
                          lens_keys(file.cameras[i], " "));
  const std::vector<ImagePose> frames = frames_to_write(file, output.notes);
  for (std::size_t i = 0; i < frames.size(); ++i)
    text += (i ? "," : "") +
            frame_json(frames[i].image, frames[i].camera_from_world, keys[frames[i].camera]);
  output.files = {{"", text + (frames.empty() ? "]\n}\n" : "\n  ]\n}\n")}};
  output.notes.push_back(fmt::format(fmt::runtime(kHalfPixelNote), "larger"));
  if (!file.poses.empty())
    output.notes.emplace_back(
        "poses are world from camera, the camera with y up and z backward (OpenGL); the world is "
        "that of the target, nerfstudio takes its z for up");
  note_no_uncertainty(file, output.notes);
  return output;
}

}  // namespace tagcal::internal
