// The job `corners` of the chart: from a picture of one tag to its four corners, from one of a grid
// of circles to their centres, and whole pictures from and to PNG files.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "study/chart/chart_study.hpp"
#include "study/chart/circle_methods.hpp"
#include "study/chart/corner_methods.hpp"
#include "study/method.hpp"
#include "study/peers/tag_peers.hpp"
#include "study/tasks/board_view.hpp"
#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/random.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

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

using PictureMethod = Method<PictureTask, std::vector<PeerTag>>;

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

TemporaryPicture::TemporaryPicture() {
  static std::atomic<int> number = 0;
  path_ = fs::temp_directory_path() / fmt::format("tagcal_chart_{}_{}.png", getpid(), number++);
}

TemporaryPicture::~TemporaryPicture() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

// A picture of 1280x800 pixels of a board that is tilted about a random axis.
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

// The first is ours. Those of OpenCV are missing if it has no aruco.
std::vector<PictureMethod> picture_methods() {
  std::vector<PictureMethod> methods = {our_method(), apriltag_method()};
  if (has_aruco()) methods.push_back(aruco_method());
  return methods;
}

// `tagcal render`. Its answer: the corners that a fit finds under the lens in the written file.
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

constexpr double kGrossPx = 2;

std::vector<CornerMethod> corner_methods() {
  return {our_corners(),          our_corners_under_the_lens(), our_corners_of_edges(),
          apriltag_corners(true), apriltag_corners(false),      opencv_corners()};
}

class CornerErrors {
 public:
  void add(const TagCorners& found, const TagCorners& truth) {
    for (std::size_t i = 0; i < 4; ++i) {
      const double e = (found[i] - truth[i]).squaredNorm();
      squares_ += e, largest_px_ = std::max(largest_px_, std::sqrt(e));
    }
    coordinates_ += 8;
  }

  double largest_px() const { return largest_px_; }
  double rms_px() const { return std::sqrt(squares_ / coordinates_); }  // of a coordinate

 private:
  double squares_ = 0, largest_px_ = 0;
  int coordinates_ = 0;
};

Verdict judge(const std::optional<CornerAnswer>& answer, const CornerTask& task) {
  if (!answer) return {};
  CornerErrors errors;
  errors.add(answer->corners, task.view.corners);
  return {!(errors.largest_px() < kGrossPx), errors.rms_px(), errors.rms_px() / task.bound_px()};
}

Verdict judge_picture(const std::vector<PeerTag>& found, const PictureTask& task) {
  CornerErrors errors;
  for (const auto& [id, truth] : task.corners) {
    const auto tag = std::ranges::find(found, id, &PeerTag::id);
    if (tag == found.end()) return {};
    errors.add(tag->corners, truth);
  }
  return {!(errors.rms_px() < kGrossPx), errors.rms_px(), errors.rms_px() / task.bound_px};
}

std::vector<Attempt> draw(TagViewSpec spec, const std::vector<CornerMethod>& methods,
                          Random& random) {
  spec.tilt_deg = random.uniform(0, 60);
  const auto task = std::make_shared<const CornerTask>(draw_corner_task(spec, random));
  return attempts_of(methods, *task, [task](const std::optional<CornerAnswer>& answer) {
    return judge(answer, *task);
  });
}

void add_pictures(const std::string& title, bool is_plain,
                  const std::vector<PictureMethod>& methods, ChartStudy& study) {
  StudyPanel panel;
  panel.panel = {"pictures of 1280x800", "", title, {}};
  if (!has_aruco()) panel.panel.cannot = {"OpenCV aruco: not installed"};
  panel.methods = study.numbers_of(methods);
  panel.draw = [is_plain, methods](Random& random) {
    const PictureTask task = draw_picture_task(is_plain, random);
    return attempts_of(methods, task, [task](const std::vector<PeerTag>& found) {
      return judge_picture(found, task);
    });
  };
  study.panels.push_back(std::move(panel));
}

// Each centre is compared with the nearest found one: OpenCV may count from another end.
Verdict judge_circles(const std::vector<Eigen::Vector2d>& found, const CircleTask& task) {
  if (found.size() < task.centres.size()) return {};
  double squares = 0;
  for (const auto& [id, truth] : task.centres) {
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& centre : found)
      least = std::min(least, (centre - truth).squaredNorm());
    squares += least;
  }
  const double rms_px = std::sqrt(squares / (2 * static_cast<double>(task.centres.size())));
  return {!(rms_px < kGrossPx), rms_px, rms_px / task.bound_px};
}

void add_circles(ChartStudy& study) {
  const std::vector<CircleMethod> methods = circle_methods();
  for (const double noise : {2.0, 8.0}) {
    StudyPanel panel;
    panel.panel = {"circles under a strong lens",
                   fmt::format("noise {:g} grey levels", noise),
                   "8 x 6 circles of 12 px",
                   {}};
    panel.methods = study.numbers_of(methods);
    panel.draw = [noise, methods](Random& random) {
      const CircleTask task = draw_circle_task(noise, random);
      return attempts_of(methods, task, [task](const std::vector<Eigen::Vector2d>& found) {
        return judge_circles(found, task);
      });
    };
    study.panels.push_back(std::move(panel));
  }
}

}  // namespace

ChartStudy corners_study() {
  ChartStudy study;
  study.error_unit = "pixels, a coordinate";
  study.bound_name = "Cramér-Rao bound under a known lens";
  study.failure =
      "a tag not found, or a corner off by more than 2 px (in pictures of many tags: RMS)";
  study.trials = 500;
  study.quick_trials = 30;
  const std::vector<CornerMethod> methods = corner_methods();
  for (const double noise : {2.0, 8.0})
    for (const double side : {20.0, 40.0, 80.0}) {
      StudyPanel panel;
      panel.panel = {"",
                     fmt::format("noise {:g} grey levels", noise),
                     fmt::format("tag {:g} px wide", side),
                     {}};
      panel.methods = study.numbers_of(methods);
      TagViewSpec spec;
      spec.side_px = side;
      spec.noise_levels = noise;
      panel.draw = [spec, methods](Random& random) { return draw(spec, methods, random); };
      study.panels.push_back(std::move(panel));
    }
  add_circles(study);
  add_pictures("36 plain tags", true, picture_methods(), study);
  add_pictures("36 tags of Kalibr", false, picture_methods(), study);
  add_pictures("rendering of 36 tags of Kalibr", false, {render_method()}, study);
  return study;
}

}  // namespace tagcal::study
