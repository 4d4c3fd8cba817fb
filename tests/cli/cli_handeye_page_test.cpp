// The page of `tagcal handeye --report`.
#include "cli_handeye_fixture.hpp"
#include "tagcal/random.hpp"

namespace tagcal::tools {
namespace {

// "1.2 mm, 0.12 deg, 1.2 sd" of the texts of a pose.
std::string line_of(const Json& texts) {
  return texts[1].get<std::string>() + " mm, " + texts[2].get<std::string>() + " deg, " +
         texts[3].get<std::string>() + " sd";
}

// The pose that a matrix of a page is of, which has seven digits.
void expect_same_pose(const Json& matrix, const Json& pose) {
  const Eigen::Matrix4d expected = pose_in(pose).matrix();
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_NEAR(matrix[row][column].get<double>(), expected(row, column), 1e-6);
}

// One of the robot's poses contradicts the others.
TEST_F(CliHandeye, ThePageHasTheNumbersOfTerminalAndJson) {
  robot_ = replaced(robot_, "004.png,0.", "004.png,0.1");
  const Outcome out = handeye("--out " + path("handeye.yaml") + " --ros " + path("tf.yaml") +
                              " --report " + path("page.html"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(handeye("--json").out), page = data_of_page(root() / "page.html");
  EXPECT_EQ(page["kind"], "handeye");
  EXPECT_EQ(page["verdict"]["level"], "warnings");
  EXPECT_EQ(page["findings"], answer["findings"]);
  const std::string terminal = unwrapped(out.out);
  std::vector<std::string> texts = {page["verdict"]["sentence"], page["next"],
                                    page["robot"]["text"], page["robot"]["axes"]};
  for (const Json& place : page["places"]) {
    texts.push_back(place["title"]);
    for (const Json& text : place["texts"]) texts.push_back(text);
  }
  EXPECT_EQ(texts.size(), 4 + 2 * 7u);
  for (const std::string& text : texts) EXPECT_HAS(terminal, text);
  for (const char* const key : {"mount_from_camera", "holder_from_board"})
    expect_same_pose(page[key], answer[key]);
  expect_same_pose(page["next_hand"], answer["next"]["base_from_hand"]);
  for (const char* const key : {"sigma_m", "sigma_rad"}) {
    const double sigma = answer[std::string("robot_") + key];
    EXPECT_NEAR(page["robot"][key].get<double>(), sigma, 1e-5 * sigma);
  }
  EXPECT_NEAR(page["rms_px"].get<double>(), answer["rms_px"].get<double>(), 1e-6);

  ASSERT_EQ(page["poses"].size(), 12u);
  EXPECT_EQ(answer["rejected"], Json({"004.png"}));
  EXPECT_EQ(page["poses"][4]["state"], "rejected");
  EXPECT_FALSE(page["poses"][4].contains("error_m"));
  EXPECT_EQ(answer["views"].size(), 11u);
  for (const Json& view : answer["views"]) {
    const Json& pose = *std::ranges::find_if(
        page["poses"], [&](const Json& p) { return p["image"] == view["image"]; });
    EXPECT_EQ(pose["state"], "used");
    expect_same_pose(pose["base_from_hand"], view["base_from_hand"]);
    for (const char* const key : {"error_m", "error_rad", "score", "rms_px"})
      EXPECT_NEAR(pose[key].get<double>(), view[key].get<double>(), 1e-5 * view[key].get<double>());
    const std::string line = line_of(pose["texts"]);
    if (view["score"].get<double>() > 1.15) {  // the worst
      EXPECT_HAS(terminal, line);
    }
  }

  // What can be copied is what the files have.
  ASSERT_EQ(page["formats"].size(), 3u);
  EXPECT_EQ(page["formats"][1]["text"], slurp(root() / "tf.yaml"));
  EXPECT_EQ(page["formats"][2]["text"], slurp(root() / "handeye.yaml"));
  const std::string command = page["formats"][0]["text"];
  EXPECT_TRUE(command.starts_with("ros2 run tf2_ros")) << command;
  EXPECT_EQ(slurp(root() / "tf.yaml").find(command), 2u);
  EXPECT_EQ(page["boards"].size(), 1u);
  EXPECT_HAS(page["inputs"].dump(), "12 pictures, 12 with the board, 11 used, 1 rejected");
}

// A refusal has the robot's poses as they were given, and nothing of camera and board.
void expect_refusal(const Json& page, std::size_t num_poses) {
  EXPECT_EQ(page["verdict"]["level"], "no_answer");
  EXPECT_EQ(page["findings"][0]["severity"], "error");
  for (const char* const key : {"mount_from_camera", "holder_from_board", "known_to"})
    EXPECT_FALSE(page.contains(key)) << key;
  EXPECT_TRUE(page["formats"].empty());
  ASSERT_EQ(page["poses"].size(), num_poses);
  for (const Json& pose : page["poses"]) EXPECT_FALSE(pose["base_from_hand"].is_null());
}

TEST_F(CliHandeye, ThePageOfARefusalHasWhatIsGiven) {
  robot_ = replaced(robot_, "x_m,y_m,z_m", "x_mm,y_mm,z_mm");
  const Outcome out = handeye("--report " + path("page.html"));
  EXPECT_EQ(out.exit_code, 3) << out.err;
  const Json page = data_of_page(root() / "page.html");
  EXPECT_EQ(page["status"], "wrong_direction");
  expect_refusal(page, 12);
  EXPECT_FALSE(page.contains("robot"));
  EXPECT_TRUE(page["places"].empty());
  EXPECT_TRUE(page["next"].is_null());
  for (const Json& pose : page["poses"]) EXPECT_EQ(pose["state"], "given");
}

// The robot's poses are a path, which has no velocity at its first and last picture.
TEST_F(CliHandeye, ThePageOfAPathHasTheClocks) {
  std::string times = "image,time_s\n";
  for (int i = 0; i < 12; ++i) {
    const std::string name = (i < 10 ? "00" : "0") + std::to_string(i) + ".png";
    robot_ = replaced(robot_, name, std::to_string(10 * i));
    times += name + "," + std::to_string(10 * i) + "\n";
  }
  robot_ = replaced(robot_, "image", "time_s");
  spill(root() / "times.csv", times);
  const std::string more = "--times " + path("times.csv");
  const Outcome out = handeye(more + " --report " + path("page.html"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json page = data_of_page(root() / "page.html"),
             answer = Json::parse(handeye(more + " --json").out);
  const std::string clocks = page["robot"]["clocks"];
  EXPECT_HAS(unwrapped(out.out), "clocks " + clocks);
  const Json& offset = answer["time_offset"];
  EXPECT_NEAR(std::stod(clocks), 1e3 * offset["offset_s"].get<double>(),
              1e2 * offset["sigma_s"].get<double>());
  EXPECT_EQ(answer["unusable"], Json({"000.png", "011.png"}));
  for (const std::size_t i : {0u, 11u}) EXPECT_EQ(page["poses"][i]["state"], "unusable");
  EXPECT_EQ(page["poses"][1]["state"], "used");
  EXPECT_HAS(page["inputs"].dump(), "10 used, 2 without a pose");
}

TEST_F(CliHandeye, APageThatCannotBeWrittenIsRefusedBeforeAnyWork) {
  spill(root() / "robot.csv", robot_);
  const std::string command = "handeye " + kDesk + " --camera " + kDesk + "/truth.yaml --robot " +
                              path("robot.csv") + " --mount hand --report ";
  expect_bad_input(command + path("none/page.html"), {"none/page.html", "cannot be written"});
  expect_bad_input(command + path("page.txt"), {"must end in .html"});
  expect_bad_input(command + path("one.html") + " --out " + path("one.html"),
                   {"one.html: has the name of another kind of file"});
  fs::copy(root() / "robot.csv", root() / "robot.html");
  expect_bad_input(command + path("robot.html"), {"robot.html", "is no HTML page"});
  expect_bad_input("handeye " + kDesk + " --camera " + kDesk + "/truth.yaml --robot " +
                       path("robot.html") + " --mount hand --report " + path("robot.html"),
                   {"robot.html: is an input"});
}

TEST_F(CliHandeyePoses, HaveAPageWithoutPixels) {
  ASSERT_EQ(handeye_of(poses_, "--report " + path("page.html")).exit_code, 0);
  const Json page = data_of_page(root() / "page.html");
  EXPECT_EQ(page["inputs"][0], Json({"poses", path("poses.json")}));
  EXPECT_TRUE(page["boards"].empty());
  EXPECT_FALSE(page.contains("image_size"));
  for (const Json& pose : page["poses"]) {
    EXPECT_TRUE(pose["rms_px"].is_null());
    EXPECT_EQ(pose["texts"][0], "");
    EXPECT_GT(pose["error_m"].get<double>(), 0);
  }
}

// A robot with 0.3 mm and 0.3 mrad of errors, whose hand turns about one axis by up to `turn_rad`.
TEST_F(CliHandeyePoses, ThePageOfParallelAxesHasWhatHolds) {
  const Pose hand_from_camera(exp_rotation({0.1, 0.2, 1.5}), {0.05, -0.06, 0.08});
  const Pose base_from_board(exp_rotation({0, 0, 0.4}), {0.7, 0.1, 0});
  for (const auto& [turn_rad, status] :
       {std::pair(0.9, "rotation_axes_parallel"), std::pair(0.0, "no_rotation")}) {
    Random random(3);
    Json poses = {{"views", Json::array()}};
    robot_ = "image,x_m,y_m,z_m,qw,qx,qy,qz\n";
    for (int i = 0; i < 14; ++i) {
      const double s = (i - 6.5) / 6.5;
      const Pose hand =
          Pose(exp_rotation({3, 0.1, 0}), {0.6, 0, 0.7}) *
          Pose(exp_rotation({0, 0, turn_rad * s}),
               {0.1 * std::cos(7 * s), 0.1 * std::sin(5 * s), 0.05 * std::sin(3 * s)});
      Vector6d error;
      for (double& e : error) e = 0.3e-3 * random.normal();
      const std::string name = std::to_string(100 + i) + ".png";
      robot_ += name + row_of(retract(hand, error));
      const Pose seen = (hand * hand_from_camera).inverse() * base_from_board;
      const Eigen::Quaterniond q = seen.rotation();
      const Eigen::Vector3d t = seen.translation();
      std::vector<std::vector<double>> covariance(6, std::vector<double>(6, 0));
      for (std::size_t k = 0; k < 6; ++k) covariance[k][k] = 1e-8;
      poses["views"].push_back({{"image", name},
                                {"status", "ok"},
                                {"covariance", covariance},
                                {"camera_from_board",
                                 {{"rotation", {q.w(), q.x(), q.y(), q.z()}},
                                  {"translation_m", {t.x(), t.y(), t.z()}}}}});
    }
    const Outcome out = handeye_of(poses.dump(), "--report " + path("page.html"));
    ASSERT_EQ(out.exit_code, 3) << out.err << out.out;
    const Json page = data_of_page(root() / "page.html");
    EXPECT_EQ(page["status"], status);
    expect_refusal(page, 14);
    ASSERT_EQ(page["places"].size(), 2u);
    for (const Json& place : page["places"])
      for (const Json& text : place["texts"])
        EXPECT_HAS(unwrapped(out.out), text.get<std::string>());
    for (const Json& text : {page["robot"]["text"], page["next"]})
      EXPECT_HAS(unwrapped(out.out), text.get<std::string>());
    EXPECT_TRUE(page.contains("next_hand"));
    EXPECT_EQ(page["poses"][0]["state"], "used");
  }
}

}  // namespace
}  // namespace tagcal::tools
