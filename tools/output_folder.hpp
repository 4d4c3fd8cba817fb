#pragma once

#include <filesystem>
#include <set>

namespace tagcal::tools {

// A folder that appears whole or not at all: it is filled under another name beside its place, and
// `publish` moves it there. Whatever is not published is removed again.
class OutputFolder {
 public:
  // Throws Error where the place is taken by anything but an empty folder or an earlier render
  // (dataset.yaml and truth.yaml in it), or where nothing can be made there.
  explicit OutputFolder(const std::filesystem::path& place);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }

  // Moves the folder to its place. Of an earlier render there, the files that it had made go away;
  // everything that a user put beside them stays.
  void publish();

 private:
  void keep_users_files(const std::filesystem::path& old) const;

  std::filesystem::path place_;
  std::filesystem::path partial_;
  std::set<std::filesystem::path> replaced_;  // files of the earlier render, relative to the place
};

}  // namespace tagcal::tools
