// Programs of others read what is written. A test is skipped where its program is not installed
// (tools/setup.sh --peers).
#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>

#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/corners_file.hpp"

namespace tagcal {
namespace {

class PeerReadersTest : public FileTest {
 protected:
  // The output of a command, or no value if it fails.
  static std::optional<std::string> output(const std::string& command) {
    FILE* const pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
    if (!pipe) return std::nullopt;
    std::string text;
    char buffer[4096];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
      text.append(buffer, n);
    return ::pclose(pipe) == 0 ? std::optional(text) : std::nullopt;
  }

  // Debian's Python, which has Debian's packages.
  static bool has_module(const std::string& name) {
    return output("/usr/bin/python3 -c 'import " + name + "'").has_value();
  }

  std::vector<double> python(const std::string& script) const {
    const auto text = output("/usr/bin/python3 " + write("script.py", script).string());
    EXPECT_TRUE(text.has_value());
    std::istringstream words(text.value_or(""));
    std::vector<double> values;
    for (double value = 0; words >> value;) values.push_back(value);
    return values;
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
};

CameraFile camera_file(const Lens& lens) {
  CameraFile file;
  FileCamera camera;
  camera.calibration.camera = {lens, {640, 480}};
  camera.camera_from_rig = Pose(exp_rotation({0.1, -0.2, 0.3}), {0.4, 0.5, -0.6});
  file.cameras = {camera};
  file.poses = {{"00.png", 0, Pose(exp_rotation({0.3, 0.2, -0.1}), {0.1, 0.2, 1.5})},
                {"01.png", 0, Pose(exp_rotation({-0.3, 0.5, 2}), {-0.1, 0.2, 1.0 / 3})}};
  return file;
}

const std::vector<Lens>& lenses() {
  static const std::vector<Lens> all = {
      pinhole(1900.1 / 3, 601, 641.0 / 3, 240.25),
      Perspective({600.0, 601, 320.25, 240, -0.1 / 3, 0.02, 5e-4, -1e-5 / 3}),
      Perspective({600.0, 601, 320.25, 240, -0.1 / 3, 0.02, 5e-4, -3e-4, 0.01}),
      Perspective({600.0, 601, 320.25, 240, -0.1, 0.02, 5e-4, -3e-4, 0.01, 0.1 / 3, 0.02, 0.03})};
  return all;
}

const Eigen::Vector3d kPoints[] = {{0.1, 0.2, 1}, {-0.4, 0.3, 1.1}, {0.3, -0.2, 0.9}};

TEST_F(PeerReadersTest, MrcalProjectsAlike) {
  if (!has_module("mrcal")) GTEST_SKIP() << "python3-mrcal is not installed";
  std::string script =
      "import mrcal, numpy as np\nx = np.array([[0.1,0.2,1],[-0.4,0.3,1.1],[0.3,-0.2,0.9]])\n";
  for (std::size_t i = 0; i < lenses().size(); ++i) {
    const std::string name = std::to_string(i) + ".cameramodel";
    write_camera_file(folder_ / name, camera_file(lenses()[i]), "mrcal");
    script +=
        "m = mrcal.cameramodel('" + path(name) + "')\n" +
        "for q in mrcal.project(x, *m.intrinsics()): print(repr(float(q[0])), repr(float(q[1])))\n"
        "print(*m.imagersize())\nprint(*[repr(float(v)) for v in m.extrinsics_rt_fromref()])\n";
  }
  const std::vector<double> values = python(script);
  ASSERT_EQ(values.size(), lenses().size() * 14);
  const double rt[] = {0.1, -0.2, 0.3, 0.4, 0.5, -0.6};
  for (std::size_t i = 0; i < lenses().size(); ++i) {
    const double* v = &values[14 * i];
    for (const Eigen::Vector3d& point : kPoints) {
      const Eigen::Vector2d pixel = *project(lenses()[i], point);
      EXPECT_NEAR(*v++, pixel.x(), 1e-9);
      EXPECT_NEAR(*v++, pixel.y(), 1e-9);
    }
    EXPECT_EQ(*v++, 640);
    EXPECT_EQ(*v++, 480);
    for (const double expected : rt) EXPECT_NEAR(*v++, expected, 1e-12);
  }
}

// What mrcal writes is read; it rounds to 10 digits.
TEST_F(PeerReadersTest, MrcalsOwnFileIsRead) {
  if (!has_module("mrcal")) GTEST_SKIP() << "python3-mrcal is not installed";
  python(
      "import mrcal, numpy as np\nm = mrcal.cameramodel(intrinsics=('LENSMODEL_OPENCV5', "
      "np.array((600.5,601,320,240,-.1,.02,1e-5,2e-5,.03))), imagersize=(640,480), "
      "extrinsics_rt_fromref=np.array((.1,.2,.3,4,5,6)))\nm.write('" +
      path("m.cameramodel") + "', note=\"it's a note\")\n");
  const CameraFile file = read_camera_file(folder_ / "m.cameramodel");
  const auto p = parameters(file.cameras[0].calibration.camera.lens);
  EXPECT_EQ(p[0], 600.5);
  EXPECT_EQ(p[6], 1e-5);
  EXPECT_EQ(p[8], 0.03);
  EXPECT_EQ(file.cameras[0].camera_from_rig->translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(PeerReadersTest, MrcalReadsCorners) {
  if (!has_module("mrcal")) GTEST_SKIP() << "python3-mrcal is not installed";
  Checkerboard board;
  board.columns = 4;
  board.rows = 3;
  board.column_spacing = board.row_spacing = 0.1;
  const std::vector<PlacedBoard> boards = {{make_board(board), Pose()}};
  // Columns run to the right, rows upwards: v falls with the row.
  std::vector<View> views;
  for (const char* const image : {"x0.png", "x1.png"}) {
    View view{image, {}};
    for (int i = 0; i < 12; ++i)
      view.observations.push_back({{i, 0}, {100.0 + i % 4 * 30, 200.0 - i / 4 * 40}, {}});
    views.push_back(view);
    write(image, "");
  }
  views[1].observations.erase(views[1].observations.begin() + 5);
  write_corners(folder_ / "corners.vnl", views, boards, "mrcal");
  const std::vector<double> values =
      python("import mrcal, os\nos.chdir('" + folder_.string() +
             "')\no, i, p = mrcal.compute_chessboard_corners(4, 3, globs_per_camera=('x*.png',), "
             "corners_cache_vnl='corners.vnl')\nprint(*o.shape)\nfor v in o.ravel(): print(v)\n");
  ASSERT_EQ(values.size(), 4U + 2 * 12 * 3);
  const double* v = &values[4];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column, v += 3) {
      EXPECT_EQ(v[0], 100 + 30 * column);
      EXPECT_EQ(v[1], 200 - 40 * (2 - row));
      EXPECT_GT(v[2], 0);
    }
  }
  EXPECT_LT(v[3 * 5 + 2], 0);  // row 1, column 1 is not seen
}

// COLMAP reads the folder, and what it writes is the same.
TEST_F(PeerReadersTest, ColmapConvertsTheFolder) {
  if (!output("colmap help")) GTEST_SKIP() << "colmap is not installed";
  std::vector<Lens> all = lenses();
  all.emplace_back(Fisheye({300.0, 301, 320, 240.5, -0.01 / 3, 0.02, 5e-4, -3e-5}));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string in = path("in" + std::to_string(i)), bin = in + "_bin", out = in + "_txt";
    fs::create_directories(bin);
    fs::create_directories(out);
    const CameraFile file = camera_file(all[i]);
    write_camera_file(in, file, "colmap");
    ASSERT_TRUE(output("QT_QPA_PLATFORM=offscreen colmap model_converter --input_path " + in +
                       " --output_path " + bin + " --output_type BIN"));
    ASSERT_TRUE(output("QT_QPA_PLATFORM=offscreen colmap model_converter --input_path " + bin +
                       " --output_path " + out + " --output_type TXT"));
    const CameraFile back = read_camera_file(out);
    const auto p = parameters(all[i]), q = parameters(back.cameras[0].calibration.camera.lens);
    ASSERT_EQ(p.size(), q.size());
    for (std::size_t k = 0; k < p.size(); ++k)
      EXPECT_NEAR(p[k], q[k], 1e-12 * std::max(1.0, std::abs(p[k])));
    ASSERT_EQ(back.poses.size(), 2U);
    for (const ImagePose& pose : back.poses) {
      const ImagePose& expected = file.poses[pose.image == "01.png"];
      EXPECT_LT(minus(pose.camera_from_world, expected.camera_from_world).norm(), 1e-12);
    }
  }
}

// COLMAP 3.8 does not know rigs: their files beside its own do no harm.
TEST_F(PeerReadersTest, ColmapReadsBesideTheFilesOfARig) {
  if (!output("colmap help")) GTEST_SKIP() << "colmap is not installed";
  CameraFile file = camera_file(lenses()[1]);
  file.cameras.push_back(camera_file(lenses()[3]).cameras[0]);
  file.cameras[0].camera_from_rig = Pose();
  file.poses[1].camera = 1;
  write_camera_file(path("rig"), file, "colmap");
  EXPECT_TRUE(fs::exists(folder_ / "rig/rigs.txt"));
  fs::create_directories(folder_ / "out");
  ASSERT_TRUE(output("QT_QPA_PLATFORM=offscreen colmap model_converter --input_path " +
                     path("rig") + " --output_path " + path("out") + " --output_type TXT"));
  const CameraFile back = read_camera_file(folder_ / "out");
  ASSERT_EQ(back.cameras.size(), 2U);
  ASSERT_EQ(back.poses.size(), 2U);
  for (const ImagePose& pose : back.poses) {
    const ImagePose& expected = file.poses[pose.image == "01.png"];
    EXPECT_EQ(back.cameras[pose.camera].name, std::to_string(expected.camera + 1));
    EXPECT_LT(minus(pose.camera_from_world, expected.camera_from_world).norm(), 1e-12);
  }
}

TEST_F(PeerReadersTest, RosParsesCameraInfo) {
  if (!has_module("camera_calibration_parsers"))
    GTEST_SKIP() << "python3-camera-calibration-parsers is not installed";
  std::vector<Lens> all = lenses();
  all.emplace_back(Fisheye({300.0, 301, 320, 240.5, -0.01 / 3, 0.02, 5e-4, -3e-5}));
  for (const Lens& lens : all) {
    write_camera_file(folder_ / "info.yaml", camera_file(lens), "ros");
    const std::vector<double> values = python(
        "from camera_calibration_parsers import readCalibration\nname, c = readCalibration('" +
        path("info.yaml") +
        "')\nprint(c.width, c.height)\nfor v in list(c.K) + list(c.D): print(repr(v))\n");
    const auto p = parameters(lens);
    ASSERT_GE(values.size(), 11U + 4);
    EXPECT_EQ(values[0], 640);
    EXPECT_EQ(values[1], 480);
    EXPECT_EQ(values[2], p[0]);
    EXPECT_EQ(values[4], p[2]);
    for (std::size_t i = 11; i < values.size(); ++i) EXPECT_EQ(values[i], p[i - 7]) << i;
  }
}

// PyYAML reads YAML 1.1, in which 1e-05 is a text: Kalibr's and ROS' tools use it.
TEST_F(PeerReadersTest, PyYamlReadsNumbers) {
  if (!has_module("yaml")) GTEST_SKIP() << "python3-yaml is not installed";
  const CameraFile file = camera_file(lenses()[1]);
  write_camera_file(folder_ / "camchain.yaml", file, "kalibr");
  const std::vector<double> values = python(
      "import yaml\nc = yaml.safe_load(open('" + path("camchain.yaml") +
      "'))['cam0']\nfor v in c['intrinsics'] + c['distortion_coeffs']: print(repr(float(v) if "
      "isinstance(v, float) else None))\n");
  const auto p = parameters(lenses()[1]);
  EXPECT_EQ(values, std::vector<double>(p.begin(), p.begin() + 8));
}

}  // namespace
}  // namespace tagcal
