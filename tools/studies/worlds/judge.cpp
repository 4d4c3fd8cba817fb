#include "judge.hpp"

#include <Eigen/LU>
#include <cmath>
#include <ctime>
#include <map>
#include <utility>

#include "judge_lens.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Seconds since the last call.
class Lap {
 public:
  double operator()() {
    const double before = std::exchange(last_, thread_seconds());
    return last_ - before;
  }

 private:
  double last_ = thread_seconds();
};

struct Rendered {
  std::vector<ImageSource> pictures;
  std::vector<std::map<CornerId, Eigen::Vector2d>> corners;  // exact
};

// Renders as `tagcal render` does.
Rendered rendered(const World& world) {
  const Scene& scene = world.scene;
  TagFamilies families;
  for (const PlacedBoard& placed : scene.boards)
    families[placed.board.family] = tag_family(placed.board.family, placed.board.border_bits);
  const std::vector<Pose> poses = camera_poses(scene, render_seed(world));
  Rendered result;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const ImageF light = render_light(scene, families, poses[i]);
    const Image8 picture = expose(light, scene.sensor, Random(render_seed(world), i).next());
    result.pictures.push_back({image_name(static_cast<int>(i)), [picture] { return picture; }});
    auto& corners = result.corners.emplace_back();
    for (const Observation& o : visible_corners(scene, poses[i])) corners[o.id] = o.pixel;
  }
  return result;
}

void describe(const World& world, Record& r) {
  const Scene& scene = world.scene;
  r.seed = world.seed;
  r.index = world.index;
  r.model = scene.model;
  r.width = scene.camera.image_size.width;
  r.height = scene.camera.image_size.height;
  r.field_of_view_deg = world.field_of_view_deg;
  r.views = scene.num_views;
  r.tags_on_board = static_cast<int>(scene.boards[0].board.tags.size());
  r.border_bits = scene.boards[0].board.border_bits;
  r.tag_px = world.tag_px;
  r.coverage = world.coverage;
  r.most_tilt_deg = world.most_tilt_deg;
  r.blur_px = scene.sensor.blur_px;
  r.noise_levels = scene.sensor.noise_levels;
  r.ink_spread_px = world.ink_spread_px;
  r.gamma = scene.sensor.gamma;
  r.occluders = static_cast<int>(scene.occluders.size());
}

template <typename Corners, typename IdOf>
int whole_tags(const Corners& corners, const IdOf& tag_of) {
  std::map<int, int> seen;
  for (const auto& corner : corners) ++seen[tag_of(corner)];
  int whole = 0;
  for (const auto& [tag, count] : seen) whole += count == 4;
  return whole;
}

void judge_corner(const Observation& o, const Eigen::Vector2d& truth, Record& r) {
  const Eigen::Vector2d error = o.pixel - truth;
  r.corner_worst_px = std::max(r.corner_worst_px, error.norm());
  if (!o.covariance_px2) return;
  const Eigen::Matrix2d covariance = *o.covariance_px2;
  const double square = error.dot(covariance.inverse() * error);
  // Nothing is within a covariance that is not positive.
  const double distance = square >= 0 ? std::sqrt(square) : HUGE_VAL;
  r.corners_beyond += distance > kFiveSigma2;
  r.corner_squares += distance * distance;
  r.corner_worst = std::max(r.corner_worst, distance);
}

void judge_corners(const Rendered& truth, const std::vector<View>& views, Record& r) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto& exact = truth.corners[v];
    r.tags_visible += whole_tags(exact, [](const auto& c) { return c.first.tag_id; });
    r.tags += whole_tags(views[v].observations, [](const Observation& o) { return o.id.tag_id; });
    std::vector<CornerId> fitted;
    for (const Observation& o : views[v].observations) {
      ++r.corners;
      if (o.covariance_px2)
        fitted.push_back(o.id);
      else
        ++r.corners_without_covariance;
      if (const auto found = exact.find(o.id); found != exact.end())
        judge_corner(o, found->second, r);
      else
        ++r.corners_hidden;
    }
    r.tags_fitted += whole_tags(fitted, [](const CornerId& id) { return id.tag_id; });
  }
}

// "code: sentence | code: sentence".
std::string joined(const std::vector<Finding>& findings) {
  std::string line;
  for (const Finding& finding : findings)
    line += (line.empty() ? "" : " | ") + finding.code + ": " + finding.sentence;
  return line;
}

void judge_answer(const Camera& truth, const Calibration& c, Record& r) {
  r.status = status_name(c.status);
  r.answer = c.model;
  r.inliers = c.num_corners;
  r.left_out = static_cast<int>(c.outliers.size());
  r.model_error_px = c.model_error_px;
  r.findings = joined(c.findings);
  if (is_answer(c.status)) judge_lens(truth, c, r);
}

// Calibrates with the model that made the data.
void ask_by_name(const Camera& truth, const Dataset& dataset, Record& r) {
  CalibrateOptions options;
  options.model = r.model;
  const Calibration c = calibrate(dataset, options);
  r.named_status = status_name(c.status);
  if (!is_answer(c.status)) return;
  Record named;
  judge_lens(truth, c, named);
  r.named_f_ratio = named.f_ratio;
  r.named_region_ratio = named.region_ratio;
}

}  // namespace

Record judge(const World& world) {
  Record r;
  describe(world, r);
  Lap lap;
  const Rendered set = rendered(world);
  r.render_s = lap();
  const Scene& scene = world.scene;
  DetectOptions detect;
  detect.threads = 1;
  Dataset dataset{scene.camera.image_size, scene.boards, {}, {}};
  dataset.views = detect_all(set.pictures, scene.boards, detect).views;
  r.detect_s = lap();
  const Calibration c = calibrate(dataset);
  r.calibrate_s = lap();
  judge_corners(set, dataset.views, r);
  judge_answer(scene.camera, c, r);
  if (!is_answer(c.status)) ask_by_name(scene.camera, dataset, r);
  return r;
}

}  // namespace tagcal
