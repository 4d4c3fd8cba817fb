#pragma once

#include <string>

#include "page_data.hpp"
#include "tagcal/geometry/pose.hpp"

// The desk's pictures and robot for the tests of `tagcal handeye`.

namespace tagcal::tools {

using Json = nlohmann::json;

inline const std::string kDesk = TAGCAL_SOURCE_DIR "/data-synthetic/golden/desk";

inline Pose pose_in(const Json& json) {
  const auto q = json["rotation"].get<std::vector<double>>();
  const auto t = json["translation_m"].get<std::vector<double>>();
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
}

// A line of a robot's table behind the picture's name.
inline std::string row_of(const Pose& hand) {
  const Eigen::Vector3d& t = hand.translation();
  const Eigen::Quaterniond q = hand.rotation();
  std::string row;
  for (const double x : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()})
    row += "," + std::to_string(x);
  return row + "\n";
}

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

}  // namespace tagcal::tools
