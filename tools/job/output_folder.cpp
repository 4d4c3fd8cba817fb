#include "job/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/rig_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

Error cannot_write(const fs::path& path, const std::error_code& why) {
  return Error(fmt::format("{}: cannot be written: {}", path.string(), why.message()));
}

// Resolves links and removes a slash at the end, so that a sibling can be named.
fs::path plain_path(const fs::path& path) {
  std::error_code why;
  fs::path plain = fs::weakly_canonical(fs::absolute(path), why);
  if (why) throw cannot_write(path, why);
  if (!plain.has_filename()) plain = plain.parent_path();
  if (!plain.has_filename()) throw Error(fmt::format("{}: not a folder to write", path.string()));
  return plain;
}

// target.yaml, target-0.yaml, target-1.yaml, ...
bool is_target_file(std::string_view name) {
  if (!name.starts_with("target") || !name.ends_with(".yaml")) return false;
  name.remove_prefix(6);
  name.remove_suffix(5);
  return name.empty() || (name.size() > 1 && name[0] == '-' &&
                          name.find_first_not_of("0123456789", 1) == std::string_view::npos);
}

// A name with a folder in it is no file of a render, and may be anywhere.
bool is_plain_name(const std::string& name) {
  return fs::path(name).filename() == name && name != "." && name != "..";
}

// The files of a render: those that truth.yaml names, and the fixed names; of a rig, also those of
// the folders of its cameras.
std::set<fs::path> files_of_render(const fs::path& folder) {
  std::set<fs::path> files = {"dataset.yaml", "truth.yaml", "observations_exact.csv", "times.csv"};
  const std::vector<std::string> cameras = cameras_of_rig_truth(folder / "truth.yaml");
  for (const std::string& camera : cameras)
    if (is_plain_name(camera) && fs::exists(folder / camera / "truth.yaml"))
      for (const fs::path& file : files_of_render(folder / camera))
        files.insert(fs::path(camera) / file);
  if (cameras.empty())
    for (const auto& [image, pose] : read_truth(folder / "truth.yaml").camera_from_world)
      if (is_plain_name(image)) files.insert(fs::path("images") / image);
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (is_target_file(name)) files.insert(name);
  }
  return files;
}

// Removes what a killed process was writing; what it had written stays.
void remove_unfinished(const fs::path& folder) {
  std::vector<fs::path> unfinished;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().filename().string().starts_with(".tagcal-")) unfinished.push_back(entry);
  for (const fs::path& file : unfinished) fs::remove(file);
}

// Exchanges two folders; in one step where the file system can, so that a reader sees either.
void exchange(const fs::path& a, const fs::path& b, std::error_code& why) {
  why.clear();
  if (::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0) return;
  fs::path aside = b;
  aside += fmt::format(".replaced-{}", getpid());
  fs::rename(b, aside, why);
  if (why) return;
  fs::rename(a, b, why);
  std::error_code lost;
  if (why)
    fs::rename(aside, b, lost);  // as before
  else
    fs::rename(aside, a, why);
}

Error cannot_write(const std::filesystem::path& file) {
  return Error(fmt::format("{}: cannot be written: {}", file.string(),
                           std::generic_category().message(errno)));
}

// In one call: a process that is killed leaves the whole text, or an empty file.
bool write_once(int descriptor, const std::string& text) {
  return ::write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
         ::fsync(descriptor) == 0;
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& place, Taken taken)
    : place_(plain_path(place)), taken_(taken) {
  check_place(place);
  create_partial(place);
}

// A process of the same number, in another container or killed before, may have left a folder of
// the same name.
void OutputFolder::create_partial(const fs::path& place) {
  constexpr int kTries = 100;
  std::error_code why;
  fs::create_directories(place_.parent_path(), why);
  if (why) throw cannot_write(place, why);
  for (int i = 0; i < kTries; ++i) {
    partial_ = place_;
    partial_ += fmt::format(".partial-{}", getpid()) + (i > 0 ? fmt::format("-{}", i) : "");
    removal_.emplace(partial_, why);
    if (!why) return;
    removal_.reset();
    if (why != std::errc::file_exists) break;
  }
  partial_.clear();  // nothing to remove
  throw cannot_write(place, why);
}

OutputFolder::OutputFolder(const fs::path& place, Taken taken, const std::string& work)
    : place_(plain_path(place)), taken_(taken) {
  check_place(place);
  partial_ = place_;
  partial_ += ".partial";
  std::error_code why;
  fs::create_directories(place_.parent_path(), why);
  if (why) throw cannot_write(place, why);
  const bool is_new = fs::create_directory(partial_, why);
  if (why) throw cannot_write(place, why);
  // A process that was killed before its first file leaves an empty folder.
  if (!is_new && !fs::exists(partial_ / WorkFile::kName) && !fs::is_empty(partial_))
    throw Error(fmt::format("{}: is not of an interrupted run; rename it", partial_.string()));
  work_.emplace(partial_, work);
  remove_unfinished(partial_);
}

void OutputFolder::check_place(const fs::path& place) {
  replaced_.clear();
  if (fs::exists(place_) && !fs::is_directory(place_)) {
    throw Error(fmt::format("{}: must be a folder, got a file", place.string()));
  }
  if (!fs::exists(place_) && is_picture_name(place_))
    throw Error(
        fmt::format("{}: must be a folder, got the name of a picture; the files in the "
                    "folder get their own names",
                    place.string()));
  if (taken_ != Taken::by_any_folder && fs::is_directory(place_) && !fs::is_empty(place_)) {
    if (!fs::exists(place_ / "dataset.yaml") || !fs::exists(place_ / "truth.yaml")) {
      throw Error(
          fmt::format("{}: must be empty or an earlier render, has other files", place.string()));
    }
    if (taken_ == Taken::by_nothing)
      throw Error(fmt::format("{}: holds an earlier render; --force replaces it", place.string()));
    replaced_ = files_of_render(place_);
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!partial_.empty() && !work_) fs::remove_all(partial_, ignored);
}

void OutputFolder::publish() {
  // Of two processes one comes first, and the other one finds its files.
  const FolderLock lock(place_.parent_path(), std::chrono::seconds(10));
  check_place(place_);
  if (taken_ == Taken::by_any_folder && fs::is_directory(place_)) return move_files();
  removal_.reset();  // from now on the other name may have the user's files
  std::error_code why;
  if (replaced_.empty())
    fs::rename(partial_, place_, why);
  else
    exchange(partial_, place_, why);
  if (why) throw cannot_write(place_, why);
  const fs::path old = std::exchange(partial_, {});
  if (work_) WorkFile::remove_from(place_);
  if (!replaced_.empty()) keep_users_files(old);
}

void OutputFolder::move_files() {
  std::vector<fs::path> entries;
  for (const auto& entry : fs::recursive_directory_iterator(partial_))
    entries.push_back(entry.path());
  for (const fs::path& entry : entries) {  // a folder before what is in it
    const fs::path place = place_ / entry.lexically_relative(partial_);
    std::error_code why;
    if (fs::is_directory(entry))
      fs::create_directory(place, why);
    else
      fs::rename(entry, place, why);
    if (why) throw cannot_write(place, why);
  }
}

// Removes files one by one, and folders only if they are empty, so that no other file is removed.
void OutputFolder::keep_users_files(const fs::path& old) const {
  std::error_code not_a_file;  // a folder of the user has its name
  for (const fs::path& file : replaced_) fs::remove(old / file, not_a_file);
  std::vector<fs::path> entries;
  for (const auto& entry : fs::recursive_directory_iterator(old)) entries.push_back(entry.path());
  for (const fs::path& entry : entries) {
    const fs::path kept = place_ / entry.lexically_relative(old);
    std::error_code there;
    if (fs::exists(kept, there) || !fs::exists(fs::symlink_status(entry))) continue;
    fs::rename(entry, kept);
  }
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    std::error_code not_empty_or_gone;
    fs::remove(*entry, not_empty_or_gone);
  }
  std::error_code not_empty;
  fs::remove(old, not_empty);
}

WorkFile::WorkFile(const std::filesystem::path& folder, const std::string& work)
    : descriptor_(::open((folder / kName).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) throw cannot_write(folder / kName);
  try {
    lock(folder);
    const std::string earlier = read_text(folder / kName);
    if (earlier.empty() && !write_once(descriptor_, work)) {
      const Error error = cannot_write(folder / kName);
      (void)!::ftruncate(descriptor_, 0);  // half a text would be that of other work
      throw error;
    }
    if (!earlier.empty() && earlier != work) {
      throw Error(
          fmt::format("{}: was started with different inputs, options or program version; "
                      "remove it to start again",
                      folder.string()));
    }
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

WorkFile::~WorkFile() { ::close(descriptor_); }

void WorkFile::lock(const std::filesystem::path& folder) const {
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0)
    throw Error(fmt::format("{}: another process is writing it", folder.string()));
}

void WorkFile::remove_from(const std::filesystem::path& folder) {
  ::unlink((folder / kName).c_str());
}

}  // namespace tagcal::tools
