#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// A flat opaque object: a convex polygon in world coordinates, with a grey level in [0, 1] (a share
// of full white).
struct Occluder {
  std::vector<Eigen::Vector3d> corners;
  double level = 0.3;
  std::string name = {};  // "cuboid 0"; empty: "occluder" and its index in the scene
};

// Camera paths: the poses of n views. `up` is +z of the world unless the view is along it.

// A circle about `centre`, in a plane of constant z, looking at `target`.
struct RingPath {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius_m = 1;
  double start_rad = 0;
  double end_rad = 0;  // of the last view; a full turn from start omits the repeated view
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
};

// A part of a sphere about `target`: azimuth from +x towards +y and elevation above the xy-plane of
// the world, spread evenly over the given ranges (Fibonacci lattice in permuted order), at
// distances that grow evenly from `min_distance_m` to `max_distance_m`.
struct DomePath {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  double min_distance_m = 1;
  double max_distance_m = 1;
  double min_azimuth_rad = 0;
  double max_azimuth_rad = 0;
  double min_elevation_rad = 0;
  double max_elevation_rad = 0;
};

// A line from one point to another, looking at `target`.
struct LinePath {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
};

// The given poses; for the jitter the target is one metre ahead. No more views than poses.
struct ExplicitPath {
  std::vector<Pose> camera_from_world;
};

// Any path: the pose at time t, which runs evenly over the views from 0 at the first to 1 at the
// last. For the jitter the target is one metre ahead. `lens`, unless it is empty, gives each view
// its own, for example behind a window that stands still while the eye moves.
struct FunctionPath {
  std::function<Pose(double t)> camera_from_world;
  std::function<Lens(double t)> lens;
};

using CameraPath = std::variant<RingPath, DomePath, LinePath, ExplicitPath, FunctionPath>;

// The time of a view for FunctionPath; a place between two views has one, too.
double time_of_view(double view, int num_views);

// Random displacement of each view from the path: uniform, at most these values.
struct PathJitter {
  double position_m = 0;  // eye, each coordinate
  double target_m = 0;    // point looked at, each coordinate
  double roll_rad = 0;    // about the optical axis
};

// Loss of light towards the border of the image, as a factor of the light at a pixel.
struct Vignetting {
  bool cos4 = false;  // cosine^4 of the angle between the pixel's ray and the optical axis
  // 1 + a1 r^2 + a2 r^4 + ..., r is the distance from the image's centre in half diagonals.
  std::vector<double> polynomial;
};

// A thin lens that images points at the distance (along the optical axis) sharply. The others
// become discs of diameter aperture * focal length in pixels * |1 / z - 1 / distance|; each is
// drawn as the Gaussian of the same variance, whose standard deviation is a quarter of that.
struct Focus {
  double distance_m = 1;
  double aperture_m = 0;  // diameter: focal length / f-number
};

// Colour filters over the pixels of a grey scene (Bayer 1976). The light of a pixel is multiplied
// by the gain of its filter. A raw mosaic keeps it so; otherwise the gains are divided out (white
// balance), each colour is interpolated bilinearly, and the picture is the luma of ITU-R BT.601,
// 0.299 red + 0.587 green + 0.114 blue, whose noise is correlated between neighbours.
struct Mosaic {
  std::string pattern = "RGGB";  // upper-left 2 x 2 pixels, row by row: RGGB, BGGR, GRBG or GBRG
  std::array<double, 3> gains = {1, 1, 1};  // of red, green and blue, > 0
  bool demosaic = true;                     // false: a raw mosaic
};

// The bilateral filter (Tomasi & Manduchi 1998): the mean of the neighbours, weighted by a Gaussian
// of their distance and one of their difference in level.
struct Denoise {
  double levels = 10;    // standard deviation of the latter, > 0, in levels of an 8-bit picture
  double radius_px = 1;  // standard deviation of the former, in (0, 10]
};

// Unsharp masking: level + amount * (level - mean), with the mean weighted by a Gaussian.
struct Sharpen {
  double amount = 0.5;   // in [0, 10]
  double radius_px = 1;  // standard deviation of the Gaussian, in (0, 10]
};

// A sensor that reads its rows, or its columns, one after another (rolling shutter). Each line is
// exposed at an instant of its own: line i of n, in the order of reading, ((i + 1/2) / n - 1/2)
// readout_s after the middle of the picture, whose pose is that of the view.
enum class ReadDirection { down, up, right, left };  // from the first line read to the last
struct RollingShutter {
  double readout_s = 0;  // n times the time from one line to the next; 0: a global shutter
  ReadDirection direction = ReadDirection::down;

  bool by_rows() const {
    return direction == ReadDirection::down || direction == ReadDirection::up;
  }
  // When the line of a pixel is read, in seconds from the middle of the picture.
  double seconds_at(const Eigen::Vector2d& pixel, const ImageSize& size) const;
};

// The velocity of a camera, in the camera frame.
struct CameraVelocity {
  Eigen::Vector3d turn_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d move_m_s = Eigen::Vector3d::Zero();

  bool is_zero() const { return turn_rad_s.isZero(0) && move_m_s.isZero(0); }
};

// The pose of a camera `seconds` after it had this one, along the screw motion of its velocity.
Pose moved_for(double seconds, const CameraVelocity& velocity, const Pose& camera_from_world);

// Conversion of light to grey levels: value = white * (exposure * level)^gamma, plus Gaussian
// noise, clipped. With a mosaic the sensor is linear, as in a camera: gains, noise, clipping and
// interpolation come before the gamma. Then follow `denoise`, `sharpen` and `jpeg`, in this order.
struct Sensor {
  double exposure = 1;
  double blur_px = 0;       // standard deviation of a Gaussian, before the sampling by pixels
  double noise_levels = 0;  // standard deviation, in levels of an 8-bit picture (white is 255)
  int bits = 8;             // of the pictures' values: 8, or 16 (white is 65535)
  double gamma = 1;         // > 0; below 1 (0.45 in most consumer pictures) brightens dark parts
  Vignetting vignetting;
  std::optional<Focus> focus;  // of a perspective lens
  std::optional<Mosaic> mosaic;
  std::optional<Denoise> denoise;
  std::optional<Sharpen> sharpen;
  std::optional<int> jpeg;  // quality, 1 to 100, as libjpeg has it; of 8 bits only
  RollingShutter shutter;   // not with a focus
};

// A lamp with parallel rays: it adds strength * cosine, the cosine of the angle between its light
// and the normal of the sheet.
struct DirectionalLamp {
  Eigen::Vector3d direction = -Eigen::Vector3d::UnitZ();  // in which its light travels; any length
  double strength = 1;
};

// A lamp at a point: it adds strength * cosine / r^2, r in metres. A sheet that faces it at 1 m
// gets `strength`.
struct PointLamp {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double strength = 1;
};

// The light on sheets: the level of a sheet is multiplied by `ambient` and what the lamp adds to
// the side that the camera sees (Lambert). The background keeps its level. Sheets cast no shadows.
struct Light {
  double ambient = 0;
  std::variant<std::monostate, DirectionalLamp, PointLamp> lamp;
  bool on_camera = false;  // the lamp is given in the camera frame, not in the world
};

struct Scene {
  Camera camera;
  std::string model;  // the smallest candidate model that contains the camera
  std::vector<PlacedBoard> boards;
  std::vector<Occluder> occluders;
  CameraPath path;
  PathJitter jitter;
  int num_views = 1;
  Sensor sensor;
  double background_level = 0.5;  // grey levels as shares of full white
  double paper_level = 0.9;
  double ink_level = 0.1;
  // Distance by which the print has grown into the white at each edge, in the plane of the paper;
  // negative if it has shrunk. The observed corners are those without the spread.
  double ink_spread_m = 0;
  // Side of a pixel of the drawing that was printed, which drawing programs give whole numbers of
  // to the cells of a tag: distances of the cells' edges from the tag's upper-left corner are
  // rounded to multiples of it. The tag's corners stay. 0: cells of equal size.
  double print_grid_m = 0;
  double paper_margin_m = 0.02;  // white paper around the tags
  std::optional<Light> light;    // without it, sheets have their own levels
  // Of the camera while a picture is read, for a rolling shutter. All else stands still meanwhile.
  CameraVelocity velocity;

  bool is_rolling() const { return sensor.shutter.readout_s > 0 && !velocity.is_zero(); }
};

// The poses of all views, camera_from_world. Equal seeds give equal poses. Throws Error if there
// are no views or more than an ExplicitPath has, or if the eye of a view is at its target.
std::vector<Pose> camera_poses(const Scene& scene, std::uint64_t seed);

// The pose on the path at a place between two views (0: the first view), without jitter. No value
// for paths whose views are not in a row: DomePath and ExplicitPath.
std::optional<Pose> pose_between_views(const Scene& scene, double view);

// The name of the image of view i: "000.png", "001.png", ...
std::string image_name(int view);

// The seed of the noise in view i, for `expose`: each view has its own, so that the pictures do not
// depend on their order.
std::uint64_t noise_seed(std::uint64_t seed, int view);

}  // namespace tagcal
