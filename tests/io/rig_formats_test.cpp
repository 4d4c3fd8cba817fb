// Rigs in the files of other programs: written, read again, and refused where they are wrong.

#include <gtest/gtest.h>

#include <sstream>

#include "rig_formats_fixture.hpp"
#include "tagcal/io/rig_calibration_file.hpp"

namespace tagcal {
namespace {

using Eigen::Vector3d;

void expect_same_rig(const CameraFile& a, const CameraFile& b, bool same_frame) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    ASSERT_TRUE(b.cameras[i].camera_from_rig);
    EXPECT_LT(minus(from_first(a, i), from_first(b, i)).norm(), 1e-12);
    if (same_frame) {
      EXPECT_LT(minus(*a.cameras[i].camera_from_rig, *b.cameras[i].camera_from_rig).norm(), 1e-12);
    }
    const auto p = parameters(a.cameras[i].calibration.camera.lens);
    const auto q = parameters(b.cameras[i].calibration.camera.lens);
    ASSERT_EQ(p.size(), q.size());
    for (std::size_t k = 0; k < p.size(); ++k)
      EXPECT_NEAR(p[k], q[k], 1e-12 * std::max(1.0, std::abs(p[k])));
  }
}

struct RigFormat {
  const char* format;
  const char* out;
  bool imu = false;    // keeps the frame of an IMU
  bool names = false;  // keeps the names of cameras
  std::size_t most = 4;
  bool sizes = true;
};

const RigFormat kRigFormats[] = {
    {.format = "tagcal", .out = "rig.yaml", .imu = true, .names = true},
    {.format = "kalibr", .out = "chain.yaml", .imu = true},
    {.format = "euroc", .out = "mav0", .imu = true, .names = true},
    {.format = "colmap", .out = "sparse"},
    {.format = "colmap", .out = "rig_config.json", .names = true, .sizes = false},
    {.format = "mrcal", .out = "models", .names = true},
    {.format = "basalt", .out = "calibration.json", .imu = true},
    {.format = "nerfstudio", .out = "transforms.json", .imu = false, .names = true},
    {.format = "opencv", .out = "stereo", .most = 2},
    {.format = "opencv", .out = "stereo.xml", .most = 2},
    {.format = "opencv", .out = "stereo.json", .most = 2}};

TEST_F(RigFormats, RoundTripsAreExact) {
  Random random(11);
  for (int trial = 0; trial < 20; ++trial) {
    for (const RigFormat& f : kRigFormats) {
      SCOPED_TRACE(std::string(f.format) + " " + f.out);
      const bool on_imu = trial % 2 == 1;
      const CameraFile rig =
          random_rig(random, std::min<std::size_t>(2 + trial % 3, f.most), on_imu);
      const fs::path out = folder_ / std::to_string(trial) / f.out;
      fs::create_directories(out.parent_path());
      write_camera_file(out, rig, f.format);
      const CameraFile back = read_camera_file(out);
      expect_same_rig(rig, back, f.imu || !on_imu);
      if (f.imu) {
        EXPECT_TRUE(back.rig_is_imu || !on_imu);
      }
      for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
        if (f.names) {
          EXPECT_EQ(back.cameras[i].name, rig.cameras[i].name);
        }
        EXPECT_EQ(back.cameras[i].calibration.camera.image_size,
                  f.sizes ? ImageSize(640, 480) : ImageSize());
      }
    }
  }
}

TEST_F(RigFormats, KalibrsRelationsAreCarried) {
  Random random(3);
  CameraFile rig = random_rig(random, 3, true);
  rig.cameras[0].overlaps = {1, 2};
  rig.cameras[1].overlaps = std::vector<std::size_t>{};
  rig.cameras[1].imu_time_shift_s = 0.0123;
  write_camera_file(folder_ / "a.yaml", rig, "kalibr");
  write_camera_file(folder_ / "b.yaml", read_camera_file(folder_ / "a.yaml"), "tagcal");
  write_camera_file(folder_ / "c.yaml", read_camera_file(folder_ / "b.yaml"), "kalibr");
  expect_same_rig(rig, read_camera_file(folder_ / "c.yaml"), true);
  const std::string text = read_text(folder_ / "c.yaml");
  EXPECT_HAS(text, "cam_overlaps: [1, 2]\n");
  EXPECT_HAS(text, "timeshift_cam_imu: 0.0123\n");
  // One camera has no others.
  write_camera_file(folder_ / "one.yaml", read_one_camera(path("c.yaml") + ":cam0"), "kalibr");
  EXPECT_HAS(read_text(folder_ / "one.yaml"), "cam_overlaps: []\n");
  write("cut.yaml", replaced(kKalibr, "cam_overlaps: [1]", "cam_overlaps: [2]"));
  EXPECT_EQ(read_camera_file(folder_ / "cut.yaml").notes.front(),
            "dropped: cam0.cam_overlaps, with cameras that are not in the file");
  const CameraFile back = read_camera_file(folder_ / "c.yaml");
  EXPECT_TRUE(back.rig_is_imu);
  EXPECT_FALSE(back.cameras[0].imu_time_shift_s);
  EXPECT_EQ(back.cameras[1].imu_time_shift_s, 0.0123);
  // Places from the IMU that are not those of the chain.
  const std::size_t at = text.find("T_cam_imu: [[", text.find("cam1:")) + 13;
  write("bad.yaml", text.substr(0, at) +
                        "1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, "
                        "1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]\n" +
                        text.substr(text.find("\n  timeshift", at) + 1));
  EXPECT_EQ(error("bad.yaml"),
            "bad.yaml: cam1.T_cam_imu: contradicts T_cn_cnm1: remove the one that is older");
}

// The places of a rig that was moved, or a rig without a reference, are not those of its
// covariance.
TEST_F(RigFormats, TheCovarianceIsThatOfThesePlaces) {
  Random random(5);
  CameraFile rig = random_rig(random, 2);
  rig.rig_covariance = MatrixX::Zero(12, 12);
  rig.rig_covariance.bottomRightCorner(6, 6).setIdentity();
  EXPECT_TRUE(write_camera_file(folder_ / "rig.yaml", rig, "tagcal").empty());
  EXPECT_EQ(read_camera_file(folder_ / "rig.yaml").rig_covariance, rig.rig_covariance);
  rig.cameras[0].camera_from_rig = pose_of_many_sizes(random);
  rig.findings.push_back({"input", Severity::warning, "a doubt"});
  EXPECT_EQ(write_camera_file(folder_ / "rig.yaml", rig, "tagcal").size(), 1U);
  EXPECT_EQ(read_camera_file(folder_ / "rig.yaml").rig_covariance.size(), 0);
  const CameraFile one = read_one_camera(path("rig.yaml") + ":a-left");
  const auto notes = write_camera_file(folder_ / "one.yaml", one, "tagcal");
  EXPECT_EQ(std::ranges::count(notes, "dropped: the warnings of the rig"), 1);
}

// The words of a line between single spaces, as COLMAP splits it.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, ' ');) words.push_back(word);
  return words;
}

TEST_F(RigFormats, ColmapsRigsAndFrames) {
  Random random(9);
  CameraFile rig = random_rig(random, 3);
  std::swap(rig.cameras[0].camera_from_rig, rig.cameras[1].camera_from_rig);
  for (int instant = 0; instant < 4; ++instant) {
    const Pose world(pose_of_many_sizes(random).rotation(), {random.normal(), random.normal(), 1});
    for (std::size_t c = 0; c < 3; ++c) {
      if (instant == 2 && c == 1) continue;
      rig.poses.push_back({std::to_string(c) + "/" + std::to_string(instant) + ".png", c,
                           *rig.cameras[c].camera_from_rig * world});
    }
  }
  write_camera_file(folder_ / "sparse", rig, "colmap");
  std::istringstream rigs(read_text(folder_ / "sparse/rigs.txt"));
  std::string line;
  std::getline(rigs, line);
  EXPECT_TRUE(line.starts_with("#"));
  std::getline(rigs, line);
  const std::vector<std::string> words = words_of(line);
  ASSERT_EQ(words.size(), 4U + 2 * 10);
  EXPECT_EQ(std::vector<std::string>(words.begin(), words.begin() + 7),
            (std::vector<std::string>{"1", "3", "CAMERA", "2", "CAMERA", "1", "1"}));
  std::istringstream frames(read_text(folder_ / "sparse/frames.txt"));
  std::getline(frames, line);
  std::vector<std::string> counts;
  while (std::getline(frames, line)) {
    const std::vector<std::string> frame = words_of(line);
    ASSERT_GT(frame.size(), 9U);
    counts.push_back(frame[9]);
    EXPECT_EQ(frame.size(), 10 + 3 * std::stoul(frame[9]));
  }
  EXPECT_EQ(counts, (std::vector<std::string>{"3", "3", "2", "3"}));
  const CameraFile back = read_camera_file(folder_ / "sparse");
  expect_same_rig(rig, back, true);
  ASSERT_EQ(back.poses.size(), rig.poses.size());
  // Cameras without a rig beside the rig of others would be read with its places.
  for (FileCamera& camera : rig.cameras) camera.camera_from_rig.reset();
  EXPECT_ERROR(write_camera_file(folder_ / "sparse", rig, "colmap"),
               path("sparse/rigs.txt") + ": holds the rig of other cameras: choose another folder");
}

TEST_F(RigFormats, BadFilesAreOneLine) {
  const std::string identity = "[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, ";
  const auto chain = [&](const std::string& last) {
    return replaced(kKalibr, "  - [-0.0004265, -0.0140890, 0.9999007, -0.0008537]\n",
                    "  - [-0.0004265, -0.0140890, " + last + "]\n");
  };
  const std::string sizes = "image_width: 640\nimage_height: 480\n";
  const auto stereo = [&](const std::string& r, const std::string& t) {
    return replaced(kStereoYaml, "M1:", sizes + "M1:") + "R: {rows: 3, cols: 3, data: [" + r +
           "]}\nT: {rows: 3, cols: 1, data: [" + t + "]}\n";
  };
  const auto config = [](const std::string& second) {
    return "[{\"cameras\": [{\"image_prefix\": \"l/\", \"ref_sensor\": true, "
           "\"camera_model_name\": \"PINHOLE\", \"camera_params\": [500, 500, 320, 240]}, "
           "{\"image_prefix\": \"r/\", \"camera_model_name\": \"PINHOLE\", \"camera_params\": "
           "[500, "
           "500, 320, 240], " +
           second + "}]}]";
  };
  const std::string euroc = replaced(kEuroc, "0.0, 0.0, 1.0, 0.01", "0.0, 0.0, -1.0, 0.01");
  const std::vector<std::pair<std::string, std::string>> table = {
      {chain("-0.9999007, 0"),
       ": cam1.T_cn_cnm1: the upper left 3x3 must be a rotation, but |R'R - 1| is 0.0399, det R is "
       "-1"},
      {chain(".nan, 0"), ": cam1.T_cn_cnm1[2][2]: must be a finite number, got .nan"},
      {replaced(kKalibr, "-0.1100738", "-110.0738"),
       ": the camera cam1 is 110.074 m from cam0: places must be in metres, divide those in "
       "millimetres by 1000"},
      {replaced(kKalibr, "cam_overlaps: [1]", "cam_overlaps: [-1]"),
       ": cam0.cam_overlaps[0]: must be a whole number from 0 to 63, got -1"},
      {stereo("1, 0, 0, 0, 1, 0, 0, 0, -1", "-0.1, 0, 0"),
       ": R: it must be a rotation, but |R'R - 1| is 0, det R is -1"},
      {stereo("1, 0, 0, 0, 1, 0, 0, 0, 1", "-60, 0, 0"),
       ": the camera right is 60 m from left: places must be in metres, divide those in "
       "millimetres by 1000"},
      {replaced(stereo("1, 0, 0, 0, 1, 0, 0, 0, 1", "-60, 0, 0"), "T:", "S:"),
       ": T: the key is missing"},
      {euroc, ": T_BS: the upper left 3x3 must be a rotation, but |R'R - 1| is 0, det R is -1"},
      {config("\"cam_from_rig_rotation\": [1, 0, 0, 0.5], \"cam_from_rig_translation\": [0, 0, 0]"),
       ": rigs[0].cameras[1].cam_from_rig_rotation: must be a unit quaternion, got one of length "
       "1.11803"},
      {config("\"cam_from_rig_rotation\": [1, 0, 0, 0]"),
       ": rigs[0].cameras[1].cam_from_rig_translation: the key is missing"},
      {replaced(config("\"x\": 0"), "\"r/\"", "\"rig1/l/\""), ": two cameras have the name l"},
      {replaced(config("\"x\": 0"), "}]}]", "}]}, {}]"),
       ": rigs[1]: is a second rig: tagcal takes one a file, remove the others"}};
  for (const auto& [text, message] : table) {
    write("in", text);
    EXPECT_EQ(error("in"), "in" + message);
  }
}

TEST_F(RigFormats, RigsThatAFormatCannotHoldAreRefused) {
  Random random(2);
  const CameraFile three = random_rig(random, 3);
  const auto refused = [&](const CameraFile& file, const std::string& out,
                           const std::string& format) {
    const auto write = [&] { write_camera_file(folder_ / out, file, format); };
    const std::string message = error_about(path(out) + ": ", write);
    EXPECT_EQ(num_files(), 0U) << out;
    return message;
  };
  EXPECT_EQ(refused(three, "o.yaml", "opencv"),
            "a file of opencv holds one camera, and there are 3: a-left, b-right, c-up (choose by "
            "IN:a-left)");
  EXPECT_EQ(refused(three, "o.cameramodel", "mrcal"),
            "a file of mrcal holds one camera, and there are 3: a-left, b-right, c-up (choose by "
            "IN:a-left)");
  CameraFile pair = random_rig(random, 2);
  pair.cameras[1].calibration.camera.image_size = {800, 600};
  EXPECT_EQ(refused(pair, "o.yaml", "opencv"),
            "a stereo pair of opencv has one image size, and there are 640x480 and 800x600: choose "
            "one camera by IN:a-left");
  pair.cameras[1].calibration.camera = {Fisheye({300, 300, 320, 240, 0, 0, 0, 0}), {640, 480}};
  EXPECT_TRUE(refused(pair, "o.yaml", "opencv").starts_with("a stereo pair of opencv has lenses"));
  EXPECT_TRUE(refused(pair, "o", "mrcal").starts_with("mrcal has no fisheye"));
  pair = random_rig(random, 2);
  pair.cameras[1].name = "../x";
  EXPECT_EQ(refused(pair, "o", "mrcal"), "the camera ../x cannot name its file: rename it in IN");
  pair.cameras[1].name = pair.cameras[0].name;
  EXPECT_EQ(refused(pair, "o", "mrcal"), "two cameras have the name a-left");
  pair.cameras[1].camera_from_rig.reset();
  EXPECT_EQ(refused(pair, "rig_config.json", "colmap"),
            "rig_config.json needs several cameras and their places in a rig");
}

TEST_F(RigFormats, FoldersOfFilesOfOneCamera) {
  Random random(4);
  const CameraFile rig = random_rig(random, 2);
  write_camera_file(folder_ / "models", rig, "mrcal");
  EXPECT_TRUE(fs::exists(folder_ / "models/b-right.cameramodel"));
  EXPECT_EQ(read_one_camera(path("models") + ":b-right").cameras[0].name, "b-right");
  // The file of a third camera would become one of the rig.
  fs::copy(folder_ / "models/a-left.cameramodel", folder_ / "models/z.cameramodel");
  EXPECT_ERROR(write_camera_file(folder_ / "models", rig, "mrcal"),
               path("models/z.cameramodel") +
                   ": would be read as a camera of the rig: choose another folder");
  fs::remove(folder_ / "models/z.cameramodel");
  // Files of single cameras, which all say that they stand in the origin, are no rig.
  CameraFile apart = rig;
  for (FileCamera& camera : apart.cameras) camera.camera_from_rig.reset();
  write_camera_file(folder_ / "models", apart, "mrcal");
  const CameraFile back = read_camera_file(folder_ / "models");
  EXPECT_FALSE(back.cameras[0].camera_from_rig);
  EXPECT_ERROR(
      known_rig(back, "models"),
      "models: has no place of the camera a-left in a rig: name a file that has it, such as "
      "rig.yaml of tagcal rig");
  CameraFile one = apart;
  one.cameras.resize(1);
  one.cameras[0].name.clear();
  EXPECT_ERROR(known_rig(one, "one.yaml"),
               "one.yaml: has no place of its camera in a rig: name a file that has it, such as "
               "rig.yaml of tagcal rig");
  // sensor.yaml of an IMU beside those of cameras.
  write_camera_file(folder_ / "mav0", rig, "euroc");
  fs::create_directories(folder_ / "mav0/imu0");
  write("mav0/imu0/sensor.yaml", "sensor_type: imu\nrate_hz: 200\n");
  EXPECT_EQ(read_camera_file(folder_ / "mav0").cameras.size(), 2U);
  write("mav0/b-right/sensor.yaml", "camera_model: pinhole\nintrinsics: [1]\n");
  EXPECT_EQ(error("mav0"),
            "mav0/b-right/sensor.yaml: intrinsics: must be a list of 4, got a list of 1");
}

}  // namespace
}  // namespace tagcal
