#include "job/reproject_targets.hpp"

#include <fmt/format.h>

#include <cmath>

#include "job/camera_input.hpp"
#include "job/plain_text.hpp"
#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/reproject/cameras.hpp"
#include "tagcal/reproject/maps.hpp"

namespace tagcal::tools {
namespace {

using internal::kDegree;
// Pixels of one new picture. Beyond it the memory of a usual machine ends: tiles do not.
constexpr double kMostPixels = 400e6;
constexpr int kMostSide = 1'000'000;          // of a plane, in tiles
constexpr int kMostPinholes = 360;            // one a degree
constexpr double kMostTiles = 100e3;          // folders
constexpr int kMostSideOfArgument = 100'000;  // that camera files are read with

// --rotate: the new camera turns to the right by yaw, then upwards by pitch, then clockwise by
// roll, each about its own axes.
Pose turn_of(const ReprojectTask& task) {
  if (task.rotate.empty()) return Pose();
  const std::vector<double> angles = numbers_argument("--rotate", task.rotate, 3);
  return rotation_about_y(angles[2] * kDegree) * rotation_about_x(angles[1] * kDegree) *
         rotation_about_z(angles[0] * kDegree);
}

Camera undistorted(const ReprojectTask& task, const Camera& camera) {
  const ImageSize size = task.size.empty() ? camera.image_size : size_argument("--size", task.size);
  if (task.undistort == "all") return pinhole_of_all_pixels(camera, size);
  if (task.undistort == "valid") return pinhole_of_valid_pixels(camera, size);
  const double focal_px = number_of<double>(task.undistort).value_or(0);
  if (!(focal_px > 0) || !std::isfinite(focal_px))
    throw Error(fmt::format("--undistort: must be all, valid or a focal length in pixels, got {}",
                            task.undistort));
  return pinhole_of_focal_length(camera, focal_px, size);
}

Panorama panorama(const ReprojectTask& task, const Camera& camera) {
  const PanoramaKind kind =
      task.panorama == "cylindrical" ? PanoramaKind::cylindrical : PanoramaKind::equirectangular;
  return panorama_of(camera, kind, task.px_per_deg / kDegree);
}

std::vector<ReprojectTarget> pinholes(const ReprojectTask& task, const Camera& camera) {
  std::vector<ReprojectTarget> targets;
  for (const TurnedCamera& turned : several_pinholes(camera, task.pinholes))
    targets.push_back({turned.name, turned.camera, turned.camera_from_turned});
  return targets;
}

std::vector<ReprojectTarget> unturned_targets(const ReprojectTask& task, const Camera& camera) {
  if (task.pinholes > 0) return pinholes(task, camera);
  if (!task.panorama.empty()) return {{"", panorama(task, camera), Pose()}};
  if (!task.undistort.empty()) return {{"", undistorted(task, camera), Pose()}};
  if (!task.to_camera.empty()) return {{"", read_camera(task.to_camera).camera, Pose()}};
  return {{"", camera, Pose()}};  // --rotate alone
}

// The options that ask for the new camera.
std::string task_text(const ReprojectTask& task) {
  if (task.pinholes > 0) return fmt::format("--pinholes {}", task.pinholes);
  if (!task.panorama.empty()) return "--panorama " + task.panorama;
  if (!task.undistort.empty()) return "--undistort " + task.undistort;
  return task.to_camera.empty() ? "--rotate" : "--to-camera";
}

void check_belongs(bool given, const char* option, bool allowed, const char* tasks) {
  if (given && !allowed) throw Error(fmt::format("{}: belongs to {}", option, tasks));
}

}  // namespace

ImageSize size_argument(const std::string& option, const std::string& text) {
  const std::size_t x = text.find('x');
  ImageSize size;
  if (x != std::string::npos)
    size = {number_of<int>(text.substr(0, x)).value_or(0),
            number_of<int>(text.substr(x + 1)).value_or(0)};
  if (size.width <= 0 || size.height <= 0 || size.width > kMostSideOfArgument ||
      size.height > kMostSideOfArgument)
    throw Error(
        fmt::format("{}: must be WIDTHxHEIGHT in pixels, such as 1280x800, got {}", option, text));
  return size;
}

std::vector<double> numbers_argument(const std::string& option,
                                     const std::vector<std::string>& texts, std::size_t count) {
  std::vector<double> numbers;
  for (const std::string& text : texts) {
    const auto number = number_of<double>(text);
    if (!number || !std::isfinite(*number))
      throw Error(fmt::format("{}: must be finite numbers, got {}", option, text));
    numbers.push_back(*number);
  }
  if (numbers.size() != count)
    throw Error(fmt::format("{}: must be {} numbers with commas between, got {}", option, count,
                            numbers.size()));
  return numbers;
}

void check_task(const ReprojectTask& task) {
  const bool rectify = !task.rectify.empty();
  const int tasks = !task.undistort.empty() + !task.to_camera.empty() + task.plane +
                    (task.pinholes > 0) + !task.panorama.empty() + rectify;
  if (tasks > 1)
    throw Error(
        "--undistort, --to-camera, --plane, --pinholes, --panorama, --rectify: only one of them is "
        "possible");
  if (task.pinholes > kMostPinholes)
    throw Error(
        fmt::format("--pinholes: must be {} at most, got {}", kMostPinholes, task.pinholes));
  if (tasks == 0 && task.rotate.empty())
    throw Error(
        "one of --undistort, --to-camera, --rotate, --plane, --pinholes, --panorama, --rectify is "
        "needed");
  check_belongs(!task.rotate.empty(), "--rotate", !task.plane && !rectify,
                "the tasks other than --plane and --rectify");
  check_belongs(!task.tiles.empty(), "--tiles", !rectify, "the tasks other than --rectify");
  check_belongs(!task.alpha.empty(), "--alpha", rectify, "--rectify");
  check_belongs(task.longlat, "--longlat", rectify, "--rectify");
  check_belongs(!task.cameras.empty(), "--cameras", rectify, "--rectify");
  check_belongs(!task.size.empty(), "--size", !task.undistort.empty(), "--undistort");
  check_belongs(task.px_per_deg > 0, "--px-per-deg", !task.panorama.empty(), "--panorama");
  check_belongs(!task.rectangle.empty(), "--rectangle", task.plane, "--plane");
  check_belongs(task.m_per_px > 0, "--m-per-px", task.plane, "--plane");
  if (task.plane && !(task.m_per_px > 0)) throw Error("--plane: needs --m-per-px");
}

std::vector<ReprojectTarget> direction_targets(const ReprojectTask& task, const Camera& camera,
                                               const std::string& camera_name) {
  try {
    std::vector<ReprojectTarget> targets = unturned_targets(task, camera);
    const Pose turn = turn_of(task);
    for (ReprojectTarget& target : targets)
      target.camera_from_target = turn * target.camera_from_target;
    return targets;
  } catch (const Error& error) {
    const std::string what = error.what();
    if (what.starts_with("--") || what.starts_with(task.to_camera + ":")) throw;
    const bool fits_no_pinhole = what.find("a pinhole shows") != std::string::npos;
    if (!fits_no_pinhole)
      throw Error(fmt::format("{}: {} gives no camera: {}", camera_name, task_text(task), what));
    throw Error(fmt::format("{}: {} (--undistort FOCAL, --panorama equirectangular, --pinholes 5)",
                            camera_name, what));
  }
}

PlaneRaster plane_raster(const ReprojectTask& task, const std::vector<double>& around) {
  const std::vector<double> r =
      task.rectangle.empty() ? around : numbers_argument("--rectangle", task.rectangle, 4);
  if (!(r[2] > r[0] && r[3] > r[1]))
    throw Error(
        fmt::format("--rectangle: must be x0,y0,x1,y1 with x0 < x1 and y0 < y1, got "
                    "{},{},{},{}",
                    r[0], r[1], r[2], r[3]));
  const double m = task.m_per_px;
  const double width =
      std::ceil((r[2] - r[0]) / m - 1e-9);  // 1e-9: a whole number that was rounded
  const double height = std::ceil((r[3] - r[1]) / m - 1e-9);
  if (width < 1 || height < 1)
    throw Error("--m-per-px: no pixel is in the rectangle: take a smaller value");
  if (width > kMostSide || height > kMostSide)
    throw Error(
        fmt::format("--m-per-px: the picture would be {:.0f}x{:.0f} pixels: take a larger "
                    "value",
                    width, height));
  // The outer border of the picture is the rectangle's, from its upper left corner.
  return {{r[0] + m / 2, r[3] - m / 2}, m, {static_cast<int>(width), static_cast<int>(height)}};
}

std::vector<ReprojectTarget> tiled(const ReprojectTask& task,
                                   std::vector<ReprojectTarget> targets) {
  std::vector<ReprojectTarget> tiles;
  const bool cuts = !task.tiles.empty();
  const ImageSize tile = cuts ? size_argument("--tiles", task.tiles) : ImageSize();
  for (ReprojectTarget& target : targets) {
    const ImageSize whole = size_of(target.target);
    const ImageSize part = cuts ? tile : whole;
    if (static_cast<double>(part.width) * part.height > kMostPixels)
      throw Error(
          fmt::format("the new picture would be {}x{} pixels: take --tiles, such as "
                      "--tiles 8192x8192",
                      part.width, part.height));
    const double count = cuts ? std::ceil(1.0 * whole.width / tile.width) *
                                    std::ceil(1.0 * whole.height / tile.height)
                              : 1;
    if (count + static_cast<double>(tiles.size()) > kMostTiles)
      throw Error(
          fmt::format("--tiles: {}x{} pixels in tiles of {}x{} would be more than {:.0f} "
                      "folders",
                      whole.width, whole.height, tile.width, tile.height, kMostTiles));
    for (int y = 0; cuts && y < whole.height; y += tile.height) {
      for (int x = 0; x < whole.width; x += tile.width) {
        const ImageSize size{std::min(tile.width, whole.width - x),
                             std::min(tile.height, whole.height - y)};
        const std::string name =
            fmt::format("{}{}tile_{}_{}", target.folder, target.folder.empty() ? "" : "_",
                        y / tile.height, x / tile.width);
        tiles.push_back({name, cropped(target.target, x, y, size), target.camera_from_target});
      }
    }
    if (!cuts) tiles.push_back(std::move(target));
  }
  return tiles;
}

}  // namespace tagcal::tools
