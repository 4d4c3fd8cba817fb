#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <numbers>

#include "judge.hpp"
#include "studies/checker_pictures.hpp"
#include "study/processor_time.hpp"
#include "study/quantile.hpp"
#include "tagcal/detect/detector.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

constexpr std::uint64_t kNoiseStream = 2000, kFirstViewStream = 3000;  // stream_of

// px. From corners that a fit of large, sharp tags finds to those of small, blurred ones.
constexpr double kLeastNoise_px = 0.003, kLargestNoise_px = 0.3;
// By which the noise of a corner differs from that of the world, as blur and light differ within a
// picture.
constexpr double kLeastFactor = 0.5, kLargestFactor = 2;
// Ratio of the axes of a corner's covariance: an edge is found across itself, and the corner of a
// tilted tag where two edges meet at a flat angle.
constexpr double kLargestAxisRatio = 3;
// Share of gross outliers: a few tags that were taken for others, not a wrong target file.
constexpr double kLeastOutliers = 0.01, kMostOutliers = 0.03;
// px, and standard deviations of the corner: what is nearer may be noise.
constexpr double kLeastOutlier_px = 2, kLargestOutlier_px = 50, kLeastOutlierSigmas = 10;

struct Noise {
  double sd_px = 0;
  double share_outliers = 0;
};

Noise draw_noise(const World& world) {
  Random random = stream_of(world.id, kNoiseStream);
  Noise noise;
  noise.sd_px = log_uniform(kLeastNoise_px, kLargestNoise_px, random);
  const double share = random.uniform(kLeastOutliers, kMostOutliers);
  if (world.defects.outliers) noise.share_outliers = share;
  return noise;
}

Vector2d direction(Random& random) {
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  return {std::cos(angle), std::sin(angle)};
}

// A covariance whose determinant is that of `sd_px` in both axes.
Matrix2 draw_covariance(double sd_px, Random& random) {
  const double ratio = log_uniform(1, kLargestAxisRatio, random);
  const Vector2d along = direction(random), across(-along.y(), along.x());
  return sd_px * sd_px * (ratio * along * along.transpose() + across * across.transpose() / ratio);
}

// A corner with its error. `gross` is set to 1 if it is an outlier.
Observation measured(const CornerId& id, const Vector2d& exact, const Noise& noise, Random& random,
                     char& gross) {
  const double sd = noise.sd_px * log_uniform(kLeastFactor, kLargestFactor, random);
  Observation o{id, exact, draw_covariance(sd, random)};
  const double x = random.normal(), y = random.normal();
  const Matrix2 root = o.covariance_px2->llt().matrixL();
  o.pixel += root * Vector2d(x, y);
  gross = random.uniform() < noise.share_outliers;
  const double least = std::max(kLeastOutlier_px, kLeastOutlierSigmas * sd);
  const double away = log_uniform(least, kLargestOutlier_px, random);
  const Vector2d side = direction(random);
  if (gross) o.pixel += away * side;
  return o;
}

// Draws the corners of one view.
class ViewOfCorners {
 public:
  ViewOfCorners(const World& world, std::size_t view)
      : world_(world), random_(stream_of(world.id, kFirstViewStream + view)) {
    const Vector2d side = direction(random_);
    shear_px_ = world.defects.rows_px * random_.uniform() * side;
  }

  // The corners in the image. Each point draws the same numbers whether it is in the image or not,
  // so that a bend does not change the noise of the other corners.
  View corners(const Pose& camera_from_board, const RealBoard& board, const Noise& noise,
               std::vector<char>& gross) {
    const Camera& camera = world_.scene.camera;
    View view;
    for (const TargetPoint& point : target_points(world_.scene.boards[0].board)) {
      const auto exact = project(camera.lens, camera_from_board * board.place_of(point.position));
      char is_gross = 0;
      const Vector2d pixel = exact ? Vector2d(*exact + sheared(*exact)) : Vector2d(0, 0);
      Observation o = measured(point.id, pixel, noise, random_, is_gross);
      if (!exact || !contains(camera.image_size, *exact)) continue;
      if (is_gross && !contains(camera.image_size, o.pixel)) continue;  // nothing is found there
      if (!world_.defects.covariances) o.covariance_px2.reset();
      view.observations.push_back(o);
      gross.push_back(is_gross);
    }
    return view;
  }

 private:
  // The camera moves while it reads its rows, from the uppermost to the lowest.
  Vector2d sheared(const Vector2d& pixel) const {
    const double half_height = 0.5 * world_.scene.camera.image_size.height;
    const double from_middle = pixel.y() - image_centre(world_.scene.camera.image_size).y();
    return shear_px_ * from_middle / half_height;
  }

  const World& world_;
  Random random_;
  Vector2d shear_px_;
};

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

Measured project_corners(const World& world, Record& record) {
  const Scene& scene = world.scene;
  const RealBoard board(scene.boards[0].board, world.defects);
  const Noise noise = draw_noise(world);
  record.noise_px = noise.sd_px;
  Measured result{{scene.camera.image_size, scene.boards, {}, {}}, {}};
  const auto& poses = std::get<ExplicitPath>(scene.path).camera_from_world;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    auto& gross = result.gross.emplace_back();
    View view = ViewOfCorners(world, i).corners(poses[i], board, noise, gross);
    view.image = image_name(static_cast<int>(i));
    record.corners += static_cast<int>(view.observations.size());
    result.dataset.views.push_back(std::move(view));
  }
  return result;
}

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
