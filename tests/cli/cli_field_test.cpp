// Tags without a target, and a robot on a field of WPILib.
#include <sstream>

#include "cli_pose_fixture.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::tools {
namespace {

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  return rows;
}

class Field : public PoseCli {
 protected:
  // A field with three tags on a wall, seen by a camera at (3, 5.2, 0.9) that looks towards the
  // wall and a little upwards.
  static std::string field_set() {
    if (fs::exists(root() / "field")) return path("field");
    const auto tag = [](int id, double y) {
      return "{\"ID\": " + std::to_string(id) +
             ", \"pose\": {\"translation\": {\"x\": 0.0, \"y\": " + std::to_string(y) +
             ", \"z\": 1.4}, \"rotation\": {\"quaternion\": {\"W\": 1.0, \"X\": 0.0, \"Y\": 0.0, "
             "\"Z\": 0.0}}}}";
    };
    spill(root() / "field.json",
          "{\n  \"tags\": [\n    " + tag(3, 5.0) + ",\n    " + tag(4, 5.5) + ",\n    " +
              tag(8, 6.0) + "\n  ],\n  \"field\": {\"length\": 16.54, \"width\": 8.21}\n}\n");
    spill(root() / "field-scene.yaml",
          "camera: {image_size: [960, 720], model: f, f: 800}\n"
          "boards:\n  - file: field.json\n"
          "path: {type: line, target_m: [0, 5.5, 1.4], from_m: [3, 5.2, 0.9], "
          "to_m: [2.5, 6.1, 0.9]}\n"
          "sensor: {blur_px: 0.7, noise_levels: 1}\nviews: 2\n");
    good_run("render " + path("field-scene.yaml") + " --out " + path("field"));
    spill(root() / "field-camera.yaml",
          "image_width: 960\nimage_height: 720\ncamera_matrix: {rows: 3, cols: 3, dt: d, "
          "data: [800, 0, 479.5, 0, 800, 359.5, 0, 0, 1]}\n"
          "distortion_coefficients: {rows: 1, cols: 4, dt: d, data: [0, 0, 0, 0]}\n");
    return path("field");
  }
  static std::string pictures() {
    return field_set() + "/images/000.png " + path("field/images/001.png");
  }
};

TEST_F(Field, TheCameraIsWhereTheRobotIs) {
  const std::string arguments = "pose --target " + path("field.json") + " " + pictures() +
                                " --camera " + path("field-camera.yaml") +
                                " --camera-error-px 0.01";
  const Outcome outcome = good_run(arguments + " --json");
  EXPECT_HAS(outcome.err, "0.1651 m is taken");
  const Json views = Json::parse(outcome.out)["views"];
  const Truth truth = read_truth(root() / "field/truth.yaml");
  ASSERT_EQ(views.size(), 2u);
  for (const Json& view : views) {
    const Pose robot = truth.camera_from_world.at(view["image"]);
    const Json& camera = view["camera_in_target"];
    const Eigen::Vector3d eye = robot.inverse().translation();
    const RollPitchYaw angles = camera_angles(robot);
    constexpr double kDegrees = 180 / std::numbers::pi;
    for (int i = 0; i < 3; ++i) {
      const double sigma = camera["sigma_position_m"][i];
      EXPECT_NEAR(camera["position_m"][i], eye[i], std::max(5 * sigma, 1e-3));
      EXPECT_LT(sigma, 0.02);
    }
    EXPECT_NEAR(camera["azimuth_deg"], kDegrees * angles.yaw_rad,
                5 * camera["sigma_azimuth_deg"].get<double>());
    EXPECT_NEAR(camera["elevation_deg"], -kDegrees * angles.pitch_rad,
                5 * camera["sigma_elevation_deg"].get<double>());
    EXPECT_NEAR(camera["roll_deg"], 0, 5 * camera["sigma_roll_deg"].get<double>());
  }
  // A size that is stated needs no warning.
  const Outcome stated = run(arguments + " --tag-size 0.1651 --json");
  EXPECT_EQ(stated.out, outcome.out);
  EXPECT_LACKS(stated.err, "0.1651 m is taken");
  const Outcome text = run(arguments);
  EXPECT_HAS(text.out, "camera at");
  EXPECT_HAS(text.out, "az., el., roll");
}

TEST_F(Field, TagSizesBelongToFieldLayouts) {
  expect_bad_input("pose --target " + path("set/target.yaml") + " --tag-size 0.1 " +
                       path("set/images/000.png") + " --unknown-focal",
                   {"states the size of its tags"});
  expect_bad_input("detect " + path("set") + " --tag-size 0.1", {"--tag-size", "--target"});
}

TEST_F(Field, TagsAreDetectedWithoutATarget) {
  const Outcome outcome = good_run("detect --family tag36h11 " + pictures());
  EXPECT_HAS(outcome.err, "OK: 2 of 2 pictures show a tag of tag36h11: 6 tags");
  const auto rows = rows_of(outcome.out);
  ASSERT_EQ(rows.size(), 1u + 2 * 3 * 4);
  EXPECT_EQ(rows[0].back(), "instance");
  EXPECT_EQ(rows[0].size(), 9u);
  EXPECT_EQ(rows[1][1], "3");
  // The same corners as with the target, which the data set takes as observations.
  const Outcome with = run("detect --target " + path("field.json") + " " + pictures());
  const auto known = rows_of(with.out);
  ASSERT_EQ(known.size(), rows.size());
  for (std::size_t i = 1; i < rows.size(); ++i)
    EXPECT_NEAR(std::stod(rows[i][3]), std::stod(known[i][3]), 0.01);
  spill(root() / "any.csv", outcome.out);
  good_run("pose " + path("field") + " --observations " + path("any.csv") + " --camera " +
           path("field-camera.yaml"));
}

TEST_F(Field, ARepeatedIdIsCounted) {
  field_set();
  const Image8 once = read_image(root() / "field/images/000.png");
  Image8 twice({2 * once.width(), once.height()});
  for (int y = 0; y < once.height(); ++y)
    for (int x = 0; x < twice.width(); ++x) twice(x, y) = once(x % once.width(), y);
  write_png(root() / "twice.png", twice);
  good_run("detect --family tag36h11 " + path("twice.png") + " --draw " + path("twice-drawn") +
           " --out " + path("twice.csv"));
  EXPECT_TRUE(fs::exists(root() / "twice-drawn/twice.png"));
  const auto rows = rows_of(slurp(root() / "twice.csv"));
  ASSERT_EQ(rows.size(), 1u + 6 * 4);
  EXPECT_EQ(rows[1].back(), "0");
  EXPECT_EQ(rows[5].back(), "1");
  EXPECT_EQ(rows[5][1], "3");
}

TEST_F(Field, MistakesWithoutATarget) {
  const std::string picture = " " + path("set/images/000.png");
  expect_bad_input("detect --family tag36h12" + picture,
                   {"family: must be one of", "tagCircle49h12"});
  expect_bad_input("detect --family tag36h11 --border-bits 3" + picture, {"border_bits"});
  expect_bad_input("detect --family tag36h11 --target " + path("set/target.yaml") + picture,
                   {"--family, --target"});
  expect_bad_input("detect --family tag36h11 --explain" + picture, {"--explain"});
  expect_bad_input("detect --border-bits 1 " + path("set"), {"--border-bits"});
  const Outcome none = good_run("detect --family tagStandard52h13" + picture);
  EXPECT_HAS(none.err, "NOTHING FOUND: a tag of tagStandard52h13");
}

}  // namespace
}  // namespace tagcal::tools
