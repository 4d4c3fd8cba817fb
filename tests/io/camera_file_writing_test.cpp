// What is written in each format, read again by us and by OpenCV.

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <span>
#include <sstream>

#include "camera_files.hpp"
#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal {
namespace {

using CameraFileWriting = FileTest;

// Cameras of each kind with numbers of 17 digits, and poses.
CameraFile example(const Lens& lens, std::size_t num_cameras) {
  Random random(7);
  CameraFile file;
  for (std::size_t i = 0; i < num_cameras; ++i) {
    FileCamera camera;
    camera.name = "cam" + std::to_string(i);
    camera.calibration.camera = {lens, {640, 480}};
    const Pose pose(pose_of_many_sizes(random).rotation(), {random.normal(), random.normal(), 0});
    camera.camera_from_rig = i == 0 ? Pose() : pose;
    file.cameras.push_back(camera);
  }
  for (int i = 0; i < 3; ++i)
    file.poses.push_back({"0" + std::to_string(i) + ".png",
                          static_cast<std::size_t>(i) % num_cameras,
                          Pose(pose_of_many_sizes(random).rotation(),
                               {random.normal(), random.normal(), random.normal()})});
  return file;
}

void expect_same(const CameraFile& a, const CameraFile& b, const std::string& format) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size()) << format;
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const auto& x = a.cameras[i];
    const auto& y = b.cameras[i];
    EXPECT_EQ(y.calibration.camera.image_size,
              format == "wpilib" ? ImageSize() : x.calibration.camera.image_size)
        << format;
    const std::span<const double> p = parameters(x.calibration.camera.lens);
    const std::span<const double> q = parameters(y.calibration.camera.lens);
    ASSERT_EQ(p.size(), q.size()) << format;
    for (std::size_t k = 0; k < p.size(); ++k)
      EXPECT_NEAR(p[k], q[k], 1e-12 * std::max(1.0, std::abs(p[k])));
    if (format == "kalibr" || format == "basalt" || format == "mrcal" || format == "euroc") {
      ASSERT_TRUE(y.camera_from_rig) << format;
      EXPECT_LT(minus(*x.camera_from_rig, *y.camera_from_rig).norm(), 1e-12) << format;
    }
  }
  if (format == "tagcal" || format == "opencv" || format == "colmap" || format == "nerfstudio") {
    ASSERT_EQ(a.poses.size(), b.poses.size()) << format;
    for (std::size_t i = 0; i < a.poses.size(); ++i) {
      EXPECT_LT(minus(a.poses[i].camera_from_world, b.poses[i].camera_from_world).norm(), 1e-12);
      if (format != "opencv") {
        EXPECT_EQ(a.poses[i].image, b.poses[i].image);
      }
    }
  }
}

TEST_F(CameraFileWriting, RoundTripsAreExact) {
  const double f = 1900.1 / 3, c = 641.0 / 3;
  const std::vector<Lens> lenses = {
      pinhole(f, f, c, c), Perspective({f, f + 0.1, c, c, -0.1 / 3, 0.02, 5e-4, -1e-5 / 3}),
      Perspective({f, f, c, c, -0.1, 0.02, 5e-4, -3e-4, 0.01 / 3}),
      Perspective({f, f, c, c, -0.1, 0.02, 5e-4, -3e-4, 0.01, 0.1 / 3, 0.2, 0.3}),
      Fisheye({f, f, c, c, -0.1 / 3, 0.02, 5e-4, -3e-5})};
  int written = 0;
  for (const Lens& lens : lenses) {
    for (const CameraFormat& format : camera_formats()) {
      if (format.only_written) continue;
      for (const char* const name : {"o.yaml", "o.xml", "o.json"}) {
        if (format.name != "opencv" && std::string(name) != "o.yaml") continue;
        const CameraFile file = example(lens, format.several ? 3 : 1);
        const fs::path out = folder_ / std::to_string(written) / name;
        fs::create_directories(out.parent_path());
        const std::string refused = error_of([&] { write_camera_file(out, file, format.name); });
        if (refused != "no error") {
          EXPECT_HAS(refused, "--model");
          EXPECT_FALSE(fs::exists(out));
          continue;
        }
        ++written;
        expect_same(file, read_camera_file(out), std::string(format.name));
      }
    }
  }
  // kalibr and euroc: k3 and k4 .. k6; nerfstudio: k4 .. k6; mrcal and wpilib: fisheye
  EXPECT_EQ(written, 60 - 7);
}

TEST_F(CameraFileWriting, TumNamesTheTimes) {
  CameraFile file = example(pinhole(500, 500, 320, 240), 1);
  file.poses[0].image = "1403636579763555584.png";
  file.poses[1].image = "1403636579813555456.png";
  file.poses[2].image = "12.5.png";
  const fs::path out = folder_ / "t.tum";
  write_camera_file(out, file, "tum");
  std::istringstream lines(read_text(out));
  std::string comment, time;
  std::getline(lines, comment);
  double v[7] = {};
  lines >> time;
  EXPECT_EQ(time, "1403636579.763555584");
  for (double& value : v) lines >> value;
  const Pose world_from_camera(Eigen::Quaterniond(v[6], v[3], v[4], v[5]), {v[0], v[1], v[2]});
  EXPECT_LT(minus(world_from_camera, file.poses[0].camera_from_world.inverse()).norm(), 1e-14);
  // Times of the poses come before names.
  for (std::size_t i = 0; i < 3; ++i) file.poses[i].time_s = 1700000000.25 + static_cast<double>(i);
  write_camera_file(out, file, "tum");
  EXPECT_HAS(read_text(out), "\n1700000001.250000 ");
  file.poses[2].time_s.reset();
  write_camera_file(out, file, "tum");
  EXPECT_HAS(read_text(out), "\n1403636579.813555456 ");
  file.poses.clear();
  EXPECT_TRUE(error_of([&] { write_camera_file(out, file, "tum"); }).starts_with(out.string()));
}

// cv::FileStorage reads what is written.
TEST_F(CameraFileWriting, OpenCVReadsAllThreeForms) {
  const CameraFile file =
      example(Perspective({600.1 / 3, 600, 320, 240, -0.1 / 3, 0.02, 5e-4, -1e-5}), 1);
  for (const char* const name : {"c.yaml", "c.xml", "c.json"}) {
    write_camera_file(folder_ / name, file, "opencv");
    const cv::FileStorage storage((folder_ / name).string(), cv::FileStorage::READ);
    ASSERT_TRUE(storage.isOpened()) << name;
    cv::Mat k, d, poses;
    storage["camera_matrix"] >> k;
    storage["distortion_coefficients"] >> d;
    storage["extrinsic_parameters"] >> poses;
    EXPECT_EQ(static_cast<int>(storage["image_width"]), 640);
    ASSERT_EQ(k.type(), CV_64F) << name;
    EXPECT_EQ(k.at<double>(0, 0), 600.1 / 3);
    EXPECT_EQ(d.at<double>(0, 0), -0.1 / 3);
    EXPECT_EQ(d.at<double>(0, 3), -1e-5);
    ASSERT_EQ(poses.size(), cv::Size(6, 3)) << name;
    EXPECT_EQ(poses.at<double>(1, 4), file.poses[1].camera_from_world.translation().y());
  }
}

}  // namespace
}  // namespace tagcal
