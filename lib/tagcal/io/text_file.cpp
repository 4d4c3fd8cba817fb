#include "tagcal/io/text_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "tagcal/error.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal {
using namespace internal;
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what, int code) {
  throw Error(file.string() + ": " + what + ": " + std::strerror(code));
}

// The files that a signal must remove.
class Unfinished {
 public:
  // Creates a new file. Returns its descriptor, or -1 with errno.
  int create(const std::filesystem::path& file) {
    const std::scoped_lock lock(mutex_);
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) files_.insert(file);
    return descriptor;
  }
  void erase(const std::filesystem::path& file) {
    const std::scoped_lock lock(mutex_);
    files_.erase(file);
  }
  // Later calls of create wait for ever: the program ends.
  void remove_all() {
    mutex_.lock();
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

// A file that is open as long as this lives.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  OpenFile(const std::filesystem::path& file, int flags)
      : OpenFile(::open(file.c_str(), flags | O_CLOEXEC)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  int descriptor() const { return descriptor_; }
  bool close() { return ::close(std::exchange(descriptor_, -1)) == 0; }

 private:
  int descriptor_;
};

// A new file beside another one, so that a rename stays within one file system. It is removed
// unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& beside) : out_(created(beside)) {}
  ~TemporaryFile() {
    if (is_mine_ && !renamed_) ::unlink(file_.c_str());
    unfinished().erase(file_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  OpenFile& out() { return out_; }
  bool rename_to(const std::filesystem::path& place) {
    renamed_ = ::rename(file_.c_str(), place.c_str()) == 0;
    return renamed_;
  }

 private:
  // A process of the same number, in another container or killed before, may have left a file of
  // the same name.
  int created(const std::filesystem::path& beside) {
    constexpr int kTries = 1000;
    static std::atomic<unsigned> count{0};
    for (int i = 0; i < kTries; ++i) {
      file_ = beside.parent_path() /
              (".tagcal-" + std::to_string(::getpid()) + "-" + std::to_string(count++) + ".tmp");
      const int descriptor = unfinished().create(file_);
      is_mine_ = descriptor >= 0;
      if (is_mine_ || errno != EEXIST) return descriptor;
    }
    return -1;
  }

  std::filesystem::path file_;
  bool is_mine_ = false;
  bool renamed_ = false;
  OpenFile out_;  // last: created() sets the others
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

// Opening a pipe waits until somebody reads it. Here it waits for half a second, not for ever.
int open_special(const std::filesystem::path& file, bool is_pipe) {
  constexpr int kTries = 50;
  for (int i = 1;; ++i) {
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor >= 0 || !is_pipe || errno != ENXIO) return descriptor;
    if (i == kTries) throw Error(file.string() + ": cannot write: nobody reads this pipe");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void write_special(const std::filesystem::path& file, std::string_view content, bool is_pipe) {
  const OpenFile out(open_special(file, is_pipe));
  if (out.descriptor() < 0) fail(file, "cannot write", errno);
  ::fcntl(out.descriptor(), F_SETFL, 0);  // without O_NONBLOCK
  write_all(out, content, file);
}

// stdout or stderr, if it is redirected to this file, else -1.
int own_stream(const struct stat& file) {
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat own {};
    if (::fstat(stream, &own) == 0 && own.st_dev == file.st_dev && own.st_ino == file.st_ino)
      return stream;
  }
  return -1;
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
  std::string text = read_all(in, size, file);
  remove_byte_order_mark(text);
  return text;
}

void remove_byte_order_mark(std::string& text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (text.starts_with(kMark)) text.erase(0, kMark.size());
}

std::string read_plain_text(const std::filesystem::path& file) {
  std::string text = read_text(file);
  check_plain_text(text, file.string());
  return text;
}

void check_plain_text(std::string_view text, const std::string& file) {
  const std::size_t at = text.find('\0');
  if (at == text.npos) return;
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  throw Error(file + ": line " + std::to_string(line) + ": is not text: binary data");
}

bool is_stream(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || S_ISDIR(status.st_mode)) return false;
  return !S_ISREG(status.st_mode) || own_stream(status) >= 0;
}

void write_whole(const std::filesystem::path& file, std::string_view content) {
  if (file.filename().empty()) throw Error(file.string() + ": cannot write: names no file");
  struct stat status {};
  const bool exists = ::stat(file.c_str(), &status) == 0;
  if (!exists && errno == ELOOP) fail(file, "cannot write", ELOOP);
  if (exists && S_ISDIR(status.st_mode)) {
    throw Error(file.string() + ": cannot write: is a folder");
  }
  // A device or a pipe (/dev/stdout, whose link names no path then) must not be replaced by a file.
  if (exists && !S_ISREG(status.st_mode))
    return write_special(file, content, S_ISFIFO(status.st_mode));
  // Nor what the program prints by the file of its answer (--out /dev/stdout > file).
  if (const int stream = exists ? own_stream(status) : -1; stream >= 0) {
    (void)std::fflush(stream == STDOUT_FILENO ? stdout : stderr);
    return write_all(OpenFile(::dup(stream)), content, file);
  }
  const std::filesystem::path end = behind_links(file);
  if (exists && ::access(end.c_str(), W_OK) != 0) fail(file, "cannot write", errno);

  TemporaryFile temporary(end);
  OpenFile& out = temporary.out();
  if (out.descriptor() < 0) fail(file, "cannot write", errno);
  write_all(out, content, file);
  if (exists) (void)::fchmod(out.descriptor(), status.st_mode & 07777);
  // fsync before the rename: else a crash could leave an empty file under the final name.
  if (::fsync(out.descriptor()) != 0) fail(file, "cannot write", errno);
  if (!out.close()) fail(file, "cannot write", errno);
  if (!temporary.rename_to(end)) fail(file, "cannot write", errno);
}

void remove_unfinished_files() { unfinished().remove_all(); }

FolderLock::FolderLock(const std::filesystem::path& folder, std::chrono::milliseconds patience)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  constexpr std::chrono::milliseconds kPause{5};
  const auto end = std::chrono::steady_clock::now() + patience;
  while (descriptor_ >= 0) {
    const bool is_held = ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
    if (is_held || std::chrono::steady_clock::now() >= end) return;
    std::this_thread::sleep_for(kPause);
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace tagcal
