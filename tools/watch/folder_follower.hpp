#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tagcal::tools {

// What shows that a file was written to.
struct FileStamp {
  std::uintmax_t size = 0;
  std::filesystem::file_time_type written;

  bool operator==(const FileStamp&) const = default;
};

// The pictures of a folder at one moment, by file name.
using FolderListing = std::map<std::string, FileStamp>;

constexpr int kMissedLooks = 6;  // a folder that cannot be read so often is gone

// The listing of a folder's pictures (list_pictures). No value if it cannot be read.
std::optional<FolderListing> list_folder(const std::filesystem::path& folder);

// Makes events of a folder's listings: which files are complete, and which are gone. It knows
// neither clock nor file system.
class FolderFollower {
 public:
  struct Events {
    std::vector<std::string> ready;    // new or written again, and at rest; the oldest first
    std::vector<std::string> removed;  // files that were ready before
  };

  // A file is ready if two looks in succession see the same size and time, and removed if two miss
  // it: a file that is replaced, or a folder that is being deleted, does not count as removed.
  Events look(const FolderListing& listing);

  // True if a new file was seen that is not known to be at rest yet.
  bool awaits() const;

  // A ready file that cannot be read: it is ready again at the next look, and after kPatientLooks
  // only once it is written again. Returns true once for each file that stays unreadable so long.
  bool postpone(const std::string& name);

  // Makes all files ready again that were passed to this function.
  void set_aside(const std::string& name);
  void recall_set_aside();

  static constexpr int kPatientLooks = 10;

 private:
  enum class State { settling, ready, unreadable, set_aside };
  struct File {
    FileStamp stamp;
    State state = State::settling;
    bool was_ready = false;
    int missed = 0;    // looks
    int failures = 0;  // since it was written
  };
  static bool is_due(File& file, const FileStamp& stamp);
  std::vector<std::string> without_missed(const FolderListing& listing);

  std::map<std::string, File> files_;
};

}  // namespace tagcal::tools
