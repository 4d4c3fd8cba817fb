// Cameras in the forms that people have: messages of ROS, its INI file, COLMAP's binary files,
// chains with other names, and files without the size of the pictures.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "camera_files.hpp"
#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal {
namespace {

using Numbers = std::vector<double>;

const std::string kMessage =
    "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: front_optical\nheight: 800\n"
    "width: 1280\ndistortion_model: plumb_bob\nd:\n- -0.0306\n- 0.0352\n- -0.00014\n- -0.00015\n"
    "- -0.012\n- 0.0\n- 0.0\n- 0.0\nk:\n- 620.5\n- 0.0\n- 640.25\n- 0.0\n- 620.7\n- 400.5\n"
    "- 0.0\n- 0.0\n- 1.0\nr: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\nbinning_x: 0\n---\n";

const std::string kIni =
    "# oST version 5.0 parameters\n\n[image]\n\nwidth\n640\n\nheight\n480\n\n[narrow_stereo]\n\n"
    "camera matrix\n533.7 0.000000 342.8\n0.000000 534.1 235.7\n0.000000 0.000000 1.000000\n\n"
    "distortion\n-0.289 0.1 0.001 0.0002 0.0000\n\nrectification\n1 0 0\n0 1 0\n0 0 1\n";

class CameraTexts : public FileTest {
 protected:
  CameraFile read(const std::string& text, const ImageSize& size = {}) const {
    return read_camera_file(write("in", text), size);
  }
  std::string error(const std::string& text) const {
    return error_of([&] { read(text); });
  }
  Numbers first(const CameraFile& file, std::size_t count) const {
    const std::span<const double> p = parameters(file.cameras[0].calibration.camera.lens);
    return {p.begin(), p.begin() + static_cast<std::ptrdiff_t>(count)};
  }
};

TEST_F(CameraTexts, MessagesOfRos) {
  const Numbers expected = {620.5, 620.7, 640.25, 400.5, -0.0306, 0.0352};
  const CameraFile file = read(kMessage);
  EXPECT_EQ(file.format, "ros");
  EXPECT_EQ(first(file, 6), expected);
  EXPECT_EQ(file.cameras[0].name, "front_optical");
  EXPECT_EQ(file.cameras[0].calibration.camera.image_size, (ImageSize{1280, 800}));
  std::string ros1 = replaced(replaced(kMessage, "\nd:", "\nD:"), "\nk:", "\nK:");
  EXPECT_EQ(first(read(ros1), 6), expected);
  EXPECT_EQ(first(read(kMessage + kMessage), 6), expected);
  EXPECT_HAS(read(kMessage + kMessage).notes.back(), "after the first one");
  EXPECT_HAS(read(replaced(kMessage, "binning_x: 0", "binning_x: 2")).notes.back(), "--resize");
  EXPECT_HAS(error(replaced(replaced(kMessage, "620.5", "0.0"), "620.7", "0.0")),
             "k: has no focal length: this camera was not calibrated");
  EXPECT_HAS(error(replaced(kMessage, "-0.0306", "1e-310")), "d: has the number 1e-310");
}

// The camera of ROS is that of the whole picture, whatever the driver sends.
TEST_F(CameraTexts, PartsAndBinnedPicturesOfRosAreNoted) {
  const std::string yaml =
      "image_width: 1280\nimage_height: 800\ncamera_name: front\ndistortion_model: plumb_bob\n"
      "camera_matrix: {rows: 3, cols: 3, data: [620, 0, 640, 0, 620, 400, 0, 0, 1]}\n"
      "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\nbinning_x: 0\n";
  for (const std::string& text : {kMessage, yaml}) {
    const auto notes = [&](const std::string& keys) {
      const CameraFile file = read(replaced(text, "binning_x: 0\n", keys));
      EXPECT_EQ(file.cameras[0].calibration.camera.image_size, (ImageSize{1280, 800}));
      return file.notes;
    };
    const std::vector<std::string> part = notes(
        "binning_x: 1\nbinning_y: 2\nroi:\n  x_offset: 320\n  y_offset: 240\n  height: 480\n"
        "  width: 640\n  do_rectify: false\n");
    ASSERT_EQ(part.size(), 2U);
    EXPECT_HAS(part[0], "--crop 320,240,640x480");
    EXPECT_TRUE(part[1].starts_with("binning_y: ")) << part[1];
    EXPECT_TRUE(notes("roi: {x_offset: 0, y_offset: 0, height: 0, width: 0}\n").empty());
    EXPECT_TRUE(notes("roi: {x_offset: 0, y_offset: 0, height: 800, width: 1280}\n").empty());
  }
}

TEST_F(CameraTexts, TheIniFileOfRos) {
  const CameraFile file = read(kIni);
  EXPECT_EQ(file.format, "ros");
  EXPECT_EQ(file.cameras[0].name, "narrow_stereo");
  EXPECT_EQ(first(file, 7), (Numbers{533.7, 534.1, 342.8, 235.7, -0.289, 0.1, 0.001}));
  EXPECT_EQ(file.cameras[0].calibration.camera.image_size, (ImageSize{640, 480}));
  EXPECT_HAS(error(replaced(kIni, "533.7 0.000000 342.8\n", "")),
             "camera matrix: must be a finite number, got distortion");
  EXPECT_HAS(error(replaced(kIni, "\n640\n", "\nwide\n")), "width");
}

TEST_F(CameraTexts, ChainsWithOtherNamesAndWithoutASize) {
  std::string chain = replaced(replaced(kKalibr, "cam0:", "left:"), "cam1:", "right:");
  const CameraFile file = read(chain);
  ASSERT_EQ(file.cameras.size(), 2U);
  EXPECT_EQ(file.cameras[0].name, "left");
  EXPECT_EQ(file.cameras[1].name, "right");
  EXPECT_TRUE(file.cameras[1].camera_from_rig);
  const std::size_t at = chain.find("  resolution:");
  chain.erase(at, chain.find('\n', at) + 1 - at);
  EXPECT_EQ(read(chain).cameras[0].calibration.camera.image_size, ImageSize());
  EXPECT_EQ(first(read(chain), 4), first(file, 4));
}

TEST_F(CameraTexts, AnglesNeedTheSizeOfThePictures) {
  const std::string angle =
      R"({"camera_angle_x": 0.7853981633974483, "aabb_scale": 16, "frames": []})";
  EXPECT_HAS(error(angle), "w: the key is missing: state the size of the pictures, --image-size");
  const double f = 400 / std::tan(std::numbers::pi / 8);
  const CameraFile file = read(angle, {800, 800});
  EXPECT_EQ(file.cameras[0].calibration.camera.image_size, (ImageSize{800, 800}));
  const Numbers p = first(file, 4);
  EXPECT_NEAR(p[0], f, 1e-9);
  EXPECT_NEAR(p[1], f, 1e-9);
  EXPECT_EQ(p[2], 399.5);
  EXPECT_EQ(p[3], 399.5);
}

// The bytes of a little-endian machine.
template <typename... Values>
std::string bytes(const Values&... values) {
  std::string all;
  (all.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  return all;
}

TEST_F(CameraTexts, ColmapsBinaryFiles) {
  using std::int32_t, std::uint32_t, std::uint64_t;
  const std::string cameras =
      bytes(uint64_t{1}, uint32_t{7}, int32_t{4}, uint64_t{640}, uint64_t{480}, 500.0, 501.0, 320.5,
            240.5, 0.1, 0.01, 0.001, 0.002);
  const std::string images =
      bytes(uint64_t{1}, uint32_t{3}, 1.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3, uint32_t{7}) +
      std::string("a.png\0", 6) + bytes(uint64_t{1}, 10.0, 20.0, uint64_t{5});
  fs::create_directories(folder_ / "sparse");
  fs::create_directories(folder_ / "cut");
  write("sparse/images.bin", images);
  const fs::path file = write("sparse/cameras.bin", cameras);
  for (const fs::path& path : {file, file.parent_path()}) {
    const CameraFile read = read_camera_file(path);
    EXPECT_EQ(read.format, "colmap");
    EXPECT_EQ(read.cameras[0].name, "7");
    EXPECT_EQ(first(read, 8), (Numbers{500, 501, 320, 240, 0.1, 0.01, 0.001, 0.002}));
    ASSERT_EQ(read.poses.size(), 1U);
    EXPECT_EQ(read.poses[0].image, "a.png");
    EXPECT_EQ(read.poses[0].camera_from_world.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  }
  for (std::size_t size = 0; size < cameras.size(); size += 5) {
    const fs::path cut = write("cut/cameras.bin", cameras.substr(0, size));
    EXPECT_HAS(error_of([&] { read_camera_file(cut); }), "is truncated");
  }
  EXPECT_HAS(error_of([&] { read_camera_file(write("images.bin", images)); }), "cameras.bin");
}

}  // namespace
}  // namespace tagcal
