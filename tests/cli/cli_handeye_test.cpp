// tagcal handeye, from outside.
#include <sstream>

#include "cli_handeye_fixture.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/random.hpp"

namespace tagcal::tools {
namespace {

TEST_F(CliHandeye, FindsTheCameraInTheHand) {
  const Outcome out = handeye("--json --out " + path("handeye.yaml") + " --ros " + path("tf.yaml"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(out.out);
  EXPECT_EQ(answer["status"], "ok");
  const Json& t = answer["mount_from_camera"]["translation_m"];
  const double truth[] = {0.045, -0.062, 0.085};  // data-synthetic/golden/README.md
  for (int i = 0; i < 3; ++i) {
    const double sigma = std::sqrt(answer["covariance"][3 + i][3 + i].get<double>());
    EXPECT_NEAR(t[i].get<double>(), truth[i], 4 * sigma);
    EXPECT_LT(sigma, 2e-3);
  }
  EXPECT_NEAR(answer["robot_sigma_m"].get<double>(), 0.5e-3, 0.3e-3);
  EXPECT_TRUE(answer.contains("next"));
  const std::string yaml = slurp(root() / "handeye.yaml"), ros = slurp(root() / "tf.yaml");
  EXPECT_HAS(yaml, "mount_from_camera: {rotation: [");
  EXPECT_HAS(ros, "frame_id: hand");
}

TEST_F(CliHandeye, PrintsWhatAUserNeeds) {
  const Outcome out = handeye();
  ASSERT_EQ(out.exit_code, 0) << out.err;
  for (const char* const part : {"OK", "camera in the hand", "board in the base", "robot ", "axes ",
                                 "worst ", "next: move the hand to"})
    EXPECT_HAS(out.out, part);
}

// A lens that changed moves the camera on the hand, and is no error of the board.
TEST_F(CliHandeye, WarnsOfACameraThatThePicturesContradict) {
  const std::string camera = path("camera.yaml"), changed = path("changed.yaml");
  ASSERT_EQ(run("calibrate " + kDesk + " --model opencv5 --out " + camera).exit_code, 0);
  spill(root() / "robot.csv", robot_);
  const std::string text = slurp(camera);
  std::smatch f;
  ASSERT_TRUE(std::regex_search(text, f, std::regex(R"(data: \[ ([0-9.]+))")));
  spill(changed, replaced(text, f.str(), "data: [ " + std::to_string(1.01 * std::stod(f[1]))));
  const auto findings = [&](const std::string& file) {
    return run("handeye " + kDesk + " --camera " + file + " --robot " + path("robot.csv") +
               " --mount hand --json")
        .out;
  };
  EXPECT_LACKS(findings(camera), "camera_changed");
  EXPECT_HAS(findings(changed), "camera_changed");
}

TEST_F(CliHandeye, NamesTheReadingThatFits) {
  robot_ = replaced(robot_, "x_m,y_m,z_m", "x_mm,y_mm,z_mm");
  const Outcome out = handeye("--out " + path("no.yaml"));
  EXPECT_EQ(out.exit_code, 3);
  EXPECT_HAS(out.out, "the lengths are metres,");
  EXPECT_FALSE(fs::exists(root() / "no.yaml"));
}

// The desk's poses as another robot, or a slip, writes them: by one change the file can have.
TEST_F(CliHandeye, NamesOnlyWhatTheFileCanHave) {
  std::vector<std::string> images;
  std::vector<Pose> poses;
  std::istringstream lines(robot_);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream words(line);
    std::string image;
    double x, y, z, w, i, j, k;
    words >> image >> x >> y >> z >> w >> i >> j >> k;
    images.push_back(image);
    poses.emplace_back(Eigen::Quaterniond(w, i, j, k), Eigen::Vector3d(x, y, z));
  }
  const auto says = [&](const std::string& columns, double lengths, const auto& numbers,
                        const std::string& change) {
    robot_ = "image,x_m,y_m,z_m," + columns + "\n";
    for (std::size_t n = 0; n < poses.size(); ++n) {
      robot_ += images[n];
      for (const double t : poses[n].translation()) robot_ += "," + std::to_string(lengths * t);
      for (const double r : numbers(poses[n].rotation())) robot_ += "," + std::to_string(r);
      robot_ += "\n";
    }
    const Outcome out = handeye("--json");
    EXPECT_EQ(out.exit_code, 3) << change;
    EXPECT_EQ(Json::parse(out.out)["reading"]["change"], change);
  };
  const auto vector = [](const Eigen::Quaterniond& q) { return log_rotation(q); };
  const auto angles = [](const Eigen::Quaterniond& q) {
    const RollPitchYaw a = roll_pitch_yaw(q);
    return Eigen::Vector3d(a.roll_rad, a.pitch_rad, a.yaw_rad);
  };
  const std::string of_vector = "rx_rad,ry_rad,rz_rad", of_angles = "roll_rad,pitch_rad,yaw_rad";
  says(of_vector, 100, vector, "the lengths are centimetres, not metres");
  says(of_angles, 1 / 0.0254, angles, "the lengths are inches, not metres");
  says(of_angles, 1, vector, "roll, pitch and yaw are a rotation vector");
  says(of_vector, 1, angles, "the rotation vectors are roll, pitch and yaw");
  says(
      of_angles, 1,
      [&](const Eigen::Quaterniond& q) { return Eigen::Vector3d(angles(q).reverse()); },
      "the angles are in the order yaw, pitch, roll");
}

TEST_F(CliHandeyePoses, FindTheCameraInTheHand) {
  const Outcome out = handeye_of(poses_, "--json --out " + path("handeye.yaml"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(out.out), by_pictures = Json::parse(handeye("--json").out);
  EXPECT_EQ(answer["views"].size(), 12u);
  EXPECT_TRUE(answer["rms_px"].is_null());
  EXPECT_EQ(answer["num_corners"], 0);
  for (int i = 0; i < 6; ++i) {
    const double sigma = std::sqrt(by_pictures["covariance"][i][i].get<double>());
    EXPECT_NEAR(std::sqrt(answer["covariance"][i][i].get<double>()), sigma, 0.05 * sigma);
  }
  const Json &t = answer["mount_from_camera"]["translation_m"],
             &same = by_pictures["mount_from_camera"]["translation_m"];
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(t[i].get<double>(), same[i].get<double>(), 0.1e-3);
  EXPECT_HAS(slurp(root() / "handeye.yaml"), "mount_from_camera");
  EXPECT_LACKS(handeye_of(poses_).out, "px");
}

TEST_F(CliHandeyePoses, TheirTimesAreThoseOfTheRobot) {
  const Json by_name = Json::parse(handeye_of(poses_, "--json").out);
  // The same by times: that of picture k is k seconds.
  robot_.replace(0, std::string("image").size(), "time_s");
  robot_ = std::regex_replace(robot_, std::regex("\n0*(\\d+)\\.png"), "\n$1");
  const Outcome without = handeye_of(poses_, "--json");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_HAS(without.err, "give the pictures' times with --times");
  Json timed = Json::parse(poses_);
  for (Json& view : timed["views"]) view["time_s"] = std::stod(view["image"].get<std::string>());
  const Outcome out = handeye_of(timed.dump(), "--json");
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const Json answer = Json::parse(out.out);
  const Vector6d step =
      minus(pose_in(answer["mount_from_camera"]), pose_in(by_name["mount_from_camera"]));
  for (int i = 0; i < 6; ++i)
    EXPECT_LT(std::abs(step[i]), 2 * std::sqrt(by_name["covariance"][i][i].get<double>())) << i;
}

TEST_F(CliHandeyePoses, RefuseBadInputInOneLine) {
  const auto refuses = [&](const std::string& poses, const std::string& part,
                           const std::string& more = "") {
    const Outcome out = handeye_of(poses, more);
    EXPECT_EQ(out.exit_code, 2) << part << out.out;
    EXPECT_HAS(out.err, part);
    EXPECT_EQ(std::ranges::count(out.err, '\n'), 1) << out.err;
  };
  refuses(poses_, "--camera: ", "--camera " + kDesk + "/truth.yaml");
  refuses(poses_, "--pair: ", "--pair index");
  refuses("{\"cameras\": []}", "views: the key is missing");
  refuses(replaced(poses_, "003.png", "002.png"), "two pictures have the name 002");
  refuses(replaced(poses_, "003.png", "103.png"), "003.png is no picture of");
  Json without = Json::parse(poses_);
  without["views"][4].erase("noise_covariance");  // as other programs write it
  without["views"][4]["covariance"] = nullptr;
  refuses(without.dump(), "views[4].covariance: is missing");
  without["views"][4]["covariance"] = std::vector(6, std::vector(6, 0.0));
  refuses(without.dump(), "covariance positive definite");
  robot_ = robot_.substr(0, robot_.rfind("011.png"));
  refuses(poses_, "has no pose of the picture 011.png");
}

// A rig of two cameras on a hand, and a robot with errors of 0.3 mm and 0.3 mrad.
TEST_F(CliHandeye, FindsARigInTheHand) {
  spill(root() / "scene.yaml",
        "rig:\n"
        "  cameras:\n"
        "    - {name: left, camera: {image_size: [480, 360], model: pinhole, f: 400}}\n"
        "    - name: right\n"
        "      camera: {image_size: [480, 360], model: pinhole, f: 400}\n"
        "      rig_from_camera: {translation_m: [0.08, 0, 0]}\n"
        "boards:\n"
        "  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: "
        "0.3}\n"
        "    world_from_board: {translation_m: [-0.2, -0.2, 0]}\n"
        "path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.9, min_elevation_deg: 50}\n"
        "jitter: {target_m: 0.05, roll_deg: 180}\n"
        "views: 12\n");
  ASSERT_EQ(run("render " + path("scene.yaml") + " --out " + path("rig")).exit_code, 0);
  ASSERT_EQ(run("rig " + path("rig") + " --out " + path("rig.yaml")).exit_code, 0);
  const Json seen =
      Json::parse(run("pose " + path("rig") + " --rig " + path("rig.yaml") + " --json").out);
  const Pose hand_from_rig(exp_rotation({0.3, -0.2, 0.9}), {0.03, -0.05, 0.1});
  const Pose base_from_board(exp_rotation({0.1, 0.4, -1}), {0.7, 0.2, 0.1});
  Random random(7);
  std::string robot = "image,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (const Json& view : seen["views"]) {
    Vector6d error;
    for (double& e : error) e = 0.3e-3 * random.normal();
    const Pose rig_from_board = pose_in(view["camera_from_board"]);
    const Pose hand = retract(base_from_board * (hand_from_rig * rig_from_board).inverse(), error);
    robot += view["image"].get<std::string>() + row_of(hand);
  }
  spill(root() / "robot.csv", robot);
  const Outcome out = run("handeye " + path("rig") + " --camera " + path("rig.yaml") + " --robot " +
                          path("robot.csv") + " --mount hand --json --report " + path("page.html"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(out.out);
  EXPECT_EQ(answer["reference"], "left");
  const Json page = data_of_page(root() / "page.html");
  EXPECT_EQ(page["places"][0]["title"], "left (the rig's reference) in the hand");
  EXPECT_EQ(page["image_size"], Json({480, 360}));
  EXPECT_EQ(page["boards"].size(), 1u);
  EXPECT_EQ(page["poses"].size(), 12u);
  EXPECT_TRUE(page["rms_px"].is_null());
  EXPECT_LT(minus(pose_in(answer["holder_from_board"]), base_from_board).tail<3>().norm(), 2e-3);
  const Vector6d step = minus(pose_in(answer["mount_from_camera"]), hand_from_rig);
  for (int i = 0; i < 6; ++i)
    EXPECT_LT(std::abs(step[i]), 4 * std::sqrt(answer["covariance"][i][i].get<double>())) << i;
  EXPECT_LT(step.tail<3>().norm(), 1e-3);
  EXPECT_LACKS(out.out, "lens_without_covariance");
}

TEST_F(CliHandeye, NoInputIsReplaced) {
  spill(root() / "robot.csv", robot_);
  fs::copy(root() / "set/observations_exact.csv", root() / "corners");
  const std::string command = "handeye " + path("set") + " --camera " + path("set/truth.yaml") +
                              " --robot " + path("robot.csv") + " --mount hand --observations " +
                              path("corners");
  for (const char* const file : {"set/dataset.yaml", "set/target.yaml", "corners"})
    for (const char* const option : {" --out ", " --ros "}) {
      const std::string before = slurp(root() / file);
      expect_bad_input(command + option + path(file), {"is an input, which would be replaced"});
      EXPECT_EQ(slurp(root() / file), before);
    }
}

TEST_F(CliHandeye, NeedsACameraForPictures) {
  spill(root() / "robot.csv", robot_);
  const Outcome out = run("handeye " + kDesk + " --robot " + path("robot.csv") + " --mount hand");
  EXPECT_EQ(out.exit_code, 2);
  EXPECT_HAS(out.err, "--camera: is missing");
}

TEST_F(CliHandeye, RefusesBadInputInOneLine) {
  const auto refuses = [&](const std::string& part, const std::string& more = "") {
    const Outcome out = handeye(more);
    EXPECT_EQ(out.exit_code, 2) << part << out.out;
    EXPECT_HAS(out.err, part);
    EXPECT_EQ(std::ranges::count(out.err, '\n'), 1) << out.err;
  };
  const std::string good = robot_;
  robot_ = good.substr(0, good.rfind("011.png"));
  refuses("has no pose of the picture 011.png");
  robot_ = replaced(good, "003.png", "002.png");
  refuses("002.png has a pose already");
  robot_ = replaced(good, "x_m", "x");
  refuses("column x: has no unit");
  robot_ = good;
  refuses("has no times", "--time-offset find");
  robot_ = "x_m,y_m,z_m,qw,qx,qy,qz\n0,0,0,1,0,0,0\n";
  refuses("has 1 poses without names");
}

}  // namespace
}  // namespace tagcal::tools
