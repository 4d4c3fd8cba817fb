#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "job/command.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "watch/folder_follower.hpp"
#include "watch/watch_report.hpp"
#include "watch/watched_pictures.hpp"

namespace tagcal::tools {

struct WatchOptions : WatchSettings {
  std::filesystem::path folder;
  std::string name;  // of the folder in messages
  CalibrateOptions calibration;
  // Of a folder that a live video fills: true once no picture comes any more; `why`: the fault that
  // ended it. Empty: pictures may always come.
  std::function<bool(std::string& why)> has_ended;
};

// Follows a folder, calibrates after each picture, and tells what it did. The calibration's file is
// written after each picture that leaves an answer; it is never changed to no answer.
class WatchSession {
 public:
  WatchSession(WatchOptions options, WatchedPictures& pictures, std::vector<std::string> warnings);

  // Until the goal is met, the folder is gone, nothing changed for the time of `timeout_s`, or the
  // user interrupts it.
  ExitCode run();

 private:
  enum class End { none, goal, gone, timeout, ended, interrupted };

  void greet() const;
  End step();
  bool has_video_ended();
  bool take(const FolderFollower::Events& events);
  void tell(const std::vector<PictureNews>& news, bool lists_boards);
  void recalibrate(Step step);
  void tell(const std::string& text) const { tools::tell(text, options_.json); }
  void tell_next(const std::optional<AdvisedView>& advice);
  ExitCode finish(End end);
  std::string end_text(End end) const;

  WatchOptions options_;
  WatchedPictures& pictures_;
  std::vector<std::string> warnings_;  // of the target's file
  FolderFollower follower_;
  std::chrono::steady_clock::time_point last_change_ = std::chrono::steady_clock::now();
  int missed_looks_ = 0;
  int quiet_looks_ = 0;    // since the video ended
  std::string video_why_;  // it ended
  bool is_first_ = true;   // the pictures that were there before
  Calibration calibration_;
  Standing standing_;
  std::optional<Calibration> kept_;  // the last answer, as it stands in the file
  Notices notices_;
  std::string next_words_;  // of the last `next:`, without numbers
  double next_distance_m_ = 0;
};

}  // namespace tagcal::tools
