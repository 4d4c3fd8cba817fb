#include "watch/folder_follower.hpp"

#include <algorithm>
#include <system_error>
#include <tuple>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {

namespace fs = std::filesystem;

std::optional<FolderListing> list_folder(const fs::path& folder) {
  FolderListing listing;
  try {
    for (const fs::path& file : list_pictures(folder)) {
      std::error_code gone;
      const FileStamp stamp{fs::file_size(file, gone), fs::last_write_time(file, gone)};
      if (!gone) listing[file.filename().string()] = stamp;
    }
  } catch (const Error&) {
    return std::nullopt;
  } catch (const fs::filesystem_error&) {
    return std::nullopt;
  }
  return listing;
}

// Returns true if the file is to be read now.
bool FolderFollower::is_due(File& file, const FileStamp& stamp) {
  file.missed = 0;
  if (file.stamp != stamp) {
    file.stamp = stamp;
    file.state = State::settling;
    file.failures = 0;
    return false;
  }
  const bool retries = file.state == State::unreadable && file.failures < kPatientLooks;
  return file.state == State::settling || retries;
}

// Forgets the files that the last two looks missed, and returns those that were ready before.
std::vector<std::string> FolderFollower::without_missed(const FolderListing& listing) {
  std::vector<std::string> removed;
  for (auto at = files_.begin(); at != files_.end();) {
    auto& [name, file] = *at;
    const bool is_gone = !listing.contains(name) && ++file.missed >= 2;
    if (is_gone && file.was_ready) removed.push_back(name);
    at = is_gone ? files_.erase(at) : std::next(at);
  }
  return removed;
}

FolderFollower::Events FolderFollower::look(const FolderListing& listing) {
  Events events;
  std::vector<std::tuple<fs::file_time_type, std::string>> due;
  for (const auto& [name, stamp] : listing) {
    const auto [at, is_new] = files_.try_emplace(name, File{stamp});
    File& file = at->second;
    if (is_new || !is_due(file, stamp)) continue;
    file.state = State::ready;
    file.was_ready = true;
    due.emplace_back(stamp.written, name);
  }
  std::ranges::sort(due);
  for (auto& [written, name] : due) events.ready.push_back(std::move(name));
  events.removed = without_missed(listing);
  return events;
}

bool FolderFollower::awaits() const {
  return std::ranges::any_of(files_, [](const auto& entry) {
    return entry.second.state == State::settling && !entry.second.was_ready;
  });
}

bool FolderFollower::postpone(const std::string& name) {
  const auto at = files_.find(name);
  if (at == files_.end()) return false;
  at->second.state = State::unreadable;
  return ++at->second.failures == kPatientLooks;
}

void FolderFollower::set_aside(const std::string& name) {
  const auto at = files_.find(name);
  if (at != files_.end()) at->second.state = State::set_aside;
}

void FolderFollower::recall_set_aside() {
  for (auto& [name, file] : files_)
    if (file.state == State::set_aside) file.state = State::settling;
}

}  // namespace tagcal::tools
