#include "study/chart/corner_methods.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "study/peers/tag_peers.hpp"
#include "tagcal/detect/board_search/tag_search.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

using Eigen::Vector2d;

std::optional<CornerAnswer> first_of(const std::vector<DetectedTag>& tags) {
  if (tags.empty()) return std::nullopt;
  CornerAnswer answer{tags.front().corners, {}};
  const auto& covariance = tags.front().covariance_px2;
  if (!covariance) return answer;
  answer.covariance_px2.emplace();
  for (int i = 0; i < 4; ++i)
    (*answer.covariance_px2)[static_cast<std::size_t>(i)] = covariance->block<2, 2>(2 * i, 2 * i);
  return answer;
}

CornerMethod our_method(const std::string& name, const std::string& settings, Refinement refinement,
                        bool lens_is_known) {
  struct Search {
    CornerTask task;
    TagFinder find;
  };
  const auto prepare = [=](const CornerTask& task) {
    const auto search = std::make_shared<Search>(Search{task, {}});
    DetectOptions options;
    options.refinement = refinement;
    if (lens_is_known) options.camera = &search->task.view.camera;
    search->find = our_finder({task.board}, options);
    return prepare_task<std::optional<CornerAnswer>>(
        search, [](const auto& s) { return first_of(s->find(s->task.view.image)); });
  };
  return {name, prepare, settings};
}

// By AprilTag's detector of the calling thread.
std::optional<CornerAnswer> found_by_apriltag(const CornerTask& task, bool refine_edges) {
  thread_local std::unique_ptr<AprilTagPeer> detector;
  if (!detector) detector = std::make_unique<AprilTagPeer>(task.spec.family, task.spec.border_bits);
  for (const PeerTag& tag : detector->find(task.view.image, refine_edges))
    if (tag.id == task.view.id) return CornerAnswer{tag.corners, {}};
  return std::nullopt;
}

Quad with_subpix(const CornerTask& task, const Quad& start) {
  const Image8& view = task.view.image;
  cv::Mat image(view.height(), view.width(), CV_8U, const_cast<std::uint8_t*>(view.row(0)));
  std::vector<cv::Point2f> corners;
  for (const Vector2d& c : start)
    corners.emplace_back(static_cast<float>(c.x()), static_cast<float>(c.y()));
  const int half = std::clamp(static_cast<int>(task.spec.side_px / 8), 2, 5);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 30, 0.001});
  Quad result;
  for (std::size_t i = 0; i < 4; ++i) result[i] = {corners[i].x, corners[i].y};
  return result;
}

CornerMethod stock_method(const std::string& name, const std::string& settings, bool refine_edges,
                          bool subpix) {
  const auto prepare = [=](const CornerTask& given) {
    return prepare_task<std::optional<CornerAnswer>>(given, [=](const CornerTask& task) {
      auto found = found_by_apriltag(task, refine_edges);
      if (subpix && found) found->corners = with_subpix(task, found->corners);
      return found;
    });
  };
  return {name, prepare, settings};
}

}  // namespace

TagFinder our_finder(const std::vector<PlacedBoard>& boards, const DetectOptions& options) {
  struct Search {
    std::vector<PlacedBoard> boards;  // outlives the search
    std::vector<TagSearch> by_kind;
  };
  const auto search = std::make_shared<Search>(Search{boards, {}});
  const std::scoped_lock lock(apriltag_family_lock());
  search->by_kind = tag_searches(search->boards, options);
  return [search](const ImageView8& image) {
    const SeenTags seen = search->by_kind.front().find(image);
    std::vector<DetectedTag> tags;
    for (const Completion& completion : seen.completions)
      for (const FoundTag& tag : completion.tags) {
        tags.push_back({tag.id, tag.corners, {}});
        if (tag.fitted) tags.back().covariance_px2 = tag.covariance_px2;
      }
    return tags;
  };
}

CornerBound corner_bound(const Image8& noiseless, const TagPattern& pattern, const Quad& corners,
                         const Camera& camera, double noise_levels) {
  TagFitOptions options;
  options.camera = &camera;
  // Without noise the residuals are those of rounding, which are not independent: a fit would say
  // so.
  Image8 picture = noiseless;
  Random random(1);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      picture(x, y) = static_cast<std::uint8_t>(
          std::clamp(std::round(picture(x, y) + random.normal()), 0.0, 255.0));
  const TagFit exact = refine_tag(picture, pattern, corners, options);
  if (exact.status != TagFitStatus::converged) return CornerBound::Constant(std::nan(""));
  const double noise = std::hypot(noise_levels, std::sqrt(1.0 / 12));
  return exact.covariance_px2 * (noise / exact.noise_levels) * (noise / exact.noise_levels);
}

double CornerTask::bound_px() const { return std::sqrt(bound_px2.trace() / 8); }

CornerTask draw_corner_task(const TagViewSpec& spec, Random& random) {
  CornerTask task{spec, rendered_tag(spec, random), {}, {}, {}};
  const int id = task.view.id;
  task.board = {make_board(spec.board(id)), Pose()};
  task.pattern = tag_pattern(tag_family(spec.family, spec.border_bits), id, spec.border_bits);
  task.bound_px2 = corner_bound(task.view.noiseless, task.pattern, task.view.corners,
                                task.view.camera, spec.noise_levels);
  return task;
}

CornerMethod our_corners() {
  return our_method("tagcal detect", "the whole tag fitted; the lens not known", Refinement::fit,
                    false);
}

CornerMethod our_corners_of_edges() {
  return our_method("tagcal detect, edges", "--refinement edges", Refinement::edges, false);
}

CornerMethod our_corners_under_the_lens() {
  return our_method("tagcal detect, lens known", "--camera: the whole tag fitted under its lens",
                    Refinement::fit, true);
}

CornerMethod apriltag_corners(bool refine_edges) {
  return stock_method(refine_edges ? "AprilTag, refine_edges on" : "AprilTag, refine_edges off",
                      "quad_decimate 1, one thread, 0.5 px subtracted", refine_edges, false);
}

CornerMethod opencv_corners() {
  return stock_method("OpenCV cornerSubPix",
                      "from AprilTag's corners (refine_edges off), half a window of an eighth of "
                      "the tag (2 to 5 px), 30 iterations, 0.001 px",
                      false, true);
}

}  // namespace tagcal::study
