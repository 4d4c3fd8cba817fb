#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "pose_bad_input_fixture.hpp"

// For any input the answer is right, or the status says why there is none.

namespace tagcal {
namespace {

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

// Three points have up to four poses.
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
    const double bad = std::array{kNan, kInfinity, -kInfinity}[random.index(3)];
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
    // The same view, with another frame of the target.
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
      // A plane seen from behind is a valid answer; points in space have none.
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
    // Near frontal the two poses nearly coincide: half of the digits are lost.
    EXPECT_LT(least_error(answer, w), 1e-5) << i;
    EXPECT_LT(rms_px(answer.hypotheses[0], answer, w), 1e-6) << i;
    const Answer focal = with_focal(w);
    expect_sound(focal, w);
    if (is_answer(focal.status)) {
      EXPECT_LT(rms_px(focal.hypotheses[0], focal, w), 1e-6) << i;
    }
  }
}

// Numbers of any kind and size must not crash.
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

// The same view of the same target in another unit or another place. Returns true for an answer.
bool expect_invariant(const World& w, double unit, const Vector3d& offset, bool with_f) {
  World other = w;
  for (std::size_t k = 0; k < w.points.size(); ++k)
    other.seen[k].point = other.points[k] = unit * w.points[k] + offset;
  const PoseOptions options{.sigma_px = 0.3};
  const Answer a = with_f ? with_focal(w, {options, 0}) : with_camera(w, options);
  const Answer b = with_f ? with_focal(other, {options, 0}) : with_camera(other, options);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.hypotheses.size(), b.hypotheses.size());
  if (!is_answer(a.status) || a.hypotheses.size() != b.hypotheses.size()) return false;
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
  return true;
}

TEST(PoseBadInput, ScaleAndPlaceOfTheWorldDoNotMatter) {
  Random random(17);
  int answers = 0;
  for (int i = 0; i < kTrials / 8; ++i) {
    World w = draw_world(random);
    // On a grid of 2^-30, so that 2^18 + x is exact.
    for (Vector3d& p : w.points) p = (p * 0x1p30).array().round() * 0x1p-30;
    w.observe(0.3, random);
    const bool with_f = i % 2 == 0;
    answers += expect_invariant(w, std::pow(10.0, random.uniform(-9, 9)), Vector3d::Zero(), with_f);
    const Vector3d side(static_cast<double>(random.index(3)) - 1,
                        static_cast<double>(random.index(3)) - 1,
                        static_cast<double>(random.index(3)) - 1);
    expect_invariant(w, 1, 0x1p18 * side, with_f);  // 2^20 times the 0.25 m from its centre
  }
  EXPECT_GT(answers, kTrials / 8 * 97 / 100);  // the others do not determine the focal length
}

}  // namespace
}  // namespace tagcal
