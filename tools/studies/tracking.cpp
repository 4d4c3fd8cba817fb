// Boards that are followed from frame to frame (detect/detector.hpp: BoardTracker) beside a search
// of every frame. An input is a scene; a trial is a row of consecutive frames of it, rendered with
// the scene's blur and noise. searched, followed: processor time of a frame in one thread,
// rendering excluded, of frames searched by themselves and of frames that were followed; clip: of a
// clip with a search each 20 frames, what all frames share included. Corners are compared with
// those of a search: px, in claimed standard deviations, and how many only one of both has.

#include <cmath>
#include <map>
#include <memory>

#include "studies/studies.hpp"
#include "study/processor_time.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/moving_scene.hpp"
#include "tagcal/scene/render.hpp"

namespace tagcal {
using namespace study;
namespace {

std::vector<ImageSource> clip_of(const MovingScene& scene, const std::vector<Pose>& poses,
                                 std::size_t first, std::size_t count, std::size_t step) {
  std::vector<ImageSource> frames;
  for (std::size_t i = first; i < poses.size() && frames.size() < count; i += step) {
    const Scene now = scene_in_view(scene, static_cast<int>(i));
    const ImageF light = render_light(now, tag_families(now.boards), poses[i]);
    const Image8 picture = expose(light, now.sensor, Random(1, i).next());
    frames.push_back({std::to_string(i), [picture] { return picture; }, !frames.empty()});
  }
  return frames;
}

// How the corners of two pictures differ.
struct CornerDifference {
  double count = 0, only_one = 0, largest_px = 0, largest_sds = 0, beyond_sd = 0;

  void add(const View& a, const View& b) {
    std::map<CornerId, const Observation*> others;
    for (const Observation& corner : b.observations) others[corner.id] = &corner;
    for (const Observation& corner : a.observations) {
      const auto other = others.find(corner.id);
      if (other == others.end()) {
        ++only_one;
        continue;
      }
      const double px = (corner.pixel - other->second->pixel).norm();
      others.erase(other);
      ++count;
      largest_px = std::max(largest_px, px);
      if (!corner.covariance_px2) continue;
      const double sds = px / std::sqrt(corner.covariance_px2->trace() / 2);
      largest_sds = std::max(largest_sds, sds);
      beyond_sd += sds > 1;
    }
    only_one += static_cast<double>(others.size());
  }
};

std::vector<Values> measure(const MovingScene& scene, const std::vector<Pose>& poses,
                            const StudyOptions& study, std::uint64_t trial) {
  const auto step = static_cast<std::size_t>(study.number("step"));
  const auto count = static_cast<std::size_t>(study.number("frames"));
  const std::size_t trials = static_cast<std::size_t>(std::max(1, study.count));
  const std::size_t first = poses.size() * (trial % trials) / trials;
  std::vector<ImageSource> frames = clip_of(scene, poses, first, count, step);
  const std::vector<PlacedBoard> boards = scene_in_view(scene, 0).boards;
  const DetectOptions options{.threads = 1};
  Lap lap;
  const std::vector<DetectedPicture> clip = detect_all(frames, boards, options);
  const double clip_s = lap();
  BoardTracker tracker(boards, options);
  double num_followed = 0, followed_s = 0;
  for (const ImageSource& frame : frames) {
    const Image8 picture = frame.load();
    lap();
    tracker.next(picture);
    const double seconds = lap();
    if (!tracker.has_followed()) continue;
    ++num_followed;
    followed_s += seconds;
  }
  for (ImageSource& frame : frames) frame.follows = false;
  lap();
  const std::vector<DetectedPicture> searched = detect_all(frames, boards, options);
  const double searched_s = lap();
  CornerDifference difference;
  for (std::size_t i = 0; i < frames.size(); ++i) difference.add(searched[i].view, clip[i].view);
  const auto n = static_cast<double>(frames.size());
  return {{n, num_followed, 1e3 * searched_s / n, 1e3 * followed_s / std::max(1.0, num_followed),
           1e3 * clip_s / n, difference.count, difference.only_one, difference.largest_px,
           difference.largest_sds, difference.beyond_sd}};
}

std::vector<Task> tracking_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (const std::string& file : options.inputs) {
    const auto scene = std::make_shared<const MovingScene>(read_moving_scene(file));
    const auto poses = std::make_shared<const std::vector<Pose>>(camera_poses(*scene, 1));
    tasks.push_back({std::filesystem::path(file).stem().string(),
                     [=](std::uint64_t trial) { return measure(*scene, *poses, options, trial); }});
  }
  return tasks;
}

}  // namespace

Study tracking_study() {
  const std::vector<Figure> figures = {
      sum_of("frames", "frames"),
      sum_of("followed", "followed"),
      mean_of("searched, ms", "searched_ms", 2),
      mean_of("followed, ms", "followed_ms", 2),
      ratio_of("followed : searched", "followed_ms", "searched_ms", 2),
      ratio_of("clip : searched", "clip_ms", "searched_ms", 2),
      sum_of("corners", "corners"),
      sum_of("of one", "only_one"),
      largest_of("largest, px", "largest_px", 4),
      largest_of("largest, sd", "largest_sds", 1),
      sum_of("beyond 1 sd", "beyond_sd")};
  return {.name = "tracking",
          .summary = "boards that are followed from frame to frame beside a search of each",
          .inputs = "scenes",
          .count = 5,
          .options = {{"frames", "60", "consecutive ones of a trial"},
                      {"step", "1", "views of the scene from frame to frame"}},
          .columns = {"frames", "followed", "searched_ms", "followed_ms", "clip_ms", "corners",
                      "only_one", "largest_px", "largest_sds", "beyond_sd"},
          .tasks = tracking_tasks,
          .tables = {{{"task"}, figures}}};
}

}  // namespace tagcal
