#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <utility>

namespace tagcal::tools {

// A run of the command beside the test; killed at the end.
class CliProcess {
 public:
  // `arguments` as a shell takes them, redirections included.
  explicit CliProcess(const std::string& arguments) : pid_(fork()) {
    if (pid_ != 0) return;
    const std::string line = "exec " TAGCAL_COMMAND " " + arguments + " </dev/null";
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  ~CliProcess() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  CliProcess(const CliProcess&) = delete;
  CliProcess& operator=(const CliProcess&) = delete;

  void send(int signal) const { kill(pid_, signal); }

  // Waits for its end, and returns its exit code, or 128 and the signal that ended it as shells do.
  int wait() {
    int status = 0;
    waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_;
};

}  // namespace tagcal::tools
