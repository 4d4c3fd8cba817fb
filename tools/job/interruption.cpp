#include "job/interruption.hpp"

#include <pthread.h>
#include <unistd.h>

#include <condition_variable>
#include <csignal>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

struct State {
  std::mutex mutex;
  std::condition_variable requested;
  bool is_asked_first = false;  // an Interruption lives
  bool is_requested = false;
  std::set<std::filesystem::path> folders;
};

// Never destroyed: the thread of signals may use it while the program ends.
State& state() {
  static State& state = *new State;
  return state;
}

// Other threads may still write into a folder while it is removed.
void remove_folder(const std::filesystem::path& folder) {
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    std::error_code why;
    std::filesystem::remove_all(folder, why);
    if (!std::filesystem::exists(folder, why)) return;
  }
}

[[noreturn]] void end_by(int signal) {
  remove_unfinished_files();  // first: then nothing new appears in the folders
  for (const std::filesystem::path& folder : state().folders) remove_folder(folder);
  // The caller sees that a signal ended the program.
  std::signal(signal, SIG_DFL);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  raise(signal);
  _exit(128 + signal);
}

void wait_for_signals(const sigset_t& signals) {
  for (;;) {
    int signal = 0;
    if (sigwait(&signals, &signal) != 0) continue;
    const std::scoped_lock lock(state().mutex);
    if (!state().is_asked_first || state().is_requested) end_by(signal);
    state().is_requested = true;
    state().requested.notify_all();
  }
}

bool is_ignored(int signal) {
  struct sigaction action = {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

void end_tidily_on_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (!is_ignored(signal)) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // A pipe that nobody reads any more, and a file beyond `ulimit -f`, are errors of writing, which
  // are reported and remove what was begun; these signals would end the program at once.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  state();
  try {
    std::thread(wait_for_signals, signals).detach();
  } catch (const std::system_error&) {  // no more threads: signals end the program at once
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  }
}

Interruption::Interruption() {
  const std::scoped_lock lock(state().mutex);
  state().is_asked_first = true;
  state().is_requested = false;
}

Interruption::~Interruption() {
  const std::scoped_lock lock(state().mutex);
  state().is_asked_first = false;
}

bool Interruption::requested() {
  const std::scoped_lock lock(state().mutex);
  return state().is_requested;
}

void Interruption::sleep(std::chrono::milliseconds time) {
  std::unique_lock lock(state().mutex);
  state().requested.wait_for(lock, time, [] { return state().is_requested; });
}

RemovedOnSignal::RemovedOnSignal(std::filesystem::path folder, std::error_code& why)
    : folder_(std::move(folder)) {
  const std::scoped_lock lock(state().mutex);
  why = std::make_error_code(std::errc::file_exists);
  std::error_code failed;
  if (!std::filesystem::create_directory(folder_, failed)) {
    if (failed) why = failed;
    return;
  }
  why.clear();
  state().folders.insert(folder_);
}

RemovedOnSignal::~RemovedOnSignal() {
  const std::scoped_lock lock(state().mutex);
  state().folders.erase(folder_);
}

}  // namespace tagcal::tools
