#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "job/interruption.hpp"

namespace tagcal::tools {

// A file in a folder that says which work fills it, so that a later process can go on with it. It
// locks the folder for one process. The file stays until remove_from.
class WorkFile {
 public:
  static constexpr const char* kName = ".resume";

  // `work`: version, input and options as text. Throws Error if the folder is of other work, or in
  // use by another process.
  WorkFile(const std::filesystem::path& folder, const std::string& work);
  ~WorkFile();
  WorkFile(const WorkFile&) = delete;
  WorkFile& operator=(const WorkFile&) = delete;

  static void remove_from(const std::filesystem::path& folder);

 private:
  void lock(const std::filesystem::path& folder) const;

  int descriptor_;
};

// A folder that appears whole or not at all: it is filled under another name beside its place, and
// `publish` moves it there. Without `publish` it is removed again, also by a signal.
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
  // The same for work that can go on later: the folder is filled as PLACE.partial, stays there
  // without `publish`, and is taken up again by a call with the same `work` (its version, input and
  // options as text). Throws Error if the folder there is of other work, or in use by another
  // process.
  OutputFolder(const std::filesystem::path& place, Taken taken, const std::string& work);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }

  // Moves the folder to its place. The user's own files there stay.
  void publish();

 private:
  void check_place(const std::filesystem::path& place);
  void create_partial(const std::filesystem::path& place);
  void keep_users_files(const std::filesystem::path& old) const;

  void move_files();

  std::filesystem::path place_;
  std::filesystem::path partial_;
  std::set<std::filesystem::path> replaced_;  // files of the earlier render, relative to the place
  Taken taken_;
  std::optional<RemovedOnSignal> removal_;
  std::optional<WorkFile> work_;  // of work that can go on
};

}  // namespace tagcal::tools
