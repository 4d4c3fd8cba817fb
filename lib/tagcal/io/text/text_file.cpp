#include "tagcal/io/text/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what, int code) {
  throw Error(file.string() + ": " + what + ": " + std::strerror(code));
}

// The files that a signal must remove.
class Unfinished {
 public:
  void insert(const std::filesystem::path& file) {
    const std::scoped_lock lock(mutex_);
    files_.insert(file);
  }
  void erase(const std::filesystem::path& file) {
    const std::scoped_lock lock(mutex_);
    files_.erase(file);
  }
  void remove_all() {
    const std::scoped_lock lock(mutex_);
    for (const std::filesystem::path& file : files_) ::unlink(file.c_str());
  }

 private:
  std::mutex mutex_;
  std::set<std::filesystem::path> files_;
};

// Never destroyed: a thread may use it while the program ends.
Unfinished& unfinished() {
  static Unfinished& unfinished = *new Unfinished;
  return unfinished;
}

// Closes a file, and removes it unless it was kept.
class OpenFile {
 public:
  OpenFile(const std::filesystem::path& file, int flags)
      : file_(file), descriptor_(::open(file.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!remove_) return;
    ::unlink(file_.c_str());
    unfinished().erase(file_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  int descriptor() const { return descriptor_; }
  // A temporary file, until it is kept.
  void mark_unfinished() {
    remove_ = true;
    unfinished().insert(file_);
  }
  void keep() {
    remove_ = false;
    unfinished().erase(file_);
  }
  bool close() {
    const int result = ::close(descriptor_);
    descriptor_ = -1;
    return result == 0;
  }

 private:
  std::filesystem::path file_;
  int descriptor_;
  bool remove_ = false;
};

// Reads up to the end, also from a pipe, whose size is unknown.
std::string read_all(const OpenFile& in, std::size_t expected, const std::filesystem::path& file) {
  std::string text(expected + 1, '\0');
  std::size_t size = 0;
  for (;;) {
    if (size == text.size()) text.resize(2 * size);
    const ssize_t n = ::read(in.descriptor(), text.data() + size, text.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file, "cannot read", errno);
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
    if (size > limits::kMaxTextBytes) throw Error(file.string() + ": larger than 256 MiB");
  }
  text.resize(size);
  return text;
}

void write_all(const OpenFile& out, std::string_view content, const std::filesystem::path& file) {
  while (!content.empty()) {
    const ssize_t n = ::write(out.descriptor(), content.data(), content.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file, "cannot write", errno);
    content.remove_prefix(static_cast<std::size_t>(n));
  }
}

// A name beside `file`, so that the rename stays within one file system; unique for every call.
std::filesystem::path temporary_beside(const std::filesystem::path& file) {
  static std::atomic<unsigned> count{0};
  const std::string name =
      ".tagcal-" + std::to_string(::getpid()) + "-" + std::to_string(count++) + ".tmp";
  return file.parent_path() / name;
}

// The file at the end of a chain of symbolic links, so that writing keeps the link.
std::filesystem::path behind_links(std::filesystem::path file) {
  std::error_code error;
  for (int i = 0; i < 40 && std::filesystem::is_symlink(file, error); ++i) {
    const std::filesystem::path next = std::filesystem::read_symlink(file, error);
    if (error) break;
    file = next.is_absolute() ? next : file.parent_path() / next;
  }
  return file;
}

void write_special(const std::filesystem::path& file, std::string_view content) {
  OpenFile out(file, O_WRONLY);
  if (out.descriptor() < 0) fail(file, "cannot write", errno);
  write_all(out, content, file);
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) throw Error(file.string() + ": no such file");
    fail(file, "cannot read", errno);
  }
  if (S_ISDIR(status.st_mode)) throw Error(file.string() + ": is a folder, not a file");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode))
    throw Error(file.string() + ": is a device, not a file");
  const auto size = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0));
  if (size > limits::kMaxTextBytes) throw Error(file.string() + ": larger than 256 MiB");
  // Opening a pipe to which nobody writes would wait for ever; this way it reads as empty.
  const OpenFile in(file, O_RDONLY | O_NONBLOCK);
  if (in.descriptor() < 0) fail(file, "cannot read", errno);
  ::fcntl(in.descriptor(), F_SETFL, 0);  // without O_NONBLOCK
  return read_all(in, size, file);
}

void write_whole(const std::filesystem::path& file, std::string_view content) {
  if (file.filename().empty()) throw Error(file.string() + ": cannot write: names no file");
  const std::filesystem::path end = behind_links(file);
  struct stat status {};
  const bool exists = ::stat(end.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) {
    throw Error(file.string() + ": cannot write: is a folder");
  }
  // A device or a pipe (/dev/stdout) must not be replaced by a file.
  if (exists && !S_ISREG(status.st_mode)) return write_special(file, content);
  if (exists && ::access(end.c_str(), W_OK) != 0) fail(file, "cannot write", errno);

  const std::filesystem::path temporary = temporary_beside(end);
  OpenFile out(temporary, O_WRONLY | O_CREAT | O_EXCL);
  if (out.descriptor() < 0) fail(file, "cannot write", errno);
  out.mark_unfinished();
  write_all(out, content, file);
  if (exists) (void)::fchmod(out.descriptor(), status.st_mode & 07777);
  // fsync before the rename: else a crash could leave an empty file under the final name.
  if (::fsync(out.descriptor()) != 0) fail(file, "cannot write", errno);
  if (!out.close()) fail(file, "cannot write", errno);
  if (::rename(temporary.c_str(), end.c_str()) != 0) fail(file, "cannot write", errno);
  out.keep();
}

void remove_unfinished_files() { unfinished().remove_all(); }

}  // namespace tagcal::internal
