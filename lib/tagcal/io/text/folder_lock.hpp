#pragma once

#include <chrono>
#include <filesystem>

namespace tagcal::internal {

// Private to io. Keeps other processes of tagcal from writing into a folder at the same time. The
// lock ends with the process. File systems without locks have none.
class FolderLock {
 public:
  // Waits up to `patience` while another process holds it.
  FolderLock(const std::filesystem::path& folder, std::chrono::milliseconds patience);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // False only if another process holds it.
  bool is_held() const { return is_held_; }

 private:
  int descriptor_;
  bool is_held_ = true;
};

}  // namespace tagcal::internal
