#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

// Whatever goes in, what comes out is right, or named.

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTrials = 25000;  // 1e5 cases in all

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const ImageSize kSize{1280, 800};

// A target, where it is, and what is seen of it.
struct World {
  Lens lens = centred_pinhole(900);
  std::vector<Vector3d> points;
  Pose truth;
  std::vector<Correspondence> seen;

  void observe(double sigma_px, Random& random) {
    seen = seen_by(lens, points, truth, sigma_px, random);
  }
};

// Seen at a tilt that tells its sign and the focal length.
World draw_world(Random& random) {
  World w;
  switch (random.index(4)) {
    case 0:
      w.points = tag_points(0.5);
      break;
    case 1:
      w.points = tag_points(0.4);
      break;
    case 2:
      w.points = points_in_box(6 + static_cast<int>(random.index(8)), 0.25, 0, random);
      break;
    case 3:
      w.points = points_in_box(6 + static_cast<int>(random.index(8)), 0.25, 1, random);
      break;
  }
  w.truth = looking_at_board(Vector3d::Zero(), random.uniform(0.6, 1.0), 1.0, random);
  return w;
}

// Of both kinds of estimate, in the terms that they share.
struct Answer {
  Status status;
  std::vector<PoseHypothesis> hypotheses;
  std::vector<std::size_t> outliers;
  double sigma_px, focal_px;
  std::vector<std::string> warnings;
};

Answer with_camera(const World& w, const PoseOptions& options = {}) {
  const PoseEstimate e = estimate_pose(w.seen, {w.lens, kSize}, options);
  return {e.status, e.hypotheses, e.outliers, e.sigma_px, 0, e.warnings};
}

Answer with_focal(const World& w, const PoseAndFocalOptions& options = {}) {
  const PoseAndFocalEstimate e = estimate_pose_and_focal(w.seen, kSize, options);
  EXPECT_TRUE(std::isfinite(e.sigma_focal_px) && e.covariance.allFinite());
  for (const WeakPerspectivePose& weak : e.weak_perspective) {
    EXPECT_TRUE(weak.camera_from_target.matrix().allFinite());
    EXPECT_TRUE(weak.scale_px_per_m > 0 && std::isfinite(weak.scale_px_per_m));
    EXPECT_TRUE(std::isfinite(weak.rms_px));
  }
  return {e.status, e.hypotheses, e.outliers, e.sigma_px, e.focal_px, e.warnings};
}

bool same_inliers_in_front(const Answer& answer, const World& w) {
  return std::all_of(
      answer.hypotheses.begin(), answer.hypotheses.end(), [&](const PoseHypothesis& h) {
        for (std::size_t i = 0; i < w.seen.size(); ++i)
          if (!std::binary_search(answer.outliers.begin(), answer.outliers.end(), i) &&
              !in_domain(w.lens, h.camera_from_target * w.seen[i].point))
            return false;
        return true;
      });
}

// The RMS residual of the inliers, by the definition.
double rms_px(const PoseHypothesis& h, const Answer& answer, const World& w) {
  const Lens lens = h.focal_px > 0 ? centred_pinhole(h.focal_px) : w.lens;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < w.seen.size(); ++i) {
    if (std::binary_search(answer.outliers.begin(), answer.outliers.end(), i)) continue;
    sum += (*project(lens, h.camera_from_target * w.seen[i].point) - w.seen[i].pixel).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

// What holds of every estimate, whatever went in.
void expect_sound(const Answer& answer, const World& w) {
  ASSERT_TRUE(!is_answer(answer.status) || !answer.hypotheses.empty());
  ASSERT_TRUE(is_answer(answer.status) || !answer.warnings.empty() ||
              answer.status == Status::not_converged);
  ASSERT_TRUE(std::isfinite(answer.sigma_px) && std::isfinite(answer.focal_px));
  ASSERT_TRUE(std::is_sorted(answer.outliers.begin(), answer.outliers.end()));
  ASSERT_TRUE(answer.outliers.empty() || answer.outliers.back() < w.seen.size());
  double sum = 0;
  for (const PoseHypothesis& h : answer.hypotheses) {
    ASSERT_TRUE(h.camera_from_target.matrix().allFinite());
    ASSERT_NEAR(h.camera_from_target.rotation_matrix().determinant(), 1, 1e-12);
    ASSERT_TRUE(h.covariance.allFinite() && h.covariance.diagonal().minCoeff() >= 0);
    ASSERT_TRUE(std::isfinite(h.rms_px) && std::isfinite(h.focal_px));
    sum += h.probability;
  }
  ASSERT_TRUE(answer.hypotheses.empty() || std::abs(sum - 1) < 1e-9);
  ASSERT_TRUE(same_inliers_in_front(answer, w));
}

// Rotation, and the distance at the target's centre over the camera's distance from it.
double error_of(const Pose& pose, const World& w) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : w.points)
    centre += (p - w.points[0]) / static_cast<double>(w.points.size());
  centre += w.points[0];
  return angle_between_rad(pose, w.truth) +
         (pose * centre - w.truth * centre).norm() / (w.truth * centre).norm();
}

double least_error(const Answer& answer, const World& w) {
  double least = kInfinity;
  for (const PoseHypothesis& h : answer.hypotheses)
    least = std::min(least, error_of(h.camera_from_target, w));
  return least;
}

TEST(PoseBadInput, TooFewPoints) {
  Random random(1);
  for (int i = 0; i < kTrials / 20; ++i) {
    World w = draw_world(random);
    w.points.resize(random.index(4));
    w.observe(0, random);
    EXPECT_EQ(with_camera(w).status, Status::degenerate);
    EXPECT_EQ(with_focal(w).status, Status::degenerate);
  }
}

TEST(PoseBadInput, PointsOnALineOrAtOnePlace) {
  Random random(2);
  for (int i = 0; i < kTrials / 4; ++i) {
    World w = draw_world(random);
    const Vector3d origin = w.points[0], along = w.points[1] - w.points[0];
    const bool one_place = i % 2 == 0;
    for (Vector3d& p : w.points)
      p = one_place ? origin : Vector3d(origin + random.uniform(-1, 1) * along);
    w.observe(i % 3 == 0 ? 0.5 : 0, random);
    EXPECT_EQ(with_camera(w).status, Status::degenerate);
    EXPECT_EQ(with_focal(w).status, Status::degenerate);
  }
}

// Three places do not tell one pose from up to four.
TEST(PoseBadInput, DuplicatesThatLeaveThreePoints) {
  Random random(3);
  for (int i = 0; i < kTrials / 4; ++i) {
    World w = draw_world(random);
    w.points.resize(3);
    for (std::size_t k = random.index(5) + 1; k > 0; --k)
      w.points.push_back(w.points[random.index(3)]);
    w.observe(i % 3 == 0 ? 0.5 : 0, random);
    EXPECT_EQ(with_camera(w).status, Status::degenerate);
    EXPECT_EQ(with_focal(w).status, Status::degenerate);
  }
}

TEST(PoseBadInput, DuplicatesBesideEnoughPoints) {
  Random random(4);
  for (int i = 0; i < kTrials / 10; ++i) {
    World w = draw_world(random);
    const std::size_t n = w.points.size();
    for (std::size_t k = 0; k < 3; ++k) w.points.push_back(w.points[random.index(n)]);
    w.observe(0, random);
    const Answer answer = with_camera(w);
    ASSERT_TRUE(is_answer(answer.status)) << i << " " << status_name(answer.status);
    EXPECT_LT(error_of(answer.hypotheses[0].camera_from_target, w), 1e-7);
    expect_sound(answer, w);
  }
}

TEST(PoseBadInput, NumbersThatAreNot) {
  Random random(5);
  for (int i = 0; i < kTrials / 4; ++i) {
    World w = draw_world(random);
    w.observe(0, random);
    const double bad = std::array{kNaN, kInfinity, -kInfinity}[random.index(3)];
    Correspondence& c = w.seen[random.index(w.seen.size())];
    const auto k = static_cast<Eigen::Index>(random.index(5));
    (k < 3 ? c.point[k] : c.pixel[k - 3]) = bad;
    EXPECT_EQ(with_camera(w).status, Status::degenerate);
    EXPECT_EQ(with_focal(w).status, Status::degenerate);
  }
}

TEST(PoseBadInput, NumbersNearTheEndOfTheRange) {
  Random random(6);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.points.resize(i % 2 == 0 ? 4 : w.points.size());
    w.observe(0, random);
    const double huge = std::pow(10.0, random.uniform(5, 308)) * (i % 3 == 0 ? -1 : 1);
    Correspondence& c = w.seen[random.index(w.seen.size())];
    const auto k = static_cast<Eigen::Index>(random.index(5));
    (k < 3 ? c.point[k] : c.pixel[k - 3]) = huge;
    const bool robust = i % 10 == 0;
    for (const Answer& answer : {with_camera(w, {.reject_outliers = robust}),
                                 with_focal(w, {{.reject_outliers = robust}, 0})}) {
      expect_sound(answer, w);
      if (!is_answer(answer.status)) continue;
      EXPECT_LT(least_error(answer, w), 1e-5) << i << " " << huge << " " << k;
    }
  }
}

TEST(PoseBadInput, AnyUnitOfLengthAndAnyPlaceOfTheTarget) {
  Random random(7);
  for (int i = 0; i < kTrials / 4; ++i) {
    World w = draw_world(random);
    const double unit = std::pow(10.0, random.uniform(-9, 9));
    for (Vector3d& p : w.points) p *= unit;
    const Vector3d offset =
        unit * 1e6 * Vector3d(random.normal(), random.normal(), random.normal());
    for (Vector3d& p : w.points) p += offset;
    // The same view: the target's frame moves against the target.
    w.truth = Pose(w.truth.rotation(), unit * w.truth.translation() - w.truth.rotation() * offset);
    for (const Vector3d& p : w.points)
      w.seen.push_back(
          {p, *project(w.lens, w.truth.rotation() * (p - offset) +
                                   (w.truth.translation() + w.truth.rotation() * offset))});
    const PoseOptions options{.sigma_px = 0.01};
    const Answer answer = with_camera(w, options), focal = with_focal(w, {options, 0});
    ASSERT_EQ(answer.status, Status::ok) << i;
    ASSERT_EQ(focal.status, Status::ok) << i;
    // A coordinate of 1e6 is good to 1e-10 of the target; a pose of it likewise.
    EXPECT_LT(angle_between_rad(answer.hypotheses[0].camera_from_target, w.truth), 1e-6) << i;
    EXPECT_LT(angle_between_rad(focal.hypotheses[0].camera_from_target, w.truth), 1e-5) << i;
    EXPECT_NEAR(focal.focal_px, 900, 0.01) << i;
  }
}

TEST(PoseBadInput, MirroredTargets) {
  Random random(8);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    const bool in_plane = w.points.size() == 4 || i % 2 == 0;
    if (in_plane)
      for (Vector3d& p : w.points) p.z() = 0;
    w.observe(0, random);
    World mirrored = w;
    for (Correspondence& c : mirrored.seen) c.point.x() *= -1;
    for (Vector3d& p : mirrored.points) p.x() *= -1;
    const PoseOptions options{.reject_outliers = i % 10 == 0};
    for (const Answer& answer :
         {with_camera(mirrored, options), with_focal(mirrored, {options, 0})}) {
      expect_sound(answer, mirrored);
      // A plane seen from behind is an honest answer; space has none.
      if (in_plane) {
        ASSERT_TRUE(is_answer(answer.status)) << i;
        EXPECT_LT(rms_px(answer.hypotheses[0], answer, mirrored), 1e-6);
      } else if (is_answer(answer.status)) {
        EXPECT_LT(rms_px(answer.hypotheses[0], answer, mirrored), 5) << i;
      }
    }
  }
}

TEST(PoseBadInput, FrontalAndTurnedBy180Degrees) {
  Random random(9);
  for (int i = 0; i < kTrials; ++i) {
    World w = draw_world(random);
    const double tilt = std::array{0.0, 1e-12, 1e-9, 1e-6, 1e-3}[random.index(5)];
    const std::array turns = {exp_rotation({std::numbers::pi, 0, 0}),
                              exp_rotation({0, std::numbers::pi, 0}),
                              exp_rotation({0, 0, std::numbers::pi}), exp_rotation({0, 0, 0})};
    w.truth = Pose(
        exp_rotation(tilt * Vector3d(random.normal(), random.normal(), 0)) * turns[random.index(4)],
        Vector3d(random.uniform(-0.3, 0.3), random.uniform(-0.2, 0.2), 1));
    if (i % 3 == 0) w.truth = Pose(turns[random.index(4)], Vector3d(0, 0, 1));
    w.observe(0, random);
    const Answer answer = with_camera(w);
    ASSERT_TRUE(is_answer(answer.status)) << i;
    expect_sound(answer, w);
    // Next to frontal the two poses are nearly one: the digits of the pixels halve.
    EXPECT_LT(least_error(answer, w), 1e-5) << i;
    EXPECT_LT(rms_px(answer.hypotheses[0], answer, w), 1e-6) << i;
    const Answer focal = with_focal(w);
    expect_sound(focal, w);
    if (is_answer(focal.status)) {
      EXPECT_LT(rms_px(focal.hypotheses[0], focal, w), 1e-6) << i;
    }
  }
}

TEST(PoseBadInput, NoiseThatIsNone) {
  Random random(10);
  for (int i = 0; i < kTrials / 8; ++i) {
    World w = draw_world(random);
    w.observe(0.3, random);
    const double sigma =
        std::array{-1.0, kNaN, -kInfinity, kInfinity, 1e300, 1e-300}[random.index(6)];
    EXPECT_EQ(with_camera(w, {.sigma_px = sigma}).status, Status::degenerate) << sigma;
    EXPECT_EQ(with_focal(w, {{.sigma_px = sigma}, 0}).status, Status::degenerate) << sigma;
  }
}

TEST(PoseBadInput, NoiseOutOfAllProportion) {
  Random random(11);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.observe(i % 2 == 0 ? 0.3 : 0, random);
    const double sigma = std::array{1e100, 1e10, 1e4, 1e-4, 1e-10, 1e-100}[random.index(6)];
    const PoseOptions options{.sigma_px = sigma, .reject_outliers = i % 10 == 0};
    expect_sound(with_camera(w, options), w);
    expect_sound(with_focal(w, {options, 0}), w);
  }
}

TEST(PoseBadInput, PriorFocalLengthsThatAreNone) {
  Random random(18);
  World w = draw_world(random);
  w.points = tag_points(0.1);
  w.truth = looking_at_board(Vector3d::Zero(), 0, 1, random);
  w.observe(0.3, random);
  for (const double prior : {kNaN, kInfinity, -kInfinity, -900.0}) {
    const Answer answer = with_focal(w, {{}, prior});
    EXPECT_EQ(answer.status, Status::degenerate) << prior;
    EXPECT_TRUE(answer.hypotheses.empty());
  }
  for (const double prior : {1e-300, 1e-9, 1e9, 1e300}) expect_sound(with_focal(w, {{}, prior}), w);
}

TEST(PoseBadInput, CovariancesThatAreNone) {
  Random random(12);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.observe(0.3, random);
    std::vector<Matrix2> covariances(w.seen.size(), 0.09 * Matrix2::Identity());
    Matrix2& bad = covariances[random.index(covariances.size())];
    switch (random.index(6)) {
      case 0:
        bad.setZero();
        break;
      case 1:
        bad(random.index(2) == 0 ? 0 : 3) = kNaN;
        break;
      case 2:
        bad *= -1;
        break;
      case 3:
        bad << 0.09, 0.2, 0.2, 0.09;
        break;
      case 4:
        bad *= kInfinity;
        break;
      case 5:
        bad << 0.09, 0.09, 0.09, 0.09;
        break;
    }
    const PoseOptions options{.reject_outliers = i % 10 == 0, .covariance_px2 = covariances};
    for (const Answer& answer : {with_camera(w, options), with_focal(w, {options, 0})}) {
      expect_sound(answer, w);
      EXPECT_EQ(answer.status, Status::degenerate) << bad;
    }
  }
}

TEST(PoseBadInput, SpansOfAnotherSize) {
  Random random(13);
  for (int i = 0; i < 200; ++i) {
    World w = draw_world(random);
    w.observe(0.3, random);
    // So that the search for those that agree is entered, where groups count.
    w.seen[0].pixel += Vector2d(100, 50);
    const std::size_t n = random.index(2 * w.seen.size()) + 1;
    if (n == w.seen.size()) continue;
    const std::vector<Matrix2> covariances(n, 0.09 * Matrix2::Identity());
    const std::vector<int> groups(n, 1);
    for (const PoseOptions& options :
         {PoseOptions{.covariance_px2 = covariances}, PoseOptions{.groups = groups}}) {
      EXPECT_EQ(with_camera(w, options).status, Status::degenerate);
      EXPECT_EQ(with_focal(w, {options, 0}).status, Status::degenerate);
    }
  }
}

TEST(PoseBadInput, AnImageWithoutSize) {
  Random random(14);
  World w = draw_world(random);
  w.observe(0, random);
  for (const ImageSize& size : {ImageSize{0, 0}, ImageSize{0, 800}, ImageSize{-5, 800}}) {
    const auto e = estimate_pose_and_focal(w.seen, size);
    EXPECT_EQ(e.status, Status::degenerate);
    EXPECT_FALSE(e.warnings.empty());
  }
}

// Beyond the fold of a lens, pixels have no ray.
TEST(PoseBadInput, PixelsWithoutARay) {
  Random random(15);
  for (int i = 0; i < kTrials / 40; ++i) {
    World w = draw_world(random);
    w.lens = i % 2 == 0 ? Lens(Perspective({900, 900, 640, 400, -0.3, 0, 0, 0, 0}))
                        : Lens(Fisheye({300, 300, 640, 400, -0.05, 0, 0, 0}));
    w.observe(0, random);
    const bool few = i % 4 < 2;
    const std::size_t bad = few ? 1 : w.seen.size();
    for (std::size_t k = 0; k < bad; ++k) w.seen[k].pixel = {random.uniform(3000, 1e6), 5000};
    const Answer answer = with_camera(w, {.reject_outliers = i % 10 < 4});
    expect_sound(answer, w);
    if (is_answer(answer.status)) {
      EXPECT_EQ(answer.outliers, std::vector<std::size_t>{0});
      EXPECT_LT(least_error(answer, w), 1e-6) << i;
    }
  }
}

// Nothing to be found, only to be survived: numbers of any kind and size.
TEST(PoseBadInput, Anything) {
  Random random(16);
  int answers = 0;
  for (int i = 0; i < kTrials; ++i) {
    World w;
    const auto number = [&] {
      switch (random.index(12)) {
        case 0:
          return 0.0;
        case 1:
          return random.normal() * std::pow(10.0, random.uniform(-300, 300));
        case 2:
          return std::round(random.normal());
        default:
          return random.normal();
      }
    };
    const std::size_t n = 3 + random.index(6);
    for (std::size_t k = 0; k < n; ++k)
      w.seen.push_back({{number(), number(), i % 2 == 0 ? 0 : number()},
                        {640 + 300 * number(), 400 + 300 * number()}});
    if (i % 5 == 0) w.lens = fisheye_lens();
    const PoseOptions options{.reject_outliers = false};
    const Answer answer = with_camera(w, options);
    answers += is_answer(answer.status);
    expect_sound(answer, w);
    w.lens = centred_pinhole(900);
    expect_sound(with_focal(w, {options, i % 3 == 0 ? 900.0 : 0.0}), w);
  }
  EXPECT_GT(answers, 0);
  EXPECT_LT(answers, kTrials / 2);
}

// The same view of the same target in another unit or another place.
void expect_invariant(const World& w, double unit, const Vector3d& offset, bool with_f) {
  World other = w;
  for (std::size_t k = 0; k < w.points.size(); ++k)
    other.seen[k].point = other.points[k] = unit * w.points[k] + offset;
  const PoseOptions options{.sigma_px = 0.3};
  const Answer a = with_f ? with_focal(w, {options, 0}) : with_camera(w, options);
  const Answer b = with_f ? with_focal(other, {options, 0}) : with_camera(other, options);
  ASSERT_TRUE(is_answer(a.status));
  ASSERT_EQ(a.status, b.status);
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : w.points) centre += p / static_cast<double>(w.points.size());
  for (std::size_t h = 0; h < a.hypotheses.size(); ++h) {
    const Pose &first = a.hypotheses[h].camera_from_target,
               &second = b.hypotheses[h].camera_from_target;
    EXPECT_LT(angle_between_rad(first, second), 1e-9) << unit;
    const Vector3d here = first * centre;
    const Vector3d there = second * (unit * centre + offset) / unit;
    EXPECT_LT((here - there).norm() / here.norm(), 1e-9) << unit << " " << offset.transpose();
    EXPECT_NEAR(b.hypotheses[h].probability, a.hypotheses[h].probability, 1e-6);
    EXPECT_NEAR(b.hypotheses[h].rms_px, a.hypotheses[h].rms_px, 1e-9);
    const Matrix6 &c = a.hypotheses[h].covariance, &d = b.hypotheses[h].covariance;
    EXPECT_NEAR(d(0, 0) / c(0, 0), 1, 1e-6);
    if (offset.isZero(0)) {
      EXPECT_NEAR(d(5, 5) / c(5, 5) / unit / unit, 1, 1e-6);
    }
  }
  EXPECT_NEAR(b.focal_px, a.focal_px, 1e-9 * a.focal_px);
}

TEST(PoseBadInput, ScaleAndPlaceOfTheWorldDoNotMatter) {
  Random random(17);
  for (int i = 0; i < kTrials / 8; ++i) {
    World w = draw_world(random);
    // On a grid of 2^-30, so that 2^18 + x is exact.
    for (Vector3d& p : w.points) p = (p * 0x1p30).array().round() * 0x1p-30;
    w.observe(0.3, random);
    const bool with_f = i % 2 == 0;
    expect_invariant(w, std::pow(10.0, random.uniform(-9, 9)), Vector3d::Zero(), with_f);
    const Vector3d side(static_cast<double>(random.index(3)) - 1,
                        static_cast<double>(random.index(3)) - 1,
                        static_cast<double>(random.index(3)) - 1);
    expect_invariant(w, 1, 0x1p18 * side, with_f);  // 2^20 times the 0.25 m from its centre
  }
}

}  // namespace
}  // namespace tagcal
