#include "job/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

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
