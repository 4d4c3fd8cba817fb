// tagcal handeye, from outside.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

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
