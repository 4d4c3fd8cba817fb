#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "job/command.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "watch/folder_follower.hpp"
#include "watch/watch_report.hpp"
#include "watch/watched_pictures.hpp"

namespace tagcal::tools {

// A folder of the pictures of one camera of a rig.
struct WatchedCamera {
  std::string name;
  std::filesystem::path folder;
  std::unique_ptr<WatchedPictures> pictures;
  FolderFollower follower = {};
  int missed_looks = 0;
};

struct RigWatchOptions : WatchSettings {
  RigOptions calibration;
};

// Follows the folders of a rig's cameras, calibrates after each change, and tells which pair of
// cameras needs the board next. While it watches it calibrates from at most kMostWatched instants,
// so that its time does not grow, and at the end from all of them.
class RigSession {
 public:
  RigSession(RigWatchOptions options, std::vector<WatchedCamera> cameras,
             std::vector<std::string> warnings);

  // Until the goal is met, a folder is gone, nothing changed for the time of `timeout_s`, or the
  // user interrupts it.
  ExitCode run();

  static constexpr std::size_t kMostWatched = 60;

 private:
  enum class End { none, goal, gone, timeout, interrupted };

  End step();
  bool take(WatchedCamera& camera, const FolderFollower::Events& events);
  RigDataset data(std::size_t most_instants);
  void recalibrate();
  bool calibrate_from(std::size_t most_instants);
  std::string what_lacks() const;
  std::string next_words() const;
  void tell(const std::string& text) const { tools::tell(text, options_.json); }
  void tell_next();
  ExitCode finish(End end);

  RigWatchOptions options_;
  std::vector<WatchedCamera> cameras_;
  std::vector<std::string> warnings_;  // of the target's file
  std::chrono::steady_clock::time_point last_change_ = std::chrono::steady_clock::now();
  bool is_first_ = true;  // the pictures that were there before
  std::size_t num_paired_ = 0;
  std::string unpaired_;  // why there are no instants
  RigDataset used_;       // from which `rig_` is
  RigCalibration rig_;
  std::optional<RigDataset> kept_data_;  // of the last answer, as it stands in the file
  RigCalibration kept_;
  Notices notices_;
  std::string next_;  // the last `next:`, without numbers
};

}  // namespace tagcal::tools
