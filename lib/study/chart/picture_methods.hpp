#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "study/method.hpp"
#include "study/peers/tag_peers.hpp"
#include "study/tasks/board_view.hpp"
#include "tagcal/random.hpp"

// Whole pictures: from a PNG file to the corners of all tags, and from a scene to a PNG file.
// Private to study.

namespace tagcal::study {

// A new name in the folder of temporary files. The file is removed at the end.
class TemporaryPicture {
 public:
  TemporaryPicture();
  ~TemporaryPicture();
  TemporaryPicture(const TemporaryPicture&) = delete;
  TemporaryPicture& operator=(const TemporaryPicture&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

struct PictureTask {
  BoardScene scene;
  Pose camera_from_world;
  std::uint64_t noise_seed = 0;
  std::shared_ptr<const TemporaryPicture> file;
  std::map<int, TagCorners> corners;  // of the tags that are wholly in the picture
  double bound_px = 0;                // Cramer-Rao bound for a known lens, RMS of a coordinate
};

// A picture of 1280x800 pixels of a board that is tilted about a random axis.
PictureTask draw_picture_task(bool is_plain, Random& random);

using PictureMethod = Method<PictureTask, std::vector<PeerTag>>;

// The first is ours. Those of OpenCV are missing if it has no aruco.
std::vector<PictureMethod> picture_methods();

// `tagcal render`. Its answer: the corners that a fit finds under the lens in the written file.
PictureMethod render_method();

}  // namespace tagcal::study
