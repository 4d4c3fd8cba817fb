#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "job/command.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "watch/folder_follower.hpp"
#include "watch/watched_pictures.hpp"

namespace tagcal::tools {

struct WatchOptions : WatchSettings {
  std::filesystem::path folder;
  std::string name;  // of the folder in messages
  CalibrateOptions calibration;
  // Tells of a folder that a live video fills whether it has ended; `why`: the fault that ended it.
  // Empty: pictures may always come.
  std::function<bool(std::string& why)> has_ended;
};

// Follows a folder, calibrates after each picture, and tells what it did. The calibration's file is
// written after each picture that leaves an answer; it is never changed to no answer. `warnings`:
// of the target's file. Until the goal is met, the folder is gone, nothing changed for the time of
// `timeout_s`, or the user interrupts it.
ExitCode watch_folder(WatchOptions options, WatchedPictures& pictures,
                      std::vector<std::string> warnings);

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

// The same for the folders of a rig's cameras; tells which pair of cameras needs the board next.
ExitCode watch_rig(RigWatchOptions options, std::vector<WatchedCamera> cameras,
                   std::vector<std::string> warnings);

}  // namespace tagcal::tools
