#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFocal = 900;
const ImageSize kPictureSize{1280, 800};

// A target and its view: planes are tilted by 28 to 52 degrees, points in space turned at random.
struct Setting {
  const char* name;
  int count;         // of points drawn anew each time; 0: those below
  double thickness;  // of half the width
  std::vector<Vector3d> fixed = {};

  std::vector<Vector3d> points(Random& random) const {
    return count == 0 ? fixed : points_in_box(count, 0.3, thickness, random);
  }
  Pose pose(Random& random) const {
    if (thickness < 1)
      return looking_at_board(Vector3d::Zero(), random.uniform(0.5, 0.9), 1.2, random);
    return {random_rotation(random), {random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1), 1.2}};
  }
};

const std::vector<Setting> kSettings = {{"board", 0, 0, board_points()},
                                        {"square", 0, 0, tag_points(0.66)},
                                        {"plane 5", 5, 0},
                                        {"space 4", 4, 1},
                                        {"space 5", 5, 1},
                                        {"space 6", 6, 1},
                                        {"space 30", 30, 1},
                                        {"thickness 1e-6, 6", 6, 1e-6},
                                        {"thickness 0.001, 6", 6, 0.001},
                                        {"thickness 0.04, 4", 4, 0.04},
                                        {"thickness 0.04, 12", 12, 0.04},
                                        {"thickness 0.1, 4", 4, 0.1},
                                        {"thickness 0.1, 8", 8, 0.1}};

double log_focal_error(const PoseAndFocalEstimate& e) { return std::log(e.focal_px / kFocal); }

double normalised_squared_error(const PoseAndFocalEstimate& e, const Pose& truth) {
  Eigen::Matrix<double, 7, 1> error;
  error << minus(e.camera_from_target(), truth), log_focal_error(e);
  return error.dot(Eigen::MatrixXd(e.covariance).ldlt().solve(error));
}

// Smallest angle between a hypothesis and the truth.
double least_angle(const std::vector<PoseHypothesis>& hypotheses, const Pose& truth) {
  double least = 10;
  for (const PoseHypothesis& h : hypotheses)
    least = std::min(least, angle_between_rad(h.camera_from_target, truth));
  return least;
}

double error_of(const PoseAndFocalEstimate& e, const Pose& truth) {
  return angle_between_rad(e.camera_from_target(), truth) + std::abs(log_focal_error(e)) +
         distance_between_m(e.camera_from_target(), truth);
}

TEST(PoseAndFocal, IsExactWithoutNoise) {
  for (const Setting& s : kSettings) {
    Random random(1);
    int answered = 0;
    for (int i = 0; i < 300; ++i) {
      const auto points = s.points(random);
      const Pose pose = s.pose(random);
      const auto e =
          estimate_pose_and_focal(seen_by(centred_pinhole(kFocal), points, pose, 0, random),
                                  kPictureSize, {{.sigma_px = 1e-3}, 0, true});
      if (!is_answer(e.status)) continue;
      ++answered;
      EXPECT_LT(error_of(e, pose), 1e-7) << s.name << " " << i;
      EXPECT_TRUE(e.outliers.empty());
    }
    EXPECT_EQ(answered, 300) << s.name;
  }
}

TEST(PoseAndFocal, FindsAnyFocalLengthWithoutAPrior) {
  Random random(2);
  for (const double focal : {200.0, 500.0, 2000.0, 6000.0}) {
    for (const Setting& s : kSettings) {
      if (s.thickness > 0 && s.thickness < 1) continue;
      Pose pose = s.pose(random);
      // The target is as large in the image as with the usual focal length.
      const Vector3d t = pose.translation();
      pose = Pose(pose.rotation(), Vector3d(t.x(), t.y(), std::max(0.6, focal / kFocal * t.z())));
      const auto e = estimate_pose_and_focal(
          seen_by(centred_pinhole(focal), s.points(random), pose, 0, random), kPictureSize,
          {{.sigma_px = 1e-3}, 0, true});
      ASSERT_TRUE(is_answer(e.status)) << s.name << " " << focal;
      EXPECT_NEAR(e.focal_px / focal, 1, 1e-6) << s.name << " " << focal;
    }
  }
}

// For regular problems: standard deviations of the focal length below 3 %.
TEST(PoseAndFocal, CovarianceIsThatOfTheErrors) {
  for (const Setting& s : kSettings) {
    if (s.count == 4 || (s.thickness > 0 && s.thickness < 0.04)) continue;
    for (const double sigma : {0.1, 0.5, 1.0}) {
      Random random(3);
      double sum = 0, sum_f = 0;
      int count = 0, excluded = 0, lost = 0;
      for (int i = 0; i < 400; ++i) {
        const auto points = s.points(random);
        const Pose pose = s.pose(random);
        const auto e =
            estimate_pose_and_focal(seen_by(centred_pinhole(kFocal), points, pose, sigma, random),
                                    kPictureSize, {{.sigma_px = sigma}, 0, true});
        lost += e.status == Status::no_consensus || e.status == Status::not_converged;
        if (!is_answer(e.status) || e.sigma_focal_px > 0.03 * e.focal_px) continue;
        const double square = normalised_squared_error(e, pose);
        excluded += square > 60;
        sum += square;
        sum_f += std::pow(log_focal_error(e) * e.focal_px / e.sigma_focal_px, 2);
        ++count;
      }
      EXPECT_EQ(lost, 0) << s.name << " " << sigma;
      EXPECT_LE(excluded, 1) << s.name << " " << sigma;
      if (count < 100) continue;
      EXPECT_NEAR(sum / (7 * count), 1, 5 * std::sqrt(2.0 / (7 * count))) << s.name << " " << sigma;
      EXPECT_NEAR(sum_f / count, 1, 5 * std::sqrt(2.0 / count)) << s.name << " " << sigma;
    }
  }
}

// Reprojection of a weak-perspective pose by its definition.
double weak_rms_px(const WeakPerspectivePose& weak, const std::vector<Correspondence>& seen) {
  double sum = 0;
  for (const Correspondence& c : seen)
    sum += (weak.scale_px_per_m * (weak.camera_from_target * c.point).head<2>() +
            image_centre(kPictureSize) - c.pixel)
               .squaredNorm();
  return std::sqrt(sum / static_cast<double>(seen.size()));
}

TEST(PoseAndFocal, FrontalAndFarViewsDoNotShowIt) {
  Random random(4);
  struct View {
    std::vector<Vector3d> points;
    double tilt, distance;
  };
  for (const View& view : {View{board_points(), 0, 1.2}, View{tag_points(0.088), 0, 1},
                           View{tag_points(0.088), 0.6, 3}, View{board_points(), 0.01, 1.2},
                           View{points_in_box(12, 0.5, 1, random), 0.5, 40}}) {
    for (int i = 0; i < 50; ++i) {
      const Pose pose = looking_at_board(Vector3d::Zero(), view.tilt, view.distance, random);
      const auto seen = seen_by(centred_pinhole(kFocal), view.points, pose, 0.5, random);
      const auto e = estimate_pose_and_focal(seen, kPictureSize, {{.sigma_px = 0.5}, 0, true});
      ASSERT_EQ(e.status, Status::focal_not_observable) << view.tilt << " " << view.distance;
      EXPECT_TRUE(e.hypotheses.empty());
      EXPECT_EQ(e.focal_px, 0);
      EXPECT_EQ(e.sigma_focal_px, 0);
      EXPECT_FALSE(e.findings.empty());
      ASSERT_FALSE(e.weak_perspective.empty());
      EXPECT_NEAR(weak_rms_px(e.weak_perspective[0], seen), e.weak_perspective[0].rms_px, 1e-9);
      EXPECT_LT(e.weak_perspective[0].rms_px, 2);
      EXPECT_NEAR(e.weak_perspective[0].scale_px_per_m * view.distance / kFocal, 1, 0.1);
    }
  }
}

TEST(PoseAndFocal, ThePriorGivesThePosesThatAnEstimateForItGives) {
  Random random(5);
  int ambiguous = 0;
  for (int i = 0; i < 100; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 2, random);
    const auto seen = seen_by(centred_pinhole(kFocal), tag_points(0.088), pose, 0.5, random);
    const PoseOptions options{.sigma_px = 0.5};
    const auto e = estimate_pose_and_focal(seen, kPictureSize, {options, kFocal, true});
    const auto known = estimate_pose(seen, {centred_pinhole(kFocal), kPictureSize}, options);
    ASSERT_EQ(e.status, Status::focal_not_observable);
    ASSERT_EQ(e.hypotheses.size(), known.hypotheses.size());
    ambiguous += e.hypotheses.size() == 2;
    for (std::size_t h = 0; h < e.hypotheses.size(); ++h) {
      EXPECT_EQ(distance_between_m(e.hypotheses[h].camera_from_target,
                                   known.hypotheses[h].camera_from_target),
                0);
      EXPECT_EQ(e.hypotheses[h].probability, known.hypotheses[h].probability);
    }
    EXPECT_EQ(e.focal_px, 0);
    EXPECT_TRUE(e.covariance.isZero(0));
  }
  EXPECT_GT(ambiguous, 50);
}

// A prior has an effect only on views that do not determine the focal length.
TEST(PoseAndFocal, APriorDoesNotMoveWhatIsSeen) {
  Random random(6);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = kSettings[0].pose(random);
    const auto seen = seen_by(centred_pinhole(kFocal), board_points(), pose, 0.3, random);
    const auto without = estimate_pose_and_focal(seen, kPictureSize, {{.sigma_px = 0.3}, 0, true});
    const auto with = estimate_pose_and_focal(seen, kPictureSize, {{.sigma_px = 0.3}, 300, true});
    ASSERT_EQ(with.status, Status::ok);
    EXPECT_NEAR(with.focal_px, without.focal_px, 1e-3);
  }
}

TEST(PoseAndFocal, OutliersAreListed) {
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    const Setting& s = kSettings[i % 2 == 0 ? 0 : 6];
    const Pose pose = s.pose(random);
    auto seen = seen_by(centred_pinhole(kFocal), s.points(random), pose, 0.3, random);
    std::vector<std::size_t> wrong;
    for (std::size_t k = 0; k < seen.size(); k += 1 + random.index(8)) {
      seen[k].pixel += Vector2d(random.uniform(30, 200), random.uniform(-200, 200));
      wrong.push_back(k);
    }
    const auto e = estimate_pose_and_focal(seen, kPictureSize, {{.sigma_px = 0.3}, 0, true});
    ASSERT_EQ(e.status, Status::ok) << i;
    EXPECT_EQ(e.outliers, wrong) << i;
    EXPECT_LT(normalised_squared_error(e, pose), 60) << i;
  }
}

TEST(PoseAndFocal, RandomDataHaveNoConsensus) {
  Random random(8);
  std::vector<Correspondence> noise;
  for (const Vector3d& p : board_points())
    noise.push_back({p, {random.uniform(0, 1280), random.uniform(0, 800)}});
  noise.resize(40);
  const auto e = estimate_pose_and_focal(noise, kPictureSize, {{.sigma_px = 0.5}, 900, true});
  EXPECT_EQ(e.status, Status::no_consensus);
  EXPECT_TRUE(e.hypotheses.empty());
  EXPECT_EQ(e.focal_px, 0);
}

// Equal covariances are equivalent to sigma_px.
TEST(PoseAndFocal, CovariancesThatAreAllOneAreSigma) {
  Random random(9);
  int answers = 0, refused = 0;
  for (int i = 0; i < 200; ++i) {
    const double sigma = std::pow(10.0, random.uniform(-2, 1));
    const Setting& s = kSettings[random.index(7)];
    const Pose near = s.pose(random);
    const Pose pose(near.rotation(), random.uniform(1, 10) * near.translation());
    const auto seen = seen_by(centred_pinhole(kFocal), s.points(random), pose, sigma, random);
    const std::vector<Matrix2> covariances(seen.size(), sigma * sigma * Matrix2::Identity());
    const auto a = estimate_pose_and_focal(seen, kPictureSize, {{.sigma_px = sigma}, 900, true});
    const auto b =
        estimate_pose_and_focal(seen, kPictureSize, {{.covariance_px2 = covariances}, 900, true});
    ASSERT_EQ(a.status, b.status) << s.name << " " << sigma;
    (is_answer(a.status) ? answers : refused) += 1;
    if (!is_answer(a.status)) continue;
    EXPECT_NEAR(a.focal_px / b.focal_px, 1, 1e-4) << s.name << " " << sigma;
    EXPECT_NEAR(a.sigma_focal_px / b.sigma_focal_px, 1, 1e-3) << s.name << " " << sigma;
    EXPECT_NEAR(a.hypotheses[0].rms_px / b.hypotheses[0].rms_px, 1, 1e-3) << s.name << " " << sigma;
  }
  EXPECT_GT(answers, 50);
  EXPECT_GT(refused, 20);
}

TEST(PoseAndFocal, EachCornerCountsByItsCovariance) {
  double sum = 0;
  constexpr int kTrials = 300;
  Random random(10);
  for (int i = 0; i < kTrials; ++i) {
    const Pose pose = kSettings[0].pose(random);
    auto seen = seen_by(centred_pinhole(kFocal), board_points(), pose, 0, random);
    std::vector<Matrix2> covariances;
    for (Correspondence& c : seen) {
      Eigen::Matrix2d root;
      root << random.uniform(0.05, 1), random.uniform(-0.5, 0.5), 0, random.uniform(0.05, 1);
      covariances.push_back(root * root.transpose());
      c.pixel += root * Vector2d(random.normal(), random.normal());
    }
    const auto e =
        estimate_pose_and_focal(seen, kPictureSize, {{.covariance_px2 = covariances}, 0, true});
    ASSERT_EQ(e.status, Status::ok);
    sum += normalised_squared_error(e, pose);
  }
  EXPECT_NEAR(sum / (7 * kTrials), 1, 5 * std::sqrt(2.0 / (7 * kTrials)));
}

// Only the centre of the image matters, not its size.
TEST(PoseAndFocal, TheCentreOfTheImageIsThePrincipalPoint) {
  Random random(11);
  const ImageSize other{1000, 2000};
  for (int i = 0; i < 20; ++i) {
    const Pose pose = kSettings[1].pose(random);
    const auto seen = seen_by(centred_pinhole(kFocal, other), tag_points(0.5), pose, 0, random);
    const auto e = estimate_pose_and_focal(seen, other, {{.sigma_px = 0.01}, 0, true});
    ASSERT_EQ(e.status, Status::ok);
    EXPECT_LT(error_of(e, pose), 1e-7);
    const auto off = estimate_pose_and_focal(seen, kPictureSize, {{.sigma_px = 0.01}, 0, true});
    if (is_answer(off.status)) {
      EXPECT_GT(error_of(off, pose), 0.01);
    }
  }
}

// Points in space under a long lens sometimes have two poses; then both are given.
TEST(PoseAndFocal, AmbiguousViewsHoldTheTruth) {
  Random random(12);
  int ambiguous = 0, missed = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto points = points_in_box(4, 0.3, 0.3, random);
    const Pose pose = kSettings[0].pose(random);
    const auto e =
        estimate_pose_and_focal(seen_by(centred_pinhole(kFocal), points, pose, 0.5, random),
                                kPictureSize, {{.sigma_px = 0.5}, 0, true});
    if (e.status != Status::ambiguous) continue;
    ++ambiguous;
    ASSERT_GE(e.hypotheses.size(), 2u);
    double sum = 0;
    for (const PoseHypothesis& h : e.hypotheses) {
      sum += h.probability;
      EXPECT_GT(h.focal_px, 0);
      EXPECT_LE(h.probability, e.hypotheses[0].probability);
    }
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_EQ(e.hypotheses[0].focal_px, e.focal_px);
    missed += least_angle(e.hypotheses, pose) > 0.3;
  }
  EXPECT_GT(ambiguous, 20);
  EXPECT_LE(missed, ambiguous / 20);
}

}  // namespace
}  // namespace tagcal
