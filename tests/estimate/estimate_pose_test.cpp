#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/geometry/pose.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Camera kCamera{opencv5_lens(), {1280, 800}};

std::vector<Correspondence> seen(const std::vector<Vector3d>& points, const Pose& pose,
                                 double sigma_px, Random& random) {
  return seen_by(kCamera.lens, points, pose, sigma_px, random);
}

TEST(EstimatePose, IsExactWithoutNoise) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.2, 1.0), 0.6, random);
    const PoseEstimate e = estimate_pose(seen(tag_points(0.1), pose, 0, random), kCamera);
    ASSERT_TRUE(is_answer(e.status)) << i;
    EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-7) << i;
    EXPECT_LT(distance_between_m(e.camera_from_target(), pose), 1e-7) << i;
  }
}

TEST(EstimatePose, IsExactWhereOthersFail) {
  Random random(2);
  // Exactly frontal, turned by 180 degrees, tiny and huge targets, far from the origin.
  for (const double unit : {1e-6, 1.0, 1e6}) {
    for (const double tilt : {0.0, 1e-9, 0.5}) {
      const Pose pose = looking_at_board(Vector3d::Zero(), tilt, 0.6 * unit, random);
      const PoseEstimate e = estimate_pose(seen(tag_points(0.1 * unit), pose, 0, random), kCamera);
      ASSERT_TRUE(is_answer(e.status)) << unit << " " << tilt;
      EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-4) << unit << " " << tilt;
      EXPECT_LT(distance_between_m(e.camera_from_target(), pose), 1e-6 * unit);
    }
  }
}

double mean_normalised_square(const std::vector<Vector3d>& points, double sigma_px,
                              const PoseOptions& options, Random& random) {
  double sum = 0;
  constexpr int kTrials = 400;
  for (int i = 0; i < kTrials; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.5, 0.8), 1.0, random);
    const PoseEstimate e = estimate_pose(seen(points, pose, sigma_px, random), kCamera, options);
    EXPECT_TRUE(is_answer(e.status)) << status_name(e.status);
    if (is_answer(e.status)) sum += normalised_squared_error(e.hypotheses.front(), pose);
  }
  return sum / (6 * kTrials);  // 1, with a standard deviation of 0.029
}

TEST(EstimatePose, CovarianceIsThatOfTheErrors) {
  Random random(3);
  const std::vector<Vector3d> space = points_in_box(12, 0.2, 1, random);
  for (const auto& points : {tag_points(0.2), board_points(), space})
    for (const double sigma : {0.1, 0.5})
      EXPECT_NEAR(mean_normalised_square(points, sigma, {.sigma_px = sigma}, random), 1, 0.12);
}

TEST(EstimatePose, ManyResidualsShowTheNoise) {
  Random random(31);
  EXPECT_NEAR(mean_normalised_square(board_points(), 0.7, {}, random), 1, 0.12);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1, random);
  const PoseEstimate e = estimate_pose(seen(board_points(), pose, 0.7, random), kCamera);
  EXPECT_NEAR(e.sigma_px, 0.7, 0.12);  // 4 standard deviations
  EXPECT_TRUE(e.findings.empty());
}

TEST(EstimatePose, FewResidualsDoNot) {
  Random random(32);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1, random);
  const PoseEstimate e = estimate_pose(seen(tag_points(0.2), pose, 0.1, random), kCamera);
  ASSERT_TRUE(is_answer(e.status));
  EXPECT_EQ(e.sigma_px, 0.5);
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_NE(e.findings[0].sentence.find("0.5 px is assumed"), std::string::npos);
}

// The stated noise is a third of the true one: the residuals raise it.
TEST(EstimatePose, LargerResidualsRaiseTheNoiseThatIsStated) {
  Random random(33);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1, random);
  const PoseEstimate e =
      estimate_pose(seen(board_points(), pose, 0.9, random), kCamera, {.sigma_px = 0.3});
  ASSERT_EQ(e.status, Status::ok);
  EXPECT_NEAR(e.sigma_px, 0.9, 0.15);
  EXPECT_TRUE(e.outliers.empty());
  ASSERT_EQ(e.findings.size(), 1u);
  EXPECT_EQ(e.findings[0].code, "noise_understated");
  EXPECT_NE(e.findings[0].sentence.find("times as large as the stated noise"), std::string::npos)
      << e.findings[0].sentence;
  EXPECT_NEAR(mean_normalised_square(board_points(), 0.9, {.sigma_px = 0.3}, random), 1, 0.12);
}

TEST(EstimatePose, EachCornerCountsByItsCovariance) {
  Random random(34);
  double sum = 0, rms = 0;
  int num_raised = 0;
  constexpr int kTrials = 400;
  for (int i = 0; i < kTrials; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.5, 0.8), 1.0, random);
    const auto points = i % 2 == 0 ? tag_points(0.3) : board_points();
    auto corners = seen(points, pose, 0, random);
    std::vector<Matrix2> covariances;
    double noise = 0;
    for (Correspondence& c : corners) {
      Eigen::Matrix2d root;
      root << random.uniform(0.05, 1), random.uniform(-0.5, 0.5), 0, random.uniform(0.05, 1);
      covariances.push_back(root * root.transpose());
      const Vector2d error = root * Vector2d(random.normal(), random.normal());
      noise += error.squaredNorm() / static_cast<double>(corners.size());
      c.pixel += error;
    }
    const PoseEstimate e = estimate_pose(corners, kCamera, {.covariance_px2 = covariances});
    ASSERT_TRUE(is_answer(e.status));
    num_raised += e.sigma_px != 1;  // of whitened residuals
    sum += normalised_squared_error(e.hypotheses.front(), pose);
    if (i % 2 == 1) rms += e.hypotheses.front().rms_px / std::sqrt(noise) / (kTrials / 2);
  }
  EXPECT_NEAR(sum / (6 * kTrials), 1, 0.12);
  EXPECT_NEAR(rms, 1, 0.05);  // in pixels, not whitened
  EXPECT_LE(num_raised, 1);   // p = 0.0001 for each view
}

TEST(EstimatePose, CovariancesThatAreAllOneAreSigma) {
  Random random(35);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, random.uniform(0.5, 3), random);
    const auto corners = seen(tag_points(0.1), pose, 0.2, random);
    const std::vector<Matrix2> covariances(4, 0.04 * Matrix2::Identity());
    const PoseEstimate a = estimate_pose(corners, kCamera, {.sigma_px = 0.2});
    const PoseEstimate b = estimate_pose(corners, kCamera, {.covariance_px2 = covariances});
    ASSERT_EQ(a.status, b.status);
    ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
    for (std::size_t h = 0; h < a.hypotheses.size(); ++h) {
      const PoseHypothesis &x = a.hypotheses[h], &y = b.hypotheses[h];
      EXPECT_LT(angle_between_rad(x.camera_from_target, y.camera_from_target), 1e-5);
      EXPECT_NEAR(x.rms_px, y.rms_px, 1e-5);
      EXPECT_NEAR(x.probability, y.probability, 1e-3);
      EXPECT_LT((x.covariance - y.covariance).norm(), 1e-3 * x.covariance.norm());
    }
  }
}

TEST(EstimatePose, AFarTagIsAmbiguousAndTheTruthIsAmongTheTwo) {
  Random random(4);
  int ambiguous = 0, missed = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.5, 2.5, random);
    const PoseEstimate e =
        estimate_pose(seen(tag_points(0.088), pose, 0.5, random), kCamera, {0.5, 50});
    ASSERT_TRUE(is_answer(e.status));
    ambiguous += e.status == Status::ambiguous;
    double nearest = 10, sum = 0;
    for (const PoseHypothesis& h : e.hypotheses) {
      nearest = std::min(nearest, angle_between_rad(h.camera_from_target, pose));
      sum += h.probability;
    }
    missed += nearest > 0.4;
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  EXPECT_GT(ambiguous, 120);
  EXPECT_LE(missed, 2);
}

TEST(EstimatePose, PointsInSpace) {
  Random random(5);
  std::vector<Vector3d> points;
  for (int i = 0; i < 20; ++i)
    points.emplace_back(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                        random.uniform(-0.2, 0.2));
  for (int i = 0; i < 100; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0, 3.1), 1.5, random);
    const PoseEstimate e = estimate_pose(seen(points, pose, 0, random), kCamera);
    ASSERT_EQ(e.status, Status::ok);
    EXPECT_LT(angle_between_rad(e.camera_from_target(), pose), 1e-7);
  }
}

TEST(EstimatePose, NamesWhatCannotBeSolved) {
  Random random(6);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.4, 1, random);
  const std::vector<Vector3d> line = {
      {0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.05, 0, 0}, {0.15, 0, 0}};
  EXPECT_EQ(estimate_pose(seen(line, pose, 0.1, random), kCamera).status, Status::degenerate);
  auto three = seen(tag_points(0.1), pose, 0, random);
  three.pop_back();
  EXPECT_EQ(estimate_pose(three, kCamera).status, Status::degenerate);
  EXPECT_EQ(estimate_pose(std::vector<Correspondence>(), kCamera).status, Status::degenerate);
  auto nan = seen(tag_points(0.1), pose, 0, random);
  nan[2].pixel.x() = std::nan("");
  EXPECT_EQ(estimate_pose(nan, kCamera).status, Status::degenerate);
  const std::vector<Vector3d> same(5, Vector3d(0.1, 0.2, 0));
  EXPECT_EQ(estimate_pose(seen(same, pose, 0.1, random), kCamera).status, Status::degenerate);
}

TEST(EstimatePose, ALoneTagIsBelievedOrNot) {
  Random random(40);
  int believed = 0, wrong = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0, 0.9), 1, random);
    const auto corners = seen(tag_points(0.2), pose, 0.3, random);
    auto swapped = corners;
    std::swap(swapped[0].pixel, swapped[1].pixel);
    for (const double sigma : {0.0, 0.3})
      EXPECT_FALSE(is_answer(estimate_pose(swapped, kCamera, {.sigma_px = sigma}).status));
    auto noise = corners;
    for (Correspondence& c : noise) c.pixel = {random.uniform(0, 1280), random.uniform(0, 800)};
    EXPECT_FALSE(is_answer(estimate_pose(noise, kCamera, {.sigma_px = 0.3}).status));
    auto moved = corners;
    moved[2].pixel += Vector2d(10, 10);
    const PoseEstimate e = estimate_pose(moved, kCamera, {.sigma_px = 0.3});
    if (is_answer(e.status)) {  // four corners can hide the error
      ++believed;
      wrong += normalised_squared_error(e.hypotheses.front(), pose) > 40;
    }
  }
  EXPECT_LT(believed, 50);
  EXPECT_LE(wrong, 25);
}

TEST(EstimatePose, AFisheyeSeesBesideAndBehindItself) {
  Random random(41);
  const Camera camera{Fisheye({300, 300, 640, 480, 0.01, 0, 0, 0}), {1280, 960}};
  for (int i = 0; i < 200; ++i) {
    // The centre is 60 to 130 degrees from the axis.
    const double angle = random.uniform(1.05, 2.27), turn = random.uniform(0, 6.28);
    const Vector3d centre = 0.5 * Vector3d(std::sin(angle) * std::cos(turn),
                                           std::sin(angle) * std::sin(turn), std::cos(angle));
    const Pose facing(rotation_between(Vector3d::UnitZ(), -centre), centre);
    const Pose pose = facing * Pose(exp_rotation({random.uniform(0.4, 0.8), 0, 0}), {0, 0, 0}) *
                      Pose(exp_rotation({0, 0, random.uniform(-3, 3)}), {0, 0, 0});
    for (const auto& points :
         {tag_points(0.2), points_in_box(30, 0.3, 0, random), points_in_box(8, 0.2, 1, random)}) {
      const PoseEstimate exact =
          estimate_pose(seen_by(camera.lens, points, pose, 0, random), camera);
      ASSERT_TRUE(is_answer(exact.status)) << i << " " << points.size();
      EXPECT_LT(angle_between_rad(exact.camera_from_target(), pose), 1e-6) << i;
      const PoseEstimate e =
          estimate_pose(seen_by(camera.lens, points, pose, 0.2, random), camera, {.sigma_px = 0.2});
      ASSERT_TRUE(is_answer(e.status)) << i << " " << points.size();
      if (e.status == Status::ok) {
        EXPECT_LT(normalised_squared_error(e.hypotheses.front(), pose), 60) << i;
      }
    }
  }
}

// Points near a line are refused if the noise hides a turn about it to either side: a view and its
// mirror image have the same answer.
TEST(EstimatePose, PointsNearALineAreJudgedAlikeInAMirror) {
  const Camera camera{pinhole(600, 600, 319.5, 239.5), {640, 480}};
  Random random(31);
  int refused = 0, answered = 0;
  for (int i = 0; i < 600; ++i) {
    const double width = random.uniform(0.002, 0.02);
    const Pose pose(exp_rotation({random.uniform(-0.8, 0.8), random.uniform(-0.5, 0.5), 0}),
                    {0, 0, 1});
    std::vector<Correspondence> seen, mirrored;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d x(-0.2 + 0.4 * k / 7, k % 2 == 0 ? width : -width, 0);
      const Eigen::Vector2d pixel = project(camera.lens, pose * x).value() +
                                    0.3 * Eigen::Vector2d(random.normal(), random.normal());
      seen.push_back({x, pixel});
      mirrored.push_back({{x.x(), -x.y(), 0}, {pixel.x(), 2 * 239.5 - pixel.y()}});
    }
    const Status status = estimate_pose(seen, camera, {0.3}).status;
    EXPECT_EQ(status, estimate_pose(mirrored, camera, {0.3}).status) << i;
    (is_answer(status) ? answered : refused) += 1;
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(answered, 50);
}

// Points in the room, with left-handed coordinates in the file.
TEST(EstimatePose, PointsThatFitInTheirMirrorImageOnlyAreSaid) {
  Random random(4);
  std::vector<Vector3d> points;
  for (int id = 0; id < 40; ++id)
    points.emplace_back(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3),
                        random.uniform(-0.2, 0.2));
  const auto is_said = [](const auto& estimate) {
    return estimate.status == Status::no_consensus &&
           std::ranges::any_of(estimate.findings, [](const Finding& finding) {
             return finding.sentence.find("only in their mirror image") != std::string::npos;
           });
  };
  for (int i = 0; i < 20; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0, 0.8), 1.2, random);
    ViewCorrespondences view;
    view.correspondences = seen(points, pose, 0.2, random);
    for (int id = 0; id < static_cast<int>(view.correspondences.size()); ++id)
      view.ids.push_back({id, 0});
    view.groups.resize(view.ids.size());
    std::iota(view.groups.begin(), view.groups.end(), 0);
    EXPECT_EQ(estimate_pose(view, kCamera).status, Status::ok);
    for (Correspondence& c : view.correspondences) c.point.z() *= -1;
    EXPECT_TRUE(is_said(estimate_pose(view, kCamera))) << i;
    EXPECT_TRUE(is_said(estimate_pose_and_focal(view, kCamera.image_size))) << i;
    for (Correspondence& c : view.correspondences)
      c.point = Vector3d(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 0);
    EXPECT_FALSE(is_said(estimate_pose(view, kCamera))) << i;
  }
}

TEST(EstimatePose, APoseWithoutAnAnswerIsAnErrorThatSaysSo) {
  const Camera camera{opencv5_lens(), {1280, 800}};
  const PoseEstimate none = estimate_pose(std::vector<Correspondence>(), camera);
  ASSERT_FALSE(is_answer(none.status));
  EXPECT_THROW((void)none.camera_from_target(), Error);
  EXPECT_THROW((void)PoseAndFocalEstimate().camera_from_target(), Error);
}

}  // namespace
}  // namespace tagcal
