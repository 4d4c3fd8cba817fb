#pragma once

#include <filesystem>
#include <set>

namespace tagcal::tools {

// A folder that appears whole or not at all: it is filled under another name beside its place, and
// `publish` moves it there. Without `publish` it is removed again.
class OutputFolder {
 public:
  // Allowed at the place, besides nothing and an empty folder:
  enum class Taken {
    by_nothing,
    by_earlier_render,  // a folder with dataset.yaml and truth.yaml; its own files are replaced
    by_any_folder,      // its files stay, except those of the same names
  };

  // Throws Error if anything else is at the place, or if nothing can be created there.
  OutputFolder(const std::filesystem::path& place, Taken taken);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }

  // Moves the folder to its place. The user's own files there stay.
  void publish();

 private:
  void keep_users_files(const std::filesystem::path& old) const;

  void move_files();

  std::filesystem::path place_;
  std::filesystem::path partial_;
  std::set<std::filesystem::path> replaced_;  // files of the earlier render, relative to the place
  bool joins_;                                // the files at the place
};

}  // namespace tagcal::tools
