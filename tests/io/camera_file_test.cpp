#include "tagcal/io/camera_file.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "camera_files.hpp"
#include "file_fixture.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

class CameraFileTest : public FileTest {
 protected:
  CameraFile read(const std::string& text, const std::string& name = "in") const {
    return read_camera_file(write(name, text));
  }
  std::string error(const std::string& text) const {
    return error_about((folder_ / "in").string(), [&] { read(text); });
  }
};

std::vector<double> numbers(const FileCamera& camera) {
  const std::span<const double> p = parameters(camera.calibration.camera.lens);
  return {p.begin(), p.end()};
}

std::vector<double> first_numbers(const FileCamera& camera, std::size_t count) {
  std::vector<double> p = numbers(camera);
  p.resize(count);
  return p;
}

using Numbers = std::vector<double>;

TEST_F(CameraFileTest, OpenCVsYamlXmlAndJson) {
  const CameraFile yaml = read(kOpenCVYaml);
  EXPECT_EQ(yaml.format, "opencv");
  ASSERT_EQ(yaml.cameras.size(), 1U);
  EXPECT_EQ(
      numbers(yaml.cameras[0]),
      (Numbers{5.3591573396000001e+02, 5.3591573396000001e+02, 3.4228315473000001e+02,
               2.3557082909000001e+02, -2.6637260909660682e-01, -3.8588898922304653e-02,
               1.7831947042852964e-03, -2.8122100441115472e-04, 2.3839153080878486e-01, 0, 0, 0}));
  EXPECT_EQ(yaml.cameras[0].calibration.camera.image_size, (ImageSize{640, 480}));
  ASSERT_EQ(yaml.poses.size(), 2U);
  EXPECT_EQ(yaml.poses[1].image, "view0001");
  EXPECT_EQ(yaml.poses[1].camera_from_world.translation(),
            Vector3d(-5.9070e-02, 8.2628e-02, 3.5059e-01));
  EXPECT_LT((log_rotation(yaml.poses[1].camera_from_world.rotation()) -
             Vector3d(4.1331e-01, 6.4934e-01, -1.3371e+00))
                .norm(),
            1e-14);
  const Numbers expected = {
      600.12345678901234, 601, 319.5, 239.5, -0.41, 0.52, 0, 0, -0.58, 0, 0, 0};
  EXPECT_EQ(numbers(read(kOpenCVXml).cameras[0]), expected);
  EXPECT_EQ(numbers(read(replaced(replaced(kOpenCVJson, "camera_matrix", "cameraMatrix"),
                                  "distortion_coefficients", "distCoeffs"))
                        .cameras[0]),
            expected);
  const CameraFile json = read(kOpenCVJson);
  EXPECT_EQ(numbers(json.cameras[0]), expected);
  EXPECT_EQ(
      json.notes,
      (std::vector<std::string>{"dropped: 4 coefficients of thin prism and tilt, which are 0"}));
}

TEST_F(CameraFileTest, StereoPairWithoutAnImageSize) {
  const fs::path file = write("intrinsics.yml", kStereoYaml);
  const CameraFile stereo = read_camera_file(file);
  ASSERT_EQ(stereo.cameras.size(), 2U);
  EXPECT_EQ(stereo.cameras[1].name, "right");
  EXPECT_EQ(first_numbers(stereo.cameras[1], 5), (Numbers{538, 538, 326, 248, -0.29}));
  EXPECT_EQ(stereo.cameras[1].calibration.camera.image_size, ImageSize{});
  const CameraFile left = read_one_camera(file.string() + ":left");
  const fs::path with_colons = write("a:b:c.yml", kStereoYaml);
  EXPECT_EQ(read_one_camera(with_colons.string() + ":left").cameras.size(), 1U);
  EXPECT_TRUE(error_of([&] {
                usable_camera(left, "L");
              }).starts_with("L: image_width: the key is missing"));
  EXPECT_ERROR(write_camera_file(folder_ / "o", left, "ros"),
               (folder_ / "o").string() + ": the image size is not known: give it by --image-size");
  EXPECT_FALSE(fs::exists(folder_ / "o"));
}

TEST_F(CameraFileTest, KalibrsChain) {
  const CameraFile file = read(kKalibr);
  EXPECT_EQ(file.format, "kalibr");
  ASSERT_EQ(file.cameras.size(), 2U);
  EXPECT_EQ(numbers(file.cameras[0]),
            (Numbers{458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359,
                     1.76187114e-05, 0, 0, 0, 0}));
  EXPECT_EQ(numbers(file.cameras[1]),
            (Numbers{457.587, 456.134, 379.999, 255.238, -0.013, 0.02, -0.01, 0.001}));
  ASSERT_TRUE(file.cameras[1].camera_from_rig);
  // The first camera's centre, seen from the second: the second is to its right.
  EXPECT_EQ((*file.cameras[1].camera_from_rig * Vector3d::Zero()).x(), -0.1100738);
  const std::string imu =
      "  T_cam_imu: [[0, -1, 0, 0.5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n";
  const CameraFile with_imu = read(
      replaced(replaced(replaced(kKalibr, "cam0:\n", "cam0:\n" + imu), "cam1:\n", "cam1:\n" + imu),
               "T_cn_cnm1", "not_T_cn_cnm1"));
  EXPECT_EQ(with_imu.cameras[0].camera_from_rig->translation(), Vector3d(0.5, 0, 0));
  const CameraFile sphere = read(kKalibrSphere);
  EXPECT_TRUE(std::holds_alternative<DoubleSphere>(sphere.cameras[0].calibration.camera.lens));
  EXPECT_EQ(first_numbers(sphere.cameras[0], 6),
            (Numbers{158.3, 158.4, 254.9, 256.9, -0.17, 0.59}));
  EXPECT_EQ(numbers(read(kEuroc).cameras[0]), numbers(file.cameras[0]));
}

TEST_F(CameraFileTest, RosCameraInfo) {
  const CameraFile file = read(kRosYaml);
  EXPECT_EQ(file.format, "ros");
  EXPECT_EQ(file.cameras[0].name, "front");
  EXPECT_EQ(first_numbers(file.cameras[0], 9),
            (Numbers{600.5, 601, 320.25, 240, -0.2, 0.05, 0.001, 0.002, 0}));
  EXPECT_EQ(file.notes,
            (std::vector<std::string>{"dropped: rectification_matrix and projection_matrix"}));
  EXPECT_EQ(numbers(read(replaced(replaced(kRosYaml, "cols: 5", "cols: 0"),
                                  "[-0.2, 0.05, 0.001, 0.002, 0.0]", "[]"))
                        .cameras[0])[4],
            0);
}

TEST_F(CameraFileTest, ColmapsTextWithPoses) {
  write("images.txt", kColmapImages);
  const CameraFile file = read(kColmap, "cameras.txt");
  ASSERT_EQ(file.cameras.size(), 3U);
  EXPECT_EQ(first_numbers(file.cameras[0], 9),
            (Numbers{600, 601, 320, 240, -0.2, 0.05, 0.001, -0.002, 0}));
  EXPECT_EQ(first_numbers(file.cameras[1], 6), (Numbers{900.25, 900.25, 511.5, 383.5, 0.03, 0}));
  EXPECT_EQ(numbers(file.cameras[2]),
            (Numbers{190.1, 190.2, 254.5, 256, 0.003, 0.0007, -0.002, 0.0002}));
  ASSERT_EQ(file.poses.size(), 2U);
  EXPECT_EQ(file.poses[1].camera, 2U);
  EXPECT_EQ(file.poses[1].image, "right01.png");
  const Eigen::Quaterniond q = file.poses[0].camera_from_world.rotation();
  EXPECT_EQ(q.coeffs(), Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5).coeffs());
  EXPECT_EQ(file.poses[0].camera_from_world.translation(), Vector3d(0.1, -0.2, 3));
  const CameraFile one = read_one_camera((folder_ / "cameras.txt").string() + ":7");
  ASSERT_EQ(one.cameras.size(), 1U);
  ASSERT_EQ(one.poses.size(), 1U);
  EXPECT_EQ(one.poses[0].camera, 0U);
  EXPECT_EQ(read_camera_file(folder_).cameras.size(), 3U);
}

TEST_F(CameraFileTest, MrcalsModel) {
  const CameraFile file = read(kMrcal);
  EXPECT_EQ(file.format, "mrcal");
  EXPECT_EQ(numbers(file.cameras[0]),
            (Numbers{1190.6, 1190.1, 804.3, 455.2, 0.03, -0.15, 0, 0, 0.11, -0.01, 0.01, 0}));
  EXPECT_EQ(file.cameras[0].calibration.camera.image_size, (ImageSize{1600, 896}));
  EXPECT_EQ(file.cameras[0].camera_from_rig->translation(), Vector3d(1, 2, -0.5));
  EXPECT_EQ(file.notes.size(), 2U);
}

TEST_F(CameraFileTest, NerfstudioSaysOnceThatFramesHaveNoCentre) {
  const std::string frame =
      R"({"file_path": "a.png", "fl_x": 600, "w": 640, "h": 480,
          "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})";
  const CameraFile file =
      read("{\"frames\": [" + frame + ", " + replaced(frame, "a.png", "b.png") + "]}");
  ASSERT_EQ(file.notes.size(), 2U);
  EXPECT_EQ(file.notes[0], "cx, cy are not given: the centre of the image is taken");
}

TEST_F(CameraFileTest, NerfstudioTurnsTheCamera) {
  const CameraFile file = read(kNerfstudio);
  EXPECT_EQ(first_numbers(file.cameras[0], 8), (Numbers{600, 601, 320, 240, -0.2, 0.05, 0, 1e-05}));
  ASSERT_EQ(file.poses.size(), 1U);
  const Pose& pose = file.poses[0].camera_from_world;
  // The camera stands at (1, -2, 0.5) and looks along +y with z up: OpenGL's z column is (0, -1,
  // 0).
  EXPECT_LT((pose.inverse().translation() - Vector3d(1, -2, 0.5)).norm(), 1e-15);
  EXPECT_LT((pose * Vector3d(1, 3, 0.5) - Vector3d(0, 0, 5)).norm(), 1e-14);
  EXPECT_LT((pose * Vector3d(1, -2, 1.5) - Vector3d(0, -1, 0)).norm(), 1e-14);
  const CameraFile ngp = read(kInstantNgp);
  EXPECT_NEAR(first_numbers(ngp.cameras[0], 1)[0], 400 / std::tan(0.6), 1e-12);
  EXPECT_EQ(first_numbers(ngp.cameras[0], 4)[2], 399.5);
}

TEST_F(CameraFileTest, NamesOfCamerasHaveColons) {
  CameraFile camera = read(kTruthYaml);
  camera.cameras[0].name = "rig: left:wide";
  write_camera_file(folder_ / "ros.yaml", camera, "ros");
  const CameraFile one = read_one_camera((folder_ / "ros.yaml").string() + ":rig: left:wide");
  EXPECT_EQ(one.cameras.at(0).name, "rig: left:wide");
}

TEST_F(CameraFileTest, BasaltsCameras) {
  const fs::path path = write("calibration.json", kBasalt);
  const CameraFile file = read_camera_file(path);
  ASSERT_EQ(file.cameras.size(), 3U);
  EXPECT_EQ(numbers(file.cameras[0]),
            (Numbers{190.9, 190.8, 254.9, 256.8, 0.0034, 0.00071, -0.002, 0.0002}));
  EXPECT_EQ(first_numbers(file.cameras[1], 6), (Numbers{158.3, 158.3, 254.9, 256.9, -0.17, 0.59}));
  EXPECT_EQ(numbers(file.cameras[2])[11], 0.034);
  EXPECT_LT((file.cameras[0].camera_from_rig->inverse().translation() - Vector3d(0.05, -0.01, 0.02))
                .norm(),
            1e-16);
  const std::string sphere = path.string() + ":cam1";
  const CameraFile one = read_one_camera(sphere);
  EXPECT_TRUE(std::holds_alternative<DoubleSphere>(usable_camera(one, sphere).camera.lens));
  EXPECT_ERROR(read_one_camera(path.string()),
               path.string() + ": has 3 cameras (cam0, cam1, cam2): choose one by " +
                   path.string() + ":cam0");
  EXPECT_ERROR(read_one_camera(path.string() + ":left"),
               path.string() + ": has no camera left, only cam0, cam1, cam2");
}

TEST_F(CameraFileTest, TruthServesAsACamera) {
  const CameraFile file = read(kTruthYaml);
  EXPECT_EQ(file.format, "tagcal");
  EXPECT_EQ(file.cameras[0].calibration.model, "radial1");
  EXPECT_EQ(first_numbers(file.cameras[0], 5), (Numbers{500, 500, 321, 239, -0.1}));
  EXPECT_EQ(file.poses.size(), 1U);
}

TEST_F(CameraFileTest, LensesThatAreNotHereAreRefusedByName) {
  const std::vector<std::pair<std::string, std::string>> table = {
      {replaced(kMrcal, "LENSMODEL_OPENCV8',\n\n", "LENSMODEL_CAHVOR',\n\n"), "LENSMODEL_CAHVOR"},
      {replaced(kMrcal, "LENSMODEL_OPENCV8',\n\n",
                "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=30',\n\n"),
       "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=30"},
      {"Dimensions = 10 20\nModel = CAHVORE3,0 = general\nC = 1 2 3\n", "CAHVORE3,0"},
      {replaced(kColmap, "1 OPENCV 640 480 600 601 320.5 240.5 -0.2 0.05 0.001 -0.002",
                "1 THIN_PRISM_FISHEYE 640 480 600 601 320.5 240.5 0 0 0 0 0 0 0 0"),
       "THIN_PRISM_FISHEYE"},
      {replaced(kKalibr, "radtan", "fov"), "fov"},
      {replaced(kKalibr, "camera_model: pinhole\n  distortion_coeffs: [-0.28340811",
                "camera_model: omni\n  distortion_coeffs: [-0.28340811")
           .replace(0, 0, ""),
       "intrinsics"},
      {replaced(kBasalt, "\"kb4\"", "\"fov\""), "fov"},
      {replaced(kNerfstudio, "\"OPENCV\"", "\"EQUIRECTANGULAR\""), "EQUIRECTANGULAR"}};
  for (const auto& [text, lens] : table) EXPECT_HAS(error(text), lens);
}

TEST_F(CameraFileTest, BadFiles) {
  const std::vector<std::pair<std::string, std::string>> table = {
      {"", ": is empty"},
      {"a: 1\n", ": is no camera's file"},
      {"target_type: aprilgrid\n", ": is a target file, not a camera's file"},
      {"camera: {f: 5}\npath: {type: dome}\n", ": is a scene, not a camera's file"},
      {"640 480 600 601 320 240\n", ": must be a map of keys"},  // no camera of COLMAP
      {"<?xml version=\"1.0\"?>\n<opencv_storage>\n<a>", ": is not OpenCV's XML"},
      {replaced(kOpenCVXml, "6.0012345678901234e+02", ".Nan"),
       ": camera_matrix.data[0]: must be a finite"},
      {replaced(kOpenCVXml, "<cols>3", "<cols>4"), ": camera_matrix.data: must be a list of 12"},
      {replaced(kKalibr, "458.654, ", ""), ": cam0.intrinsics: must be a list of 4"},
      {replaced(kKalibr, "0.9999971", "2"), ": cam1.T_cn_cnm1: "},
      {replaced(kMrcal, "1190.6,", "'x',"), ": intrinsics[0]: must be a finite number"},
      {replaced(kMrcal, "    'imagersize'", "    'imagesize'"), ": imagersize: the key is missing"},
      {replaced(kColmap, "600 601", "600 abc"),
       ": line 4: PARAMS: must be a finite number, got abc"},
      {replaced(kColmap, " -0.002", ""), ": line 4: PARAMS: must have 8 values with OPENCV, got 7"},
      {replaced(kColmap, "600 601", "-600 601"), ": line 4: "},
      {replaced(kNerfstudio, "\"k1\"", "\"k4\""), ": k4: must be 0"},
      {replaced(kNerfstudio, "\"h\": 480", "\"h\": NaN"), ": h: must be a whole number"},
      {kNerfstudio.substr(0, 300), ": line"},
      {replaced(kBasalt, "\"qw\": 0.5", "\"qw\": 5"), ": value0.T_imu_cam[0]: qx qy qz qw"},
      {replaced(kBasalt, "[[512, 512], ", "["), ": value0.resolution: must be a list of 3"},
      {replaced(kBasalt, "\"alpha\": 0.59", "\"beta\": 1"),
       ": value0.intrinsics[1].intrinsics.alpha: the key is missing"}};
  for (const auto& [text, message] : table) expect_line(error(text), message);
}

// Any mangled file is an Error of one line, or a camera.
RC_GTEST_FIXTURE_PROP(CameraFileTest, ManglesEndInAnErrorOrACamera, ()) {
  const std::vector<std::string> good = {
      kOpenCVYaml, kOpenCVXml, kOpenCVJson, kStereoYaml, kKalibr,     kKalibrSphere, kEuroc,
      kRosYaml,    kColmap,    kMrcal,      kNerfstudio, kInstantNgp, kBasalt,       kTruthYaml};
  Random random(*rc::gen::arbitrary<std::uint64_t>());
  // XML goes through OpenCV's parser, which gets half of the files.
  const std::string& text = random.index(2) == 0 ? kOpenCVXml : good[random.index(good.size())];
  try {
    const CameraFile file = read(mutated(text, random));
    for (const FileCamera& camera : file.cameras)
      for (const double p : parameters(camera.calibration.camera.lens)) RC_ASSERT(std::isfinite(p));
  } catch (const Error& error) {
    const std::string message = error.what();
    RC_ASSERT(message.find('\n') == std::string::npos);
    RC_ASSERT(message.starts_with((folder_ / "in").string()));
  }
}

}  // namespace
}  // namespace tagcal
