// The jobs of the chart: what their methods answer, against the bound.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>
#include <set>

#include "study/chart/chart.hpp"
#include "study/chart/pose_methods.hpp"
#include "study/peers/tag_peers.hpp"
#include "study/tasks/calibration_tasks.hpp"
#include "study/tasks/pose_error.hpp"
#include "study/tasks/pose_tasks.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
using namespace study;
namespace {

// Points by panel and method.
std::map<std::pair<std::string, std::string>, ChartPoint> by_name(const ChartResult& result) {
  std::map<std::pair<std::string, std::string>, ChartPoint> all;
  for (const ChartPoint& p : chart_points(result))
    all[{result.panels[static_cast<std::size_t>(p.panel)].name(),
         result.methods[static_cast<std::size_t>(p.method)].name}] = p;
  return all;
}

TEST(ChartJobs, areKnownByTheirNames) {
  for (const std::string_view name : chart_job_names()) EXPECT_TRUE(chart_job(name)) << name;
  EXPECT_FALSE(chart_job("pos"));
  EXPECT_FALSE(chart_job(""));
}

TEST(ChartJobs, focalIsTheSameForAnyThreads) {
  const ChartResult one = run_chart(ChartJob::focal, {.trials = 4});
  const ChartResult two = run_chart(ChartJob::focal, {.trials = 4, .threads = 2});
  ASSERT_EQ(one.trials.size(), two.trials.size());
  for (std::size_t i = 0; i < one.trials.size(); ++i) {
    EXPECT_EQ(one.trials[i].error, two.trials[i].error);
    EXPECT_EQ(one.trials[i].over_bound, two.trials[i].over_bound);
    EXPECT_EQ(one.trials[i].failed, two.trials[i].failed);
    EXPECT_GT(one.trials[i].time_us, 0);
  }
}

TEST(ChartJobs, focalIsAtTheBound) {
  const auto points = by_name(run_chart(ChartJob::focal, {.trials = 20}));
  const std::string panel = "noise 0.1 px, plane, tilted 20-60°, 36 points";
  const ChartPoint ours = points.at({panel, "tagcal estimate_pose_and_focal"});
  const ChartPoint theirs = points.at({panel, "OpenCV calibrateCamera"});
  EXPECT_EQ(ours.failures, 0);
  EXPECT_EQ(theirs.failures, 0);
  EXPECT_NEAR(ours.rms_over_bound, 1, 0.2);  // 140 squares: 6 % sd
  EXPECT_NEAR(theirs.rms_over_bound, ours.rms_over_bound, 0.01);
}

TEST(ChartJobs, poseHasEveryPeerWhereItCan) {
  const ChartResult result = run_chart(ChartJob::pose, {.trials = 1});
  const auto points = by_name(result);
  const std::string tag = "noise 0.1 px, plane, tilted 20-60°, 4 points";
  for (const char* name :
       {"tagcal estimate_pose", "tagcal homography + ippe", "OpenCV ITERATIVE", "OpenCV EPNP",
        "OpenCV IPPE", "OpenCV IPPE_SQUARE", "OpenCV SQPNP", "OpenCV P3P", "OpenCV AP3P",
        "OpenCV solvePnPRansac", "OpenCV USAC (MSAC, inner LO)", "AprilTag estimate_tag_pose",
        "Ceres, autodiff"})
    EXPECT_TRUE(points.contains({tag, name})) << name;
  EXPECT_EQ(result.panels.size(), 27u);
  EXPECT_FALSE(
      points.contains({"noise 0.1 px, points in space, 144 points", "OpenCV IPPE_SQUARE"}));
}

TEST(ChartJobs, projectKnowsTheExactPixel) {
  const ChartResult result = run_chart(ChartJob::project, {.trials = 3});
  EXPECT_EQ(result.panels.size(), 8u);
  for (const ChartPoint& p : chart_points(result)) {
    const std::string& name = result.methods[static_cast<std::size_t>(p.method)].name;
    EXPECT_EQ(p.failures, 0) << name;
    EXPECT_LT(p.rms, 1e-12) << name;  // a few roundings of 1000 px
    EXPECT_GE(p.rms_over_bound, 1) << name;
    EXPECT_LT(p.rms_over_bound, 4) << name;
  }
}

TEST(ChartJobs, calibrationsAgree) {
  Random random(8);
  const std::map<std::string, Lens> lenses = {
      {"opencv5", Perspective({900, 898, 651, 392, -0.15, 0.05, 5e-4, -3e-4, 0})},
      // To 70 degrees: beyond 90 OpenCV 4.10's cv::fisheye::calibrate throws or is wrong.
      {"fisheye4", Fisheye({620, 619, 633, 405, 0.02, -0.01, 0.003, -0.0005})}};
  for (const auto& [model, lens] : lenses) {
    const CalibrationTask task = draw_calibration(lens, model, 5, random);
    const Eigen::MatrixXd bound = calibration_information(task).inverse();
    // Ours has further unknowns (the shape of the board, displaced rows), which raise a variance
    // above the bound of the peers' problem, and priors, which lower that of weakly determined
    // coefficients. Its answer differs from theirs by what the difference of the variances explains
    // (Hausman, Econometrica 1978).
    const Calibration claimed =
        calibrate(task.dataset, {.model = model, .sigma_px = task.sigma_px});
    EXPECT_GT(std::sqrt(claimed.covariance(0, 0) / bound(0, 0)), 0.9) << model;
    EXPECT_LT(std::sqrt(claimed.covariance(0, 0) / bound(0, 0)), 2) << model;
    std::vector<double> ours, theirs;
    for (const CalibrationMethod& method : calibration_methods(model)) {
      const auto prepared = method.prepare(task);
      prepared.solve();
      const CalibrationAnswer answer = prepared.answer();
      ASSERT_EQ(answer.size(), static_cast<std::size_t>(bound.rows())) << method.name;
      if (ours.empty()) {
        ours = answer;
        continue;
      }
      if (theirs.empty()) theirs = answer;
      for (std::size_t i = 0; i < ours.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        const double sd = std::sqrt(bound(k, k));
        EXPECT_NEAR(answer[i], theirs[i], 0.05 * sd) << method.name << " " << i;
        const double apart = std::sqrt(std::abs(claimed.covariance(k, k) - bound(k, k)));
        EXPECT_NEAR(answer[i], ours[i], 3 * apart + 0.3 * sd) << method.name << " " << i;
      }
    }
    EXPECT_FALSE(theirs.empty());
  }
}

TEST(ChartJobs, cornersByTheFitAreNearTheBound) {
  const auto points = by_name(run_chart(ChartJob::corners, {.trials = 4, .threads = 2}));
  const std::string panel = "noise 2 grey levels, tag 40 px wide";
  const ChartPoint fit = points.at({panel, "tagcal detect, lens known"});
  const ChartPoint stock = points.at({panel, "AprilTag, refine_edges on"});
  EXPECT_EQ(fit.failures, 0);
  EXPECT_NEAR(fit.rms_over_bound, 1, 0.4);  // 32 squares, correlated
  EXPECT_GT(stock.rms_over_bound, 2);
  EXPECT_LT(stock.rms, 0.5);  // the same convention of pixels and corners
  EXPECT_LT(points.at({panel, "OpenCV cornerSubPix"}).rms, 0.5);

  const std::string pictures = "pictures of 1280x800, ";
  for (const char* board : {"36 plain tags", "36 tags of Kalibr"}) {
    const ChartPoint detected = points.at({pictures + board, "tagcal detect, PNG to corners"});
    EXPECT_EQ(detected.failures, 0) << board;
    EXPECT_LT(detected.rms, 0.02) << board;
  }
  const std::string plain = pictures + "36 plain tags";
  EXPECT_LT(points.at({plain, "AprilTag, PNG to corners"}).rms, 0.2);
  const auto aruco = points.find({plain, "OpenCV aruco, PNG to corners"});
  ASSERT_EQ(aruco != points.end(), has_aruco());
  if (has_aruco()) {
    EXPECT_LT(aruco->second.rms, 1);
  }
  // The picture has the noise that it should, where it should.
  const ChartPoint rendered =
      points.at({pictures + "rendering of 36 tags of Kalibr", "tagcal render, PNG included"});
  EXPECT_EQ(rendered.failures, 0);
  EXPECT_NEAR(rendered.rms_over_bound, 1, 0.1);  // 1152 squares: 2 % sd
}

// Each method of a job, without noise, is right: frames and conventions fit.
TEST(ChartJobs, methodsFindThePoseOfCleanCorners) {
  Random random(5);
  ViewRange range;
  range.sigma_px = 0;
  range.min_tilt_deg = 30;
  for (int i = 0; i < 20; ++i) {
    PoseTask task = draw_task(square_points(0.1), range, random);
    task.sigma_px = 0.1;  // what is stated
    for (const PoseMethod& method : pose_methods(PoseJob::tag)) {
      // EPnP and SQPnP lose squares, Gao's P3P (and Ransac, which takes it here) loses roots.
      if (std::set<std::string>{"OpenCV EPNP", "OpenCV SQPNP", "OpenCV P3P",
                                "OpenCV solvePnPRansac"}
              .contains(method.name))
        continue;
      const double tolerance =
          method.name.starts_with("OpenCV USAC") ? 1e-2 : 1e-3;  // inner, rough
      const PreparedPose prepared = method.prepare(task);
      prepared.solve();
      const PoseAnswer answer = prepared.answer();
      ASSERT_TRUE(answer.success) << method.name;
      EXPECT_LT(angle_between_rad(answer.camera_from_target, task.camera_from_target), tolerance)
          << method.name;
    }
  }
}

TEST(PoseError, isOneAtTheBound) {
  // The linear estimate at the truth has the bound's covariance by construction: a step of one
  // standard deviation along each axis of the ellipsoid counts as one.
  Random random(6);
  const PoseTask task = draw_task(tag_grid_points(3), {}, random);
  const Matrix6 information = pose_information(task);
  PoseAnswer answer;
  answer.success = true;
  Vector6d step = Vector6d::Zero();
  step[4] = 1 / std::sqrt(information(4, 4));
  answer.camera_from_target = retract(task.camera_from_target, step);
  const Vector6d error = pose_error(answer, task);
  EXPECT_NEAR(error.dot(information * error), 1, 1e-9);
}

TEST(PoseError, knowsTheOtherPoseOfAPlane) {
  Random random(7);
  ViewRange range;
  range.min_tilt_deg = 20;
  for (int i = 0; i < 50; ++i) {
    const Pose truth = draw_task(square_points(0.1), range, random).camera_from_target;
    EXPECT_FALSE(is_flip(truth, truth));
    EXPECT_TRUE(is_flip(flipped(truth), truth));
    EXPECT_NEAR(angle_between_rad(flipped(flipped(truth)), truth), 0, 1e-7);
  }
}

}  // namespace
}  // namespace tagcal
