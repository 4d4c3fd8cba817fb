#include "study/chart/picture_methods.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <numbers>

#include "study/chart/corner_methods.hpp"
#include "study/peers/tag_peers.hpp"
#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

namespace fs = std::filesystem;

int border_bits(const PictureTask& task) { return tag_kind(task.scene.board().board)->border_bits; }

Image8 rendered(const PictureTask& task) {
  const ImageF light = render_light(task.scene.scene, task.scene.families, task.camera_from_world);
  return expose(light, task.scene.scene.sensor, task.noise_seed);
}

double bound_px(const PictureTask& task) {
  BoardScene quiet = task.scene;
  quiet.scene.sensor.noise_levels = 0;
  const Image8 noiseless = expose(render_light(quiet.scene, quiet.families, task.camera_from_world),
                                  quiet.scene.sensor, 0);
  const auto patterns = board_patterns(quiet.scene.boards);
  double sum = 0;
  for (const auto& [id, corners] : task.corners)
    sum += corner_bound(noiseless, patterns.at(id), corners, quiet.scene.camera,
                        task.scene.scene.sensor.noise_levels)
               .trace();
  return std::sqrt(sum / (8 * static_cast<double>(task.corners.size())));
}

PictureMethod our_method() {
  const auto prepare = [](const PictureTask& given) {
    const TagFinder find = our_finder(given.scene.scene.boards, {});
    return prepare_task<std::vector<PeerTag>>(given, [find](const PictureTask& task) {
      std::vector<PeerTag> tags;
      for (const DetectedTag& tag : find(read_image(task.file->path())))
        tags.push_back({tag.id, tag.corners});
      return tags;
    });
  };
  return {"tagcal detect, PNG to corners", prepare, "reading included; the lens not known"};
}

PictureMethod apriltag_method() {
  const auto prepare = [](const PictureTask& given) {
    const auto detector = std::make_shared<AprilTagPeer>("tag36h11", border_bits(given));
    return prepare_task<std::vector<PeerTag>>(given, [detector](const PictureTask& task) {
      return detector->find(read_image(task.file->path()), true);
    });
  };
  return {"AprilTag, PNG to corners", prepare,
          "quad_decimate 1, one thread, refine_edges on, 0.5 px subtracted; the file read by "
          "tagcal"};
}

PictureMethod aruco_method() {
  const auto prepare = [](const PictureTask& given) {
    return prepare_task<std::vector<PeerTag>>(given, [](const PictureTask& task) {
      return aruco_tags(task.file->path(), border_bits(task));
    });
  };
  return {"OpenCV aruco, PNG to corners", prepare,
          "cv::imread and detectMarkers, DICT_APRILTAG_36h11, the border of the board, else the "
          "defaults"};
}

}  // namespace

TemporaryPicture::TemporaryPicture() {
  static std::atomic<int> number = 0;
  path_ = fs::temp_directory_path() / fmt::format("tagcal_chart_{}_{}.png", getpid(), number++);
}

TemporaryPicture::~TemporaryPicture() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

PictureTask draw_picture_task(bool is_plain, Random& random) {
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  PictureTask task{BoardScene({1280, 800}, is_plain),
                   board_pose({std::cos(azimuth), std::sin(azimuth), 0.2}, 0), random.next(),
                   std::make_shared<TemporaryPicture>()};
  task.corners = task.scene.whole_tags(task.camera_from_world);
  task.bound_px = bound_px(task);
  write_png(task.file->path(), rendered(task));
  return task;
}

std::vector<PictureMethod> picture_methods() {
  std::vector<PictureMethod> methods = {our_method(), apriltag_method()};
  if (has_aruco()) methods.push_back(aruco_method());
  return methods;
}

PictureMethod render_method() {
  struct State {
    PictureTask task;
    TemporaryPicture file;

    void write() { write_png(file.path(), rendered(task)); }

    std::vector<PeerTag> corners() const {
      const Image8 image = read_image(file.path());
      const auto patterns = board_patterns(task.scene.scene.boards);
      TagFitOptions options;
      options.camera = &task.scene.scene.camera;
      std::vector<PeerTag> tags;
      for (const auto& [id, corners] : task.corners)
        tags.push_back({id, refine_tag(image, patterns.at(id), corners, options).corners});
      return tags;
    }
  };
  const auto prepare = [](const PictureTask& task) {
    const std::shared_ptr<State> state(new State{task, {}});
    return Prepared<std::vector<PeerTag>>{[state] { state->write(); },
                                          [state] { return state->corners(); }};
  };
  return {"tagcal render, PNG included", prepare,
          "blur 0.8 px, noise of 3 grey levels; error: of the corners that the fit of a whole tag "
          "finds in the file under the lens"};
}

}  // namespace tagcal::study
