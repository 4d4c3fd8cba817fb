// tagcal handeye, from outside.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/random.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kDesk = TAGCAL_SOURCE_DIR "/data-synthetic/golden/desk";

class CliHandeye : public Cli {
 protected:
  CliHandeye() : robot_(slurp(kDesk + "/robot.csv")) {}

  Outcome handeye(const std::string& more = "") {
    spill(root() / "robot.csv", robot_);
    return run("handeye " + kDesk + " --camera " + kDesk + "/truth.yaml --robot " +
               path("robot.csv") + " --mount hand " + more);
  }

  std::string robot_;
};

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
  EXPECT_NE(yaml.find("mount_from_camera: {rotation: ["), std::string::npos) << yaml;
  EXPECT_NE(ros.find("frame_id: hand"), std::string::npos) << ros;
}

TEST_F(CliHandeye, PrintsWhatAUserNeeds) {
  const Outcome out = handeye();
  ASSERT_EQ(out.exit_code, 0) << out.err;
  for (const char* const part : {"OK", "camera in the hand", "board in the base", "robot ", "axes ",
                                 "worst ", "next: move the hand to"})
    EXPECT_NE(out.out.find(part), std::string::npos) << part << "\n" << out.out;
}

TEST_F(CliHandeye, NamesTheReadingThatFits) {
  robot_ = replaced(robot_, "x_m,y_m,z_m", "x_mm,y_mm,z_mm");
  const Outcome out = handeye("--out " + path("no.yaml"));
  EXPECT_EQ(out.exit_code, 3);
  EXPECT_NE(out.out.find("the lengths are metres,"), std::string::npos) << out.out;
  EXPECT_FALSE(fs::exists(root() / "no.yaml"));
}

// The poses of the pictures, as `tagcal pose` writes them.
class CliHandeyePoses : public CliHandeye {
 protected:
  CliHandeyePoses()
      : poses_(run("pose " + kDesk + " --camera " + kDesk + "/truth.yaml --json").out) {}

  Outcome handeye_of(const std::string& poses, const std::string& more = "") {
    spill(root() / "robot.csv", robot_);
    spill(root() / "poses.json", poses);
    return run("handeye " + path("poses.json") + " --robot " + path("robot.csv") +
               " --mount hand " + more);
  }

  std::string poses_;
};

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
  EXPECT_NE(slurp(root() / "handeye.yaml").find("mount_from_camera"), std::string::npos);
  EXPECT_EQ(handeye_of(poses_).out.find("px"), std::string::npos);
}

TEST_F(CliHandeyePoses, RefuseBadInputInOneLine) {
  const auto refuses = [&](const std::string& poses, const std::string& part,
                           const std::string& more = "") {
    const Outcome out = handeye_of(poses, more);
    EXPECT_EQ(out.exit_code, 2) << part << out.out;
    EXPECT_NE(out.err.find(part), std::string::npos) << out.err;
    EXPECT_EQ(std::ranges::count(out.err, '\n'), 1) << out.err;
  };
  refuses(poses_, "--camera: ", "--camera " + kDesk + "/truth.yaml");
  refuses(poses_, "--pair: ", "--pair index");
  refuses("{\"cameras\": []}", "views: the key is missing");
  refuses(replaced(poses_, "003.png", "002.png"), "two pictures have the name 002");
  refuses(replaced(poses_, "003.png", "103.png"), "003.png is no picture of");
  Json without = Json::parse(poses_);
  without["views"][4]["covariance"] = nullptr;
  refuses(without.dump(), "views[4].covariance: is missing");
  without["views"][4]["covariance"] = std::vector(6, std::vector(6, 0.0));
  refuses(without.dump(), "covariance positive definite");
  robot_ = robot_.substr(0, robot_.rfind("011.png"));
  refuses(poses_, "has no pose of the picture 011.png");
}

Pose pose_in(const Json& json) {
  const auto q = json["rotation"].get<std::vector<double>>();
  const auto t = json["translation_m"].get<std::vector<double>>();
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
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
    const Eigen::Vector3d& t = hand.translation();
    const Eigen::Quaterniond q = hand.rotation();
    for (const double x : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()})
      robot += (x == t.x() ? view["image"].get<std::string>() : "") + "," + std::to_string(x);
    robot += "\n";
  }
  spill(root() / "robot.csv", robot);
  const Outcome out = run("handeye " + path("rig") + " --camera " + path("rig.yaml") + " --robot " +
                          path("robot.csv") + " --mount hand --json");
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(out.out);
  const Vector6d step = minus(pose_in(answer["mount_from_camera"]), hand_from_rig);
  for (int i = 0; i < 6; ++i)
    EXPECT_LT(std::abs(step[i]), 4 * std::sqrt(answer["covariance"][i][i].get<double>())) << i;
  EXPECT_LT(step.tail<3>().norm(), 1e-3);
  EXPECT_EQ(out.out.find("lens_without_covariance"), std::string::npos) << out.out;
}

TEST_F(CliHandeye, NeedsACameraForPictures) {
  spill(root() / "robot.csv", robot_);
  const Outcome out = run("handeye " + kDesk + " --robot " + path("robot.csv") + " --mount hand");
  EXPECT_EQ(out.exit_code, 2);
  EXPECT_NE(out.err.find("--camera: is missing"), std::string::npos) << out.err;
}

TEST_F(CliHandeye, RefusesBadInputInOneLine) {
  const auto refuses = [&](const std::string& part, const std::string& more = "") {
    const Outcome out = handeye(more);
    EXPECT_EQ(out.exit_code, 2) << part << out.out;
    EXPECT_NE(out.err.find(part), std::string::npos) << out.err;
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
