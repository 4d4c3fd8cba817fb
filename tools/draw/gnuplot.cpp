#include "draw/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>

#include "tagcal/error.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// Files of the standard streams of a child process.
struct Streams {
  fs::path in, out, err;
};

class FileActions {
 public:
  explicit FileActions(const Streams& streams) {
    posix_spawn_file_actions_init(&actions_);
    constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions_, 0, streams.in.c_str(), O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, 1, streams.out.c_str(), kWrite, 0644);
    posix_spawn_file_actions_addopen(&actions_, 2, streams.err.c_str(), kWrite, 0644);
  }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

// Lets signals end a child, although this program blocks them in all its threads but one.
class NoSignalBlocked {
 public:
  NoSignalBlocked() {
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK);
  }
  ~NoSignalBlocked() { posix_spawnattr_destroy(&attributes_); }
  NoSignalBlocked(const NoSignalBlocked&) = delete;
  NoSignalBlocked& operator=(const NoSignalBlocked&) = delete;
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_;
};

// Returns the exit status; throws Error if the program cannot be started.
int run_gnuplot(const char* argument, const Streams& streams) {
  const FileActions actions(streams);
  const NoSignalBlocked attributes;
  std::string program = "gnuplot", first = argument;
  char* arguments[] = {program.data(), first.data(), nullptr};
  pid_t child = 0;
  if (const int why =
          posix_spawnp(&child, "gnuplot", actions.get(), attributes.get(), arguments, environ))
    throw Error(
        fmt::format("gnuplot: cannot be started: {}", std::generic_category().message(why)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string first_line(const std::string& text) {
  const std::size_t begin = text.find_first_not_of("\n ");
  if (begin == std::string::npos) return "no reason given";
  return text.substr(begin, text.find('\n', begin) - begin);
}

}  // namespace

bool has_gnuplot() {
  try {
    return run_gnuplot("--version", {"/dev/null", "/dev/null", "/dev/null"}) == 0;
  } catch (const Error&) {
    return false;
  }
}

void draw_with_gnuplot(const std::string& script, const fs::path& file) {
  const Streams streams{file.string() + ".gnuplot", file, file.string() + ".errors"};
  write_whole(streams.in, script);
  const int status = run_gnuplot("-", streams);
  const std::string complaint = read_text(streams.err);
  fs::remove(streams.in);
  fs::remove(streams.err);
  if (status != 0 || fs::file_size(file) == 0)
    throw Error(fmt::format("gnuplot: {}: {}", file.filename().string(), first_line(complaint)));
}

}  // namespace tagcal::tools
