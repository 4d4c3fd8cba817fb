#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <chrono>
#include <memory>
#include <thread>

#include "cli_fixture.hpp"
#include "cli_process.hpp"

// Commands that are interrupted, killed or run twice: no output is ever half there.

namespace tagcal::tools {
namespace {

using Names = std::vector<std::string>;

class Interrupted : public Cli {
 protected:
  static void SetUpTestSuite() {
    Cli::SetUpTestSuite();
    spill(root() / "long.yaml", replaced(kScene, "views: 6", "views: 60"));
    ASSERT_EQ(run(render("whole")).exit_code, 0);
  }

  static std::string render(const std::string& out, const std::string& options = "") {
    return "render " + path("long.yaml") + " --threads 1 --out " + path(out) + " " + options;
  }

  static Names entries(const std::string& prefix) {
    Names names;
    for (const auto& entry : fs::directory_iterator(root()))
      if (entry.path().filename().string().starts_with(prefix))
        names.push_back(entry.path().filename().string());
    return names;
  }

  static std::size_t num_pictures(const fs::path& folder) {
    std::size_t count = 0;
    for (const std::string& name : entries(folder.filename().string()))
      if (const fs::path images = root() / name / "images"; fs::exists(images))
        for (const auto& entry : fs::directory_iterator(images))
          count += entry.path().filename().string().starts_with(".") ? 0 : 1;
    return count;
  }

  // Starts a render, and waits for its first pictures.
  static std::unique_ptr<CliProcess> begun(const std::string& out,
                                           const std::string& options = "") {
    auto process = std::make_unique<CliProcess>(render(out, options) + " >/dev/null 2>&1");
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (num_pictures(root() / out) < 3 && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return process;
  }
};

TEST_F(Interrupted, CtrlCRemovesTheTemporaryFolder) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto process = begun("half");
    process->send(signal);
    EXPECT_EQ(process->wait(), 128 + signal);
    EXPECT_EQ(entries("half"), Names());
  }
}

TEST_F(Interrupted, CtrlCDoesNotTouchAnEarlierRender) {
  ASSERT_EQ(run(render("earlier", "--seed 5")).exit_code, 0);
  spill(root() / "earlier/notes.txt", "mine");
  const auto before = bytes_of(root() / "earlier");
  const auto process = begun("earlier", "--force");
  process->send(SIGINT);
  EXPECT_EQ(process->wait(), 128 + SIGINT);
  EXPECT_EQ(bytes_of(root() / "earlier"), before);
  EXPECT_EQ(entries("earlier"), Names{"earlier"});
}

TEST_F(Interrupted, ResumeGoesOnAfterAnyEnd) {
  for (const int signal : {SIGINT, SIGKILL}) {
    const std::string name = "resumed" + std::to_string(signal);
    const auto process = begun(name, "--resume");
    process->send(signal);
    EXPECT_EQ(process->wait(), 128 + signal);
    EXPECT_EQ(entries(name), Names{name + ".partial"});
    // What a killed process was just writing does not become part of the data set.
    spill(root() / (name + ".partial") / "images" / ".tagcal-1-2.tmp", "half");
    const fs::path first = root() / (name + ".partial") / "images/000.png";
    const auto time = fs::last_write_time(first);
    ASSERT_EQ(run(render(name, "--resume")).exit_code, 0);
    EXPECT_EQ(bytes_of(root() / name), bytes_of(root() / "whole"));
    EXPECT_EQ(fs::last_write_time(root() / name / "images/000.png"), time);
    EXPECT_EQ(entries(name), Names{name});
  }
}

// A limit on the bytes of files simulates a full disk.
TEST_F(Interrupted, ResumeGoesOnAfterAFullDisk) {
  const std::string command = std::string(TAGCAL_COMMAND) + " " + render("full", "--resume");
  for (const char* bytes : {"0", "100", "5000"}) {
    const std::string limited =
        std::string("prlimit --fsize=") + bytes + " " + command + " >/dev/null 2>&1";
    EXPECT_EQ(WEXITSTATUS(std::system(limited.c_str())), 2) << bytes;
    EXPECT_EQ(entries("full"), Names{"full.partial"}) << bytes;
  }
  good_run(render("full", "--resume"));
  EXPECT_EQ(bytes_of(root() / "full"), bytes_of(root() / "whole"));
}

TEST_F(Interrupted, ResumeRefusesOtherWork) {
  const auto process = begun("other", "--resume");
  process->send(SIGKILL);
  process->wait();
  expect_bad_input(render("other", "--resume --seed 1"),
                   {"other.partial", "started with different"});
  expect_bad_input(render("other", "--resume --views 5"),
                   {"other.partial", "started with different"});
  const std::string scene = slurp(root() / "long.yaml");
  spill(root() / "long.yaml", replaced(scene, "noise_levels: 2", "noise_levels: 3"));
  expect_bad_input(render("other", "--resume"), {"other.partial", "started with different"});
  spill(root() / "long.yaml", scene);
  EXPECT_EQ(run(render("other", "--resume")).exit_code, 0);

  fs::create_directories(root() / "mine.partial");
  spill(root() / "mine.partial/notes.txt", "mine");
  expect_bad_input(render("mine", "--resume"), {"mine.partial"});
  EXPECT_EQ(slurp(root() / "mine.partial/notes.txt"), "mine");
}

TEST_F(Interrupted, TwoProcessesDoNotResumeTheSameFolder) {
  const auto process = begun("twice", "--resume");
  process->send(SIGSTOP);  // until the second one, which may be slower, has had its answer
  expect_bad_input(render("twice", "--resume"), {"twice.partial", "another process"});
  process->send(SIGCONT);
  EXPECT_EQ(process->wait(), 0);
  EXPECT_EQ(bytes_of(root() / "twice"), bytes_of(root() / "whole"));
}

// The second one says so, and the first one's answers stay.
TEST_F(Interrupted, TwoProcessesDoNotCalibrateIntoOneFolder) {
  const fs::path out = root() / "shared";
  fs::create_directories(out);
  const int folder = open(out.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(flock(folder, LOCK_EX | LOCK_NB), 0);  // as the other process does
  exact_set("one");
  exact_set("two");
  const std::string command =
      "calibrate " + path("one") + " " + path("two") + " --model f --out " + path("shared");
  expect_bad_input(command, {"shared: another process is writing it"});
  EXPECT_TRUE(fs::is_empty(out));
  close(folder);
  EXPECT_EQ(run(command).exit_code, 0);
}

// Killed at any moment, a command leaves the old file or the new one.
TEST_F(Interrupted, AKilledCommandLeavesTheOldFileOrTheNewOne) {
  const std::string command = "detect " + path("set") + " --no-cache --out ";
  using std::chrono::milliseconds;
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(run(command + path("new.csv")).exit_code, 0);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
  const int step = std::max(10, static_cast<int>(took.count() / 30));  // under sanitizers
  const std::string corners = slurp(root() / "new.csv");
  int num_new = 0, num_old = 0;
  for (int ms = 0; ms < 100 * step && num_new < 3; ms += step) {
    spill(root() / "killed.csv", "old");
    CliProcess process(command + path("killed.csv") + " >/dev/null 2>&1");
    std::this_thread::sleep_for(milliseconds(ms));
    process.send(SIGKILL);
    process.wait();
    const std::string left = slurp(root() / "killed.csv");
    EXPECT_TRUE(left == "old" || left == corners) << ms << " ms: " << left.size() << " bytes";
    (left == "old" ? num_old : num_new) += 1;
  }
  EXPECT_GT(num_old, 0);
  EXPECT_EQ(num_new, 3);
}

// A fleet whose second data set is an open pipe: the run waits there, and is killed.
TEST_F(Interrupted, CalibrateGoesOnWithTheDataSetsThatAreLeft) {
  for (const char* name : {"left", "middle", "right"}) exact_set(name);
  const std::string sets = path("left") + " " + path("middle") + " " + path("right");
  const std::string command =
      "calibrate " + sets + " --model f --threads 1 --resume --out " + path("fleet");
  const fs::path corners = root() / "middle/observations_exact.csv";
  const std::string text = slurp(corners);
  fs::remove(corners);
  ASSERT_EQ(mkfifo(corners.c_str(), 0600), 0);
  const int pipe = open(corners.c_str(), O_RDWR | O_CLOEXEC);
  {
    CliProcess process(command + " >/dev/null 2>&1");
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!fs::exists(root() / "fleet/summary/left.json") &&
           std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    process.send(SIGKILL);
    EXPECT_EQ(process.wait(), 128 + SIGKILL);
  }
  close(pipe);
  fs::remove(corners);
  spill(corners, text);
  const auto time = fs::last_write_time(root() / "fleet/left.yaml");
  expect_bad_input(replaced(command, "--model f", "--model pinhole"),
                   {"fleet", "made with other options"});
  // Damaged outcomes are none.
  spill(root() / "fleet/summary/middle.json", std::string(1'000'000, '['));
  spill(root() / "fleet/summary/right.json", R"({"inputs": 1, "row": "x"})");
  const Outcome resumed = good_run(command);
  EXPECT_EQ(fs::last_write_time(root() / "fleet/left.yaml"), time);
  EXPECT_EQ(std::count(resumed.out.begin(), resumed.out.end(), '\n'), 4) << resumed.out;
  EXPECT_EQ(bytes_of(root() / "fleet").size(), 7u);  // 3 calibrations and summaries, and the lock

  expect_bad_input("calibrate " + path("left") + " --resume --out " + path("one.yaml"),
                   {"--resume", "several data sets"});
}

}  // namespace
}  // namespace tagcal::tools
