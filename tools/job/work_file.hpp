#pragma once

#include <filesystem>
#include <string>

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

}  // namespace tagcal::tools
