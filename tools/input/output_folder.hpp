#pragma once

#include <filesystem>
#include <set>

namespace tagcal::tools {

// A folder that appears whole or not at all: it is filled under another name beside its place, and
// `publish` moves it there. Whatever is not published is removed again.
class OutputFolder {
 public:
  // What may be at the place: nothing, an empty folder, and
  enum class Taken {
    by_earlier_render,  // a folder with dataset.yaml and truth.yaml; the files it had made go away
    by_any_folder,      // all that is in it stays, but for files of the same names
  };

  // Throws Error where the place is taken by anything else, or where nothing can be made there.
  explicit OutputFolder(const std::filesystem::path& place, Taken taken = Taken::by_earlier_render);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }

  // Moves the folder to its place. Everything that a user put there stays.
  void publish();

 private:
  void keep_users_files(const std::filesystem::path& old) const;

  void move_files();

  std::filesystem::path place_;
  std::filesystem::path partial_;
  std::set<std::filesystem::path> replaced_;  // files of the earlier render, relative to the place
  bool joins_;                                // the files that are at the place
};

}  // namespace tagcal::tools
