#include "tagcal/estimate/bundle/held_lens.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/estimate/bundle/lens_prior.hpp"
#include "tagcal/estimate/pose.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using internal::LensResponse;

const ImageSize kSize{1280, 800};

Pose some_pose(Random& random) {
  return looking_at_board(Eigen::Vector3d::Zero(), random.uniform(0.4, 0.9), 1.1, random);
}

ViewCorrespondences named(const std::vector<Correspondence>& seen) {
  ViewCorrespondences view;
  view.correspondences = seen;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    view.ids.push_back({static_cast<int>(i), 0});
    view.groups.push_back(static_cast<int>(i));
  }
  return view;
}

// Standard deviations of fx, fy, cx, cy, k1, k2, p1, p2 of model opencv4.
UncertainCamera uncertain() {
  UncertainCamera camera{&Model::named("opencv4"), {opencv5_lens(), kSize}, {}};
  const Eigen::VectorXd sigma = Eigen::Map<const Eigen::Matrix<double, 8, 1>>(
      std::array{3., 3., 4., 4., 0.01, 0.02, 5e-4, 5e-4}.data());
  camera.covariance = sigma.cwiseAbs2().asDiagonal();
  return camera;
}

Lens drawn(const UncertainCamera& camera, Random& random) {
  std::vector<double> values = camera.model->free_values(camera.camera.lens);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    values[i] += std::sqrt(camera.covariance(at, at)) * random.normal();
  }
  return camera.model->lens(values, kSize).value();
}

// By central differences of poses of least squares, for exact corners of the held lens.
TEST(HeldLens, ResponseIsTheDerivativeOfThePose) {
  Random random(1);
  const UncertainCamera camera = uncertain();
  const Pose pose = some_pose(random);
  const auto seen = seen_by(camera.camera.lens, board_points(), pose, 0, random);
  const auto response =
      internal::lens_response(internal::inlier_view(seen, {}, {}, 1), camera, pose, false);
  ASSERT_TRUE(response);
  const std::vector<double> values = camera.model->free_values(camera.camera.lens);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double step = 1e-3 * std::sqrt(camera.covariance(column, column));
    std::vector<Pose> found;
    for (const double sign : {1., -1.}) {
      std::vector<double> moved = values;
      moved[i] += sign * step;
      found.push_back(
          estimate_pose(seen, {camera.model->lens(moved, kSize).value(), kSize}, {.sigma_px = 1})
              .camera_from_target());
    }
    const Vector6d difference = minus(found[0], found[1]) / (2 * step);
    EXPECT_LT((difference - response->by_lens.col(column)).norm(),
              1e-4 * response->by_lens.col(column).norm())
        << i;
  }
}

// The same with the focal length free, of pinholes that are not centred or have distortion.
TEST(HeldLens, ResponseIsTheDerivativeOfPoseAndFocalLength) {
  Random random(2);
  const Pose pose = some_pose(random);
  const UncertainCamera camera = internal::usual_lens(900, kSize);
  const auto exact = seen_by(camera.camera.lens, board_points(), pose, 0, random);
  const auto response =
      internal::lens_response(internal::inlier_view(exact, {}, {}, 1), camera, pose, true);
  ASSERT_TRUE(response);
  const std::vector<double> values = camera.model->free_values(camera.camera.lens);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double step = i < 4 ? 0.01 : 1e-5;
    Eigen::Matrix<double, 7, 1> difference = Eigen::Matrix<double, 7, 1>::Zero();
    for (const double sign : {1., -1.}) {
      // The corners of the moved lens: the held one is that by -step beside it.
      std::vector<double> moved = values;
      moved[i] += sign * step;
      const auto e = estimate_pose_and_focal(
          seen_by(camera.model->lens(moved, kSize).value(), board_points(), pose, 0, random), kSize,
          {{.sigma_px = 1}, 0, true});
      ASSERT_TRUE(is_answer(e.status));
      difference.head<6>() -= minus(e.camera_from_target(), pose) * sign / (2 * step);
      difference[6] -= std::log(e.focal_px / 900) * sign / (2 * step);
    }
    EXPECT_LT((difference - response->by_lens.col(column)).norm(),
              1e-3 * std::max(1e-6, response->by_lens.col(column).norm()))
        << i;
  }
}

// The mean squares of the errors over their degrees of freedom, with the claim and without.
TEST(HeldLens, PosesByAnUncertainCameraAreWithinTheirClaims) {
  const UncertainCamera camera = uncertain();
  double with = 0, without = 0;
  constexpr int kCount = 400;
  for (int i = 0; i < kCount; ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const Pose pose = some_pose(random);
    const auto seen = named(seen_by(drawn(camera, random), board_points(), pose, 0.3, random));
    const PoseEstimate by_claim = estimate_pose(seen, camera, {.sigma_px = 0.3});
    const PoseEstimate exact = estimate_pose(seen, camera.camera, {.sigma_px = 0.3});
    ASSERT_TRUE(is_answer(by_claim.status)) << i;
    EXPECT_EQ(by_claim.hypotheses[0].noise_covariance, exact.hypotheses[0].covariance);
    with += normalised_squared_error(by_claim.hypotheses[0], pose) / (6 * kCount);
    without += normalised_squared_error(exact.hypotheses[0], pose) / (6 * kCount);
  }
  EXPECT_NEAR(with, 1,
              0.15);  // 0.03 by chance; the noise is raised where the lens leaves residuals
  EXPECT_GT(without, 20);
}

// A rig of one camera and that camera are one claim, here about an origin beside the board.
TEST(HeldLens, IsThatOfARigOfOneCamera) {
  Random random(5);
  const UncertainCamera camera = uncertain();
  auto seen = named(seen_by(camera.camera.lens, board_points(), some_pose(random), 0.3, random));
  for (Correspondence& c : seen.correspondences) c.point += Eigen::Vector3d(0.4, -0.3, 0.1);
  const PoseEstimate alone = estimate_pose(seen, camera, {.sigma_px = 0.3});
  KnownRig rig{{{"cam", camera, Pose(), 0}}, MatrixX::Zero(14, 14)};
  rig.covariance.bottomRightCorner(8, 8) = camera.covariance;
  const PoseEstimate of_rig = estimate_rig_pose(std::span(&seen, 1), rig, {.sigma_px = 0.3}).rig;
  ASSERT_TRUE(is_answer(alone.status) && is_answer(of_rig.status));
  EXPECT_LT((alone.hypotheses[0].covariance - of_rig.hypotheses[0].covariance).norm(),
            1e-6 * alone.hypotheses[0].covariance.norm());
  EXPECT_LT((alone.hypotheses[0].noise_covariance - of_rig.hypotheses[0].noise_covariance).norm(),
            1e-6 * alone.hypotheses[0].noise_covariance.norm());
}

TEST(HeldLens, ACameraWithoutCovarianceIsTakenAsExactAndSaidToBe) {
  Random random(6);
  const Camera camera{opencv5_lens(), kSize};
  const auto seen = named(seen_by(camera.lens, board_points(), some_pose(random), 0.3, random));
  const PoseEstimate e = estimate_pose(seen, UncertainCamera{nullptr, camera, {}});
  ASSERT_EQ(e.status, Status::ok);
  EXPECT_EQ(e.findings.front().code, "lens_without_covariance");
  EXPECT_EQ(e.hypotheses[0].covariance, estimate_pose(seen, camera).hypotheses[0].covariance);
  UncertainCamera known = uncertain();
  known.covariance.resize(0, 0);  // exact, too
  EXPECT_EQ(estimate_pose(seen, known).findings.front().code, "lens_without_covariance");
  known.covariance = MatrixX::Identity(3, 3);
  EXPECT_THROW(estimate_pose(seen, known), Error);
}

// Lenses as the prior of a calibration has them, each before a tag or a few corners of a board,
// whose residuals do not show the lens.
TEST(HeldLens, FocalLengthsOfUsualLensesAreWithinTheirClaims) {
  const UncertainCamera usual = internal::usual_lens(900, kSize);
  const Eigen::VectorXd sigma = usual.covariance.diagonal().cwiseSqrt();
  for (const int side : {2, 4}) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < side * side; ++i)
      points.emplace_back(0.3 * (i % side) / (side - 1) - 0.15,
                          0.3 * (i / side) / (side - 1) - 0.15, 0);
    double sum = 0, sum_exact = 0;
    int answers = 0, beyond = 0, answers_exact = 0;
    for (int i = 0; i < 1000; ++i) {
      Random random(static_cast<std::uint64_t>(i));
      std::vector<double> values = usual.model->free_values(usual.camera.lens);
      for (Eigen::Index j = 2; j < sigma.size(); ++j)
        values[static_cast<std::size_t>(j)] += sigma[j] * random.normal();
      Pose pose = looking_at_board(Eigen::Vector3d::Zero(), random.uniform(0.4, 0.9), 0.6, random);
      pose = Pose(Eigen::Quaterniond::Identity(),
                  {random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1), 0}) *
             pose;
      const Lens lens = usual.model->lens(values, kSize).value();
      const auto is_seen = [&](const Eigen::Vector3d& p) {
        return project(lens, pose * p).has_value();
      };
      if (!std::ranges::all_of(points, is_seen)) continue;
      const auto seen = seen_by(lens, points, pose, 0.3, random);
      const auto by_usual = estimate_pose_and_focal(seen, kSize, {{.sigma_px = 0.3}});
      const auto exact = estimate_pose_and_focal(seen, kSize, {{.sigma_px = 0.3}, 0, true});
      if (is_answer(exact.status)) {
        sum_exact += std::pow((exact.focal_px - 900) / exact.sigma_focal_px, 2);
        ++answers_exact;
      }
      if (!is_answer(by_usual.status)) continue;
      const double z = (by_usual.focal_px - 900) / by_usual.sigma_focal_px;
      sum += z * z;
      beyond += std::abs(z) > 4;
      ++answers;
    }
    EXPECT_GT(answers, 50) << side;
    EXPECT_LT(std::sqrt(sum / answers), 1.2) << side;
    EXPECT_GT(std::sqrt(sum_exact / answers_exact), 3) << side;
  }
}

// What the view itself excludes is no part of the claim.
TEST(HeldLens, AViewTellsWhatItsLensIsNot) {
  Random random(8);
  const Pose pose = some_pose(random);
  for (const double sigma : {0.02, 0.5}) {
    const auto seen = seen_by(centred_pinhole(900), board_points(), pose, sigma, random);
    const UncertainCamera usual = internal::usual_lens(900, kSize);
    const auto response =
        internal::lens_response(internal::inlier_view(seen, {}, {}, sigma), usual, pose, true);
    ASSERT_TRUE(response);
    const Eigen::MatrixXd learned = internal::learned_covariance(*response, usual.covariance);
    const Eigen::Index k1 = 4;
    EXPECT_LT(std::sqrt(learned(k1, k1)),
              (sigma < 0.1 ? 0.05 : 0.7) * std::sqrt(usual.covariance(k1, k1)));
    EXPECT_GT(Eigen::MatrixXd(learned).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(),
              -1e-9);
  }
}

}  // namespace
}  // namespace tagcal
