#include <cmath>
#include <map>

#include "judge.hpp"
#include "studies/checker_pictures.hpp"
#include "study/processor_time.hpp"
#include "study/quantile.hpp"
#include "tagcal/detect/detector.hpp"

namespace tagcal {
namespace {

constexpr double kGross_px = 2;  // as the outliers that project_corners draws

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
  const double distance = std::sqrt(study::squared_distance(error, *o.covariance_px2));
  r.corners_beyond += distance > kFiveSigma2;
  r.corner_squares += distance * distance;
  r.corner_worst = std::max(r.corner_worst, distance);
}

// Returns Measured::gross of a view.
std::vector<char> judge_view(const ExactCorners& exact, const View& view, Record& r) {
  std::vector<char> gross;
  std::vector<CornerId> fitted;
  for (const Observation& o : view.observations) {
    ++r.corners;
    if (o.covariance_px2)
      fitted.push_back(o.id);
    else
      ++r.corners_without_covariance;
    const auto found = exact.find(o.id);
    gross.push_back(found == exact.end() || (o.pixel - found->second).norm() >= kGross_px);
    if (found != exact.end())
      judge_corner(o, found->second, r);
    else
      ++r.corners_hidden;
  }
  r.tags_visible += whole_tags(exact, [](const auto& c) { return c.first.tag_id; });
  r.tags += whole_tags(view.observations, [](const Observation& o) { return o.id.tag_id; });
  r.tags_fitted += whole_tags(fitted, [](const CornerId& id) { return id.tag_id; });
  return gross;
}

}  // namespace

Measured render_and_detect(const World& world, Record& r) {
  study::Lap lap;
  const ExactPictures set = rendered(real_scene(world), render_seed(world));
  r.render_s = lap();
  const Scene& scene = world.scene;
  DetectOptions detect;
  detect.threads = 1;
  Measured result{{scene.camera.image_size, scene.boards, {}, {}}, {}};
  result.dataset.views = views_of(detect_all(set.sources, scene.boards, detect));
  r.detect_s = lap();
  for (std::size_t v = 0; v < set.corners.size(); ++v)
    result.gross.push_back(judge_view(set.corners[v], result.dataset.views[v], r));
  return result;
}

}  // namespace tagcal
