#include "study/atlas/map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "study/atlas/stability_judge.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;

constexpr int kCellsAcross = 8;  // of tag36h11, its border included

// The assumed covariance of a corner without one.
Matrix2 unclaimed(const CornerTask& task, std::size_t corner, bool ours) {
  if (ours)
    return internal::policy::kAssumedSigmaPx * internal::policy::kAssumedSigmaPx *
           Matrix2::Identity();
  const auto i = static_cast<Eigen::Index>(2 * corner);
  const Matrix2 bound = task.bound_px2.block<2, 2>(i, i);
  const Matrix2 least = kLeastPeerCornerSigmaPx * kLeastPeerCornerSigmaPx * Matrix2::Identity();
  return bound.allFinite() ? Matrix2(bound + least) : least;
}

// Sets the methods and the problems of the map.
void ask_corners(StabilityMap& map,
                 const std::function<TagViewSpec(std::span<const double> at)>& spec_at) {
  const auto methods = std::make_shared<std::vector<CornerMethod>>(
      std::vector<CornerMethod>{our_corners(), our_corners_of_edges(), apriltag_corners(true),
                                apriltag_corners(false), opencv_corners()});
  for (const CornerMethod& m : *methods) {
    const bool ours = &m == &methods->front();
    map.methods.push_back({m.name, m.settings, ours, m.name != "AprilTag, refine_edges off"});
  }
  map.draw = [methods, spec_at](std::span<const double> at, Random& random) -> StabilityProblem {
    const auto task = std::make_shared<const CornerTask>(draw_corner_task(spec_at(at), random));
    return [task, methods](std::size_t m) -> Prepared<StabilityVerdict> {
      const CornerMethod& method = (*methods)[m];
      return judged(method.prepare(*task),
                    [task, ours = method.ours()](const std::optional<CornerAnswer>& answer) {
                      return judge_corners(answer, *task, ours);
                    });
    };
  };
}

StabilityMap tag_tilt_noise_map() {
  StabilityMap map;
  map.name = "tag-tilt-noise";
  map.title = "One tag of 40 px in a picture, blur 0.8 px: tilt and noise";
  map.axes = {{"tilt", "deg", {0, 20, 40, 50, 60, 70, 75, 80}, {}},
              {"noise", "grey levels", {0, 1, 2, 5, 10, 20, 40}, {}}};
  map.trials = 300;
  map.mark_over_map = true;
  map.what =
      "Seen from the side, cells become narrower than a pixel; in the dark, noise is as strong as "
      "the print (black 30, white 220)";
  map.why =
      "A cell's width falls with the cosine of the tilt, and a bit is the mean of few pixels; an "
      "edge's place is known to noise over contrast (limits of the photometric fit, Cramér-Rao)";
  map.answer =
      "tagcal looks in halved pictures too, where noise is less, and measures the noise in the "
      "residuals, so that the covariances grow with it";
  ask_corners(map, [](std::span<const double> at) {
    TagViewSpec spec;
    spec.tilt_deg = at[0];
    spec.noise_levels = at[1];
    return spec;
  });
  return map;
}

}  // namespace

bool is_readable(const TagViewSpec& spec) {
  const double cell = spec.side_px / kCellsAcross * std::cos(internal::radians(spec.tilt_deg));
  return spec.side_px >= kReadableSidePx &&
         cell >= kReadableCellOverBlur * std::hypot(spec.blur_px, std::sqrt(1.0 / 12));
}

StabilityVerdict judge_corners(const std::optional<CornerAnswer>& answer, const CornerTask& task,
                               bool ours) {
  StabilityVerdict verdict;
  if (!answer) {
    verdict.said = "no tag";
    verdict.outcome = is_readable(task.spec) ? StabilityOutcome::right_but_refused
                                             : StabilityOutcome::wrong_and_said;
    return verdict;
  }
  verdict.said = answer->covariance_px2 ? "covariance" : "answer";
  bool right = true;
  double squares = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d e = answer->corners[i] - task.view.corners[i];
    squares += e.squaredNorm();
    const Matrix2 claimed =
        answer->covariance_px2 ? (*answer->covariance_px2)[i] : unclaimed(task, i, ours);
    right = right && e.dot(claimed.inverse() * e) <= five_sigma_square(2);
  }
  verdict.outcome = right ? StabilityOutcome::right_and_said : StabilityOutcome::wrong_and_silent;
  verdict.over_bound = std::sqrt(squares / 8) / task.bound_px();
  return verdict;
}

StabilityMap tag_size_blur_map() {
  StabilityMap map;
  map.name = "tag-size-blur";
  map.title = "One tag in a picture, tilted by 20 degrees, 2 grey levels of noise: size and blur";
  map.axes = {{"side of the tag", "px", {8, 10, 12, 15, 20, 30, 40, 60, 100, 200}, {}},
              {"blur", "px", {0.3, 0.5, 0.8, 1.2, 1.5, 2, 3}, {}}};
  map.trials = 300;
  map.mark_over_map = true;
  map.what =
      "A small or blurred tag is not found, or its corners are pushed outwards by an edge detector "
      "that does not know of the blur";
  map.why =
      "The neighbouring cells and the corner's own round shape reach into the window or the line "
      "that is fitted (Mallon & Whelan, Pattern Recognition Letters 2007, on such bias), and bits "
      "mix where cells are narrower than the blur";
  map.answer =
      "tagcal fits the whole printed pattern with its blur, so that each corner comes with a "
      "covariance, and gives none where the fit does not converge";
  map.exempt = {"rolling shutter: a picture is taken at one time here"};
  ask_corners(map, [](std::span<const double> at) {
    TagViewSpec spec;
    spec.side_px = at[0];
    spec.blur_px = at[1];
    spec.tilt_deg = 20;
    return spec;
  });
  return map;
}

std::vector<StabilityMap> picture_maps() { return {tag_size_blur_map(), tag_tilt_noise_map()}; }

}  // namespace tagcal::study
