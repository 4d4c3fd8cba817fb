#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal {

// The difference of the projections of two lenses at one distance, in pixels.
struct LensDifference {
  double distance_m = kInfinitelyFar;
  Pose b_from_a;  // motion of the camera that is subtracted; at infinity a rotation
  ImageGrid grid;
  MatrixX u_px, v_px;  // b - a at the nodes (rows x columns); NaN if a or b has no value there
  double rms_px = 0;   // over the samples of the region, sqrt(mean |d|^2)
  double max_px = 0;
};

// Projects the points at a distance along the rays of lens a by lens b, from the pose b_from_a that
// fits best over the samples (pixels of a). No value if fewer than six samples are visible in both
// lenses, or no pose is found. Throws Error if the images differ in size.
std::optional<LensDifference> lens_difference(const Camera& a, const Camera& b,
                                              std::span<const Eigen::Vector2d> samples,
                                              double distance_m);

// The samples of an image (pixels) that lie in the regions where both of two calibrations had
// corners. An empty region is not known and takes nothing away; if both are empty, the samples
// cover the whole image.
std::vector<Eigen::Vector2d> common_samples(const ImageSize& size, const SeenRegion& a,
                                            const SeenRegion& b);

// The verdict of a test for a change of a camera: of new pictures (check_camera), or of two
// calibrations.
enum class CheckVerdict {
  valid,        // no change is seen, and one of the limit would have been
  changed,      // the data contradict one camera (p < policy::kFalseAlarm)
  cannot_tell,  // no change is seen, but one of the limit could be hidden
};
std::string_view verdict_name(CheckVerdict verdict);  // as in the enum

// The rule of all such tests. in_sigmas: the normal score of the test; smallest_px: the smallest
// change that it shows with the probability policy::kDetectionPower; limit_px: that which matters.
CheckVerdict change_verdict(double in_sigmas, double smallest_px, double limit_px);

// What the covariances of two independent calibrations predict for the difference of their lenses
// if both are right.
struct DifferenceTest {
  double expected_px = 0;  // of LensDifference::rms_px: sqrt(mean E|d|^2)
  // Score of the difference found: the quantile of a standard normal variable that is exceeded with
  // the same probability. Consistent calibrations give 0 +- 1.
  double in_sigmas = 0;
  // The smallest change of focal length or principal point that the test shows: its largest
  // displacement at a sample. Infinite if the model of neither lens has them.
  double smallest_px = 0;
};

// The test of the differences d at the samples. With A the aligned Jacobians
// (projection_uncertainty.hpp) and C the covariances, d has the covariance
//   M = A_a C_a A_a' + A_b C_b A_b' = sum of s_i^2 u_i u_i',
// whose directions u_i are principal ones. Tested is
//   T = sum of w_i (u_i' d / s_i)^2,  w_i = s_i^2 / (s_i^2 + e^2),  E T = sum w, Var T = 2 sum w^2:
// a change shows if it is large beside what is known of its own direction. e^2 is a share of tr M
// (policy::kNegligibleShare); of lenses of two kinds tr M, so that T is nearly the sum of squares:
// what one kind leaves of the other is large in directions that both know well. T nu /
// E T is taken as chi-square of nu = (sum w)^2 / sum w^2 degrees of freedom (Satterthwaite 1946),
// whose quantile is that of Wilson and Hilferty (1931). A change of a parameter shows if T grows by
// lambda E T / nu, with the non-centrality lambda of that chi-square. A lens without a covariance
// counts as exact. No value if both are, or if fewer than six samples have a ray in both.
std::optional<DifferenceTest> difference_test(const UncertainCamera& a, const UncertainCamera& b,
                                              std::span<const Eigen::Vector2d> samples,
                                              const LensDifference& difference);

}  // namespace tagcal
