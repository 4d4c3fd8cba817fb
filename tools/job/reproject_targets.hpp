#pragma once

#include <string>
#include <vector>

#include "tagcal/reproject/types.hpp"

namespace tagcal::tools {

// What `tagcal reproject` is asked to show; "" and 0: not asked for.
struct ReprojectTask {
  std::string undistort;  // all, valid, or a focal length
  std::string to_camera;  // a camera file
  bool plane = false;
  int pinholes = 0;
  std::string panorama;                // equirectangular or cylindrical
  std::string rectify;                 // a folder
  std::string alpha;                   // of rectify
  bool longlat = false;                // of rectify
  std::vector<std::string> cameras;    // of rectify
  std::vector<std::string> rotate;     // roll, pitch, yaw in degrees
  std::string size;                    // WxH of the new picture
  double px_per_deg = 0;               // of a panorama
  std::vector<std::string> rectangle;  // x0, y0, x1, y1 of the plane, metres
  double m_per_px = 0;                 // of the plane
  std::string tiles;                   // WxH
};

// A new picture and where it goes: a folder beneath --out, "" for --out itself.
struct ReprojectTarget {
  std::string folder;
  Target target;
  Pose camera_from_target;
};

// Throws Error unless exactly one task is given (--rotate may also come with another), and for
// options that do not belong to it.
void check_task(const ReprojectTask& task);

// The targets of tasks other than --plane. `camera_name` stands in messages.
std::vector<ReprojectTarget> direction_targets(const ReprojectTask& task, const Camera& camera,
                                               const std::string& camera_name);

// The picture of a rectangle of the plane: that of --rectangle, or else `around` (x0, y0, x1, y1).
PlaneRaster plane_raster(const ReprojectTask& task, const std::vector<double>& around);

// The targets, each cut into tiles of --tiles, in folders named tile_ROW_COLUMN.
std::vector<ReprojectTarget> tiled(const ReprojectTask& task, std::vector<ReprojectTarget> targets);

// "640x480". Throws Error, naming the option.
ImageSize size_argument(const std::string& option, const std::string& text);

// A list of finite numbers. Throws Error, naming the option, for another number of them.
std::vector<double> numbers_argument(const std::string& option,
                                     const std::vector<std::string>& texts, std::size_t count);

}  // namespace tagcal::tools
