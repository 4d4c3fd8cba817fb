// Rectified pairs in the files of OpenCV and ROS.

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "rig_formats_fixture.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

// cv::FileStorage reads both files, as OpenCV's stereo_match does, and R, T and F mean there what
// they mean here.
TEST_F(RigFormats, OpenCVReadsTheStereoPair) {
  Random random(5);
  CameraFile rig = random_rig(random, 2);
  const Pose right_from_left(exp_rotation({0.01, -0.02, 0.03}), {-0.11, 0.002, -0.003});
  rig.cameras[1].camera_from_rig = right_from_left;
  write_camera_file(folder_ / "stereo", rig, "opencv");
  const cv::FileStorage in(path("stereo/intrinsics.yml"), cv::FileStorage::READ);
  const cv::FileStorage ex(path("stereo/extrinsics.yml"), cv::FileStorage::READ);
  ASSERT_TRUE(in.isOpened() && ex.isOpened());
  cv::Mat m1, d1, m2, d2, r, t, e, f;
  in["M1"] >> m1;
  in["D1"] >> d1;
  in["M2"] >> m2;
  in["D2"] >> d2;
  ex["R"] >> r;
  ex["T"] >> t;
  ex["E"] >> e;
  ex["F"] >> f;
  ASSERT_EQ(t.size(), cv::Size(1, 3));
  EXPECT_EQ(t.at<double>(0), -0.11);
  cv::Mat rvec;
  cv::Rodrigues(r, rvec);
  const cv::Mat none = cv::Mat::zeros(1, 5, CV_64F);
  const std::vector<cv::Point3d> points = {{0.3, -0.2, 2}, {-0.5, 0.1, 1.5}, {0, 0.4, 5}};
  std::vector<cv::Point2d> left, right;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), m1, none, left);
  cv::projectPoints(points, rvec, t, m2, none, right);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::Mat x1 = (cv::Mat_<double>(3, 1) << left[i].x, left[i].y, 1);
    const cv::Mat x2 = (cv::Mat_<double>(3, 1) << right[i].x, right[i].y, 1);
    EXPECT_LT(std::abs(cv::Mat(x2.t() * f * x1).at<double>(0)), 1e-9);
  }
  EXPECT_EQ(f.at<double>(2, 2), 1);
  // The same points by this library, with the distortion.
  cv::projectPoints(points, rvec, t, m2, d2, right);
  const auto& lens = std::get<Perspective>(rig.cameras[1].calibration.camera.lens);
  const Eigen::Vector2d own = *lens.project(right_from_left * Vector3d(0.3, -0.2, 2));
  EXPECT_LT((own - Eigen::Vector2d(right[0].x, right[0].y)).norm(), 1e-9);
}

// P[3] = -f b of a rectified pair, and the rotations into its common frame, place the cameras.
TEST_F(RigFormats, RosPairsHaveAPlace) {
  fs::create_directories(folder_ / "ros");
  const Eigen::Matrix3d turn = exp_rotation({0.01, 0.02, -0.03}).toRotationMatrix();
  std::string data;
  for (int i = 0; i < 9; ++i) data += (i ? ", " : "") + std::to_string(turn(i / 3, i % 3));
  write("ros/left.yaml", kRosYaml);
  write("ros/right.yaml",
        replaced(
            replaced(kRosYaml, "[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]", "[" + data + "]"),
            "[550.0, 0.0, 321.0, 0.0,", "[550.0, 0.0, 321.0, -60.5,"));
  const CameraFile pair = read_camera_file(folder_ / "ros");
  ASSERT_EQ(pair.cameras.size(), 2U);
  EXPECT_EQ(pair.cameras[1].name, "right");
  const Pose expected = Pose(Eigen::Quaterniond(turn), Vector3d::Zero()).inverse() *
                        Pose(Eigen::Quaterniond::Identity(), {-0.11, 0, 0});
  EXPECT_LT(minus(from_first(pair, 1), expected).norm(), 1e-5);  // 6 decimals of R
}

// Both have the rectification of cv::stereoRectify, and the places are read back from ROS' files.
TEST_F(RigFormats, PairsAreRectifiedForOpenCVAndRos) {
  Random random(5);
  CameraFile rig = random_rig(random, 2);
  for (FileCamera& camera : rig.cameras) {
    const double f = 400 + 10 * random.normal();
    camera.calibration.camera.lens = Perspective({f, f + 1, 321, 239, 0, 0, 0, 0, 0});
  }
  const Pose right_from_left(exp_rotation({0.01, -0.02, 0.03}), {-0.11, 0.002, -0.003});
  rig.cameras[1].camera_from_rig = right_from_left;
  write_camera_file(folder_ / "stereo", rig, "opencv");
  const cv::FileStorage in(path("stereo/intrinsics.yml"), cv::FileStorage::READ);
  const cv::FileStorage ex(path("stereo/extrinsics.yml"), cv::FileStorage::READ);
  const auto matrix = [](const cv::FileStorage& file, const char* key) {
    cv::Mat value;
    file[key] >> value;
    return value;
  };
  cv::Mat r1, r2, p1, p2, q;
  cv::stereoRectify(matrix(in, "M1"), matrix(in, "D1"), matrix(in, "M2"), matrix(in, "D2"),
                    {640, 480}, matrix(ex, "R"), matrix(ex, "T"), r1, r2, p1, p2, q,
                    cv::CALIB_ZERO_DISPARITY, 0);
  // OpenCV takes the border of `alpha` one pixel too far (rectify_test).
  for (const auto& [key, expected, tolerance] : {std::tuple{"R1", r1, 1e-8},
                                                 {"R2", r2, 1e-8},
                                                 {"P1", p1, 0.3},
                                                 {"P2", p2, 0.3},
                                                 {"Q", q, 0.3}}) {
    ASSERT_EQ(matrix(ex, key).size(), expected.size()) << key;
    EXPECT_LT(cv::norm(matrix(ex, key), expected, cv::NORM_INF), tolerance) << key;
  }
  write_camera_file(folder_ / "infos", rig, "ros");
  const CameraFile back = read_camera_file(folder_ / "infos");
  ASSERT_EQ(back.cameras.size(), 2U);
  EXPECT_LT(minus(from_first(back, 1), right_from_left).norm(), 1e-12);

  // Cameras that look at each other.
  rig.cameras[1].camera_from_rig = Pose(exp_rotation({0, 3.14, 0}), {0, 0, 1});
  const auto notes = write_camera_file(folder_ / "opposed", rig, "ros");
  EXPECT_HAS(notes.front(), "the pair is not rectified: ");
}

}  // namespace
}  // namespace tagcal
