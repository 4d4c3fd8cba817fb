#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/detector.hpp"

namespace tagcal::tools {

// A file of corners that were found before, which never changes an answer: a picture's corners are
// reused only if its name and its bytes, the boards, the options and the program (version and
// build) are the same. A damaged file, or one of other boards, options or version, is as good as
// none.
class CornerCache {
 public:
  // `file`: where it is read now and written by `save`.
  CornerCache(std::filesystem::path file, const std::vector<PlacedBoard>& boards,
              const DetectOptions& options);

  // Both may be called from several threads. `others`: what the corners depend on beside the
  // picture, the frames of a sequence before it.
  std::optional<DetectedPicture> find(const std::string& name, const std::filesystem::path& picture,
                                      const std::string& others = {});
  void keep(const std::string& name, const DetectedPicture& found);

  int num_reused() const { return num_reused_; }
  const std::string& warning() const { return warning_; }  // of a damaged file; "": none

  // Writes the file if it has changed. Returns true if it was written; no answer depends on it, so
  // that a failure is only a warning.
  bool save();

 private:
  struct Entry {
    std::string content;  // of the picture
    std::optional<DetectedPicture> found;
  };
  void read();

  std::filesystem::path file_;
  std::string key_;  // of everything but the pictures
  std::map<std::string, Entry> entries_;
  std::mutex mutex_;
  int num_reused_ = 0;
  bool changed_ = false;
  std::string warning_;
};

}  // namespace tagcal::tools
