#include <gtest/gtest.h>

#include "camera_files.hpp"
#include "file_fixture.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"

// What is in a file of cameras is read or refused, but never dropped silently.

namespace tagcal {
namespace {

class CameraFileDrops : public FileTest {
 protected:
  std::string error(const std::string& text, const std::string& name = "in") const {
    const fs::path file = write(name, text);
    return after_name(error_of([&] { read_camera_file(file); }), name);
  }
  std::string images_error(const std::string& images) const {
    write("images.txt", images);
    const fs::path file = write("cameras.txt", kColmap);
    return after_name(error_of([&] { read_camera_file(file); }), "images.txt");
  }
  std::string after_name(const std::string& message, const std::string& name) const {
    const std::string file = (folder_ / name).string() + ": ";
    return message.starts_with(file) ? message.substr(file.size()) : message;
  }
};

// Without its blank lines each second pose looks like the points of the one before.
TEST_F(CameraFileDrops, ColmapsPosesThatStandWherePointsAre) {
  const std::string pose = " 1 0 0 0 0 0 1 7 ";
  EXPECT_EQ(images_error("1" + pose + "a.png\n\n2" + pose + "b.png"), "no error");
  EXPECT_EQ(
      images_error("1" + pose + "a.png\n2" + pose + "b.png\n"),
      "line 2: must be blank or have X Y POINT3D_ID of each point of a.png, got 2 1 0 0 0 0 0 "
      "1 7 b.png");
  EXPECT_EQ(images_error("1" + pose + "a.png\n1 2 3 4\n"),
            "line 2: must be blank or have X Y POINT3D_ID of each point of a.png, got 1 2 3 4");
  EXPECT_EQ(images_error("1" + pose + "a.png\n\n1" + pose + "b.png\n\n"),
            "line 3: IMAGE_ID: must differ from those before it");
  EXPECT_EQ(images_error("1" + pose + "a.png\n\n2" + pose + "a.png\n\n"),
            "line 3: NAME: must differ from those before it, got a.png");
  EXPECT_EQ(images_error("x" + pose + "a.png\n").substr(0, 35),
            "line 1: IMAGE_ID: must be a whole n");
  EXPECT_EQ(images_error("1" + pose + "a b.png\n"),
            "line 1: must have IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, the name without "
            "spaces");
  EXPECT_EQ(images_error("1" + pose + std::string("a.png\0x\n", 8)),
            "line 1: is not text: binary data");
}

TEST_F(CameraFileDrops, KalibrsCamerasBehindAGap) {
  EXPECT_EQ(error(replaced(kKalibr, "cam1:", "cam2:")), "cam1: the key is missing");
  EXPECT_EQ(error(kKalibr + "cam07: {}\n"), "cam2: the key is missing");
  EXPECT_EQ(error(kKalibr + "camera: {}\n"), "no error");
}

TEST_F(CameraFileDrops, CoefficientsThatTheLensDoesNotHave) {
  const std::string fisheye = replaced(replaced(kNerfstudio, "\"OPENCV\"", "\"OPENCV_FISHEYE\""),
                                       "\"p2\": 1e-05", "\"p2\": 0");
  const std::string none = replaced(replaced(kKalibr, "radtan", "none"),
                                    "[-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]", "[0]");
  const std::string pinhole = replaced(kBasalt, "\"kb4\"", "\"pinhole\"");
  const std::vector<std::pair<std::string, std::string>> table = {
      {fisheye, "no error"},
      {replaced(fisheye, "\"p1\": 0", "\"p1\": 0.5"),
       "p1: must be 0: no fisheye lens here has this coefficient, got 0.5"},
      {replaced(fisheye, "\"p1\"", "\"is_fisheye\": false, \"p1\""),
       "is_fisheye: must be true with camera_model OPENCV_FISHEYE, got false"},
      {none, "no error"},
      {replaced(none, "[0]", "[0, 0.1]"),
       "cam0.distortion_coeffs[1]: must be 0 without a distortion_model, got 0.1"},
      {replaced(kKalibrSphere, "distortion_coeffs: []", "distortion_coeffs: [0.1]"),
       "cam0.distortion_coeffs[0]: must be 0 without a distortion_model, got 0.1"},
      {pinhole,
       "value0.intrinsics[0].intrinsics.k1: must be 0: the lens pinhole has no such coefficient, "
       "got 0.0034"}};
  for (const auto& [text, message] : table) EXPECT_EQ(error(text), message);
}

TEST_F(CameraFileDrops, KeysThatContradictEachOther) {
  const std::string own = replaced(kNerfstudio, "\"colmap_im_id\": 1", "\"cx\": 300");
  const std::string whole = replaced(kInstantNgp, "\"camera_angle_x\":1.2", "\"k1\":0.1");
  const std::vector<std::pair<std::string, std::string>> table = {
      {own, "frames[0].cx: is one of a lens beside that of the whole file, the only one"},
      {replaced(own, "\"cx\": 300", "\"cx\": 320.5"), "no error"},
      {replaced(whole, "\"file_path\"", "\"fl_x\":500,\"w\":800,\"h\":600,\"file_path\""),
       "k1: is not read without fl_x beside it: each frame has its own"},
      {kOpenCVYaml + "cameraMatrix: 1\n",
       "cameraMatrix: is given beside camera_matrix: only one is possible"},
      {kOpenCVYaml + "model: opencv5\nfisheye_model: 1\n",
       "model: must be fisheye4 with a key that says that it is a fisheye, got opencv5"},
      {replaced(kTruthYaml, "  fx: 500",
                "  image_from_camera: [[1, 0, 0, 0], [0, 1, 0, 0]]\n  fx: 500"),
       "camera.image_from_camera: unknown key"},
      {replaced(kTruthYaml, "camera_from_world", "cx: 5, camera_from_world"),
       "poses[0].fx: the key is missing"}};
  for (const auto& [text, message] : table) expect_line(error(text), message);
}

// Pictures are found by name.
TEST_F(CameraFileDrops, TwoViewsOfOneName) {
  const std::string view = "{image: a.png, rotation: [1, 0, 0, 0], translation_m: [0, 0, 1]}";
  const std::string camera = replaced(kRosYaml, "camera_name: front\n", "model: opencv5\n");
  EXPECT_EQ(error(camera + "views: [" + view + "]\n"), "no error");
  EXPECT_EQ(error(camera + "views: [" + view + ", " + view + "]\n"),
            "views[1].image: must differ from the names before it, got a.png");
  const std::size_t first = kInstantNgp.find("{\"file"), end = kInstantNgp.rfind("]}");
  const std::string frame = kInstantNgp.substr(first, end - first);
  EXPECT_EQ(error(replaced(kInstantNgp, frame, frame + "," + frame)),
            "frames[1].file_path: must differ from the names before it, got \"a/0\"");
  const std::size_t extrinsics = kOpenCVYaml.find("extrinsic_parameters");
  EXPECT_EQ(error(camera + "views: [" + view + "]\n" + kOpenCVYaml.substr(extrinsics)),
            "extrinsic_parameters: is given beside views: only one is possible");
}

// Data sets of points have views without names.
TEST_F(CameraFileDrops, ViewsWithoutNamesAreWrittenByNumber) {
  Calibration c;
  c.status = Status::ok;
  c.model = "pinhole";
  c.camera = Camera{pinhole(600, 601, 320, 240), {640, 480}};
  c.views = {CalibratedView{}, CalibratedView{}};
  const CameraFile back = read_camera_file(write("c.yaml", calibration_yaml(c)));
  ASSERT_EQ(back.poses.size(), 2U);
  EXPECT_EQ(back.poses[1].image, "view0001");
  c.views[0].image = c.views[1].image = "a.png";
  EXPECT_ERROR(calibration_yaml(c), "views[1].image: two views have the name a.png");
  CameraFile file = back;
  file.poses[0].image = file.poses[1].image;
  EXPECT_ERROR(
      write_camera_file(folder_ / "d.yaml", file, "tagcal"),
      (folder_ / "d.yaml").string() + ": views[1].image: two views have the name view0001");
}

}  // namespace
}  // namespace tagcal
