#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "expect.hpp"

namespace tagcal::tools {

namespace fs = std::filesystem;

// Exit code and output of a run of the command.
struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

inline std::string slurp(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void spill(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

// Words that are numbers are compared as numbers.
inline void expect_same_text(const std::string& expected, const std::string& actual,
                             double tolerance, double relative_tolerance) {
  std::istringstream expected_words(expected), actual_words(actual);
  std::string e, a;
  while (expected_words >> e) {
    ASSERT_TRUE(actual_words >> a) << "missing: " << e;
    char* end = nullptr;
    const double number = std::strtod(e.c_str(), &end);
    if (*end == '\0')
      EXPECT_NEAR(std::stod(a), number, tolerance + relative_tolerance * std::abs(number));
    else
      EXPECT_EQ(e, a);
  }
  EXPECT_FALSE(actual_words >> a) << "too much: " << a;
}

// Standard error without the lines of progress, which a slow machine (or a build under sanitizers)
// prints after the first second.
inline std::string without_progress(const std::string& err) {
  static const std::regex progress(R"(^[a-z ]+: \d+ (of \d+(, .*)?|s|min \d+ s)\n)",
                                   std::regex::ECMAScript | std::regex::multiline);
  return std::regex_replace(err, progress, "");
}

inline constexpr const char* kScene = R"(
camera: {image_size: [640, 400], model: radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]}
boards:
  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 3, tagSize: 0.06, tagSpacing: 0.3, border_bits: 1, corner_squares: false}
path: {type: dome, target_m: [0.14, 0.1, 0], min_distance_m: 0.45, max_distance_m: 0.6, min_elevation_deg: 45, max_elevation_deg: 80}
jitter: {target_m: 0.02, roll_deg: 20}
views: 6
sensor: {blur_px: 0.7, noise_levels: 2}
)";

// A folder of its own, with one small data set rendered for all tests.
class Cli : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    root() = fs::temp_directory_path() / ("tagcal-cli-test-" + std::to_string(getpid()));
    fs::remove_all(root());  // of a killed process with the same number
    fs::create_directories(root());
    spill(root() / "scene.yaml", kScene);
    good_run("render " + path("scene.yaml") + " --out " + path("set"));
  }
  static void TearDownTestSuite() { fs::remove_all(root()); }

  static fs::path& root() {
    static fs::path folder;
    return folder;
  }
  static std::string path(const std::string& name) { return (root() / name).string(); }

  // The program, which tools/test.sh --valgrind runs under another one.
  static std::string program() {
    const char* const under = std::getenv("TAGCAL_TEST_UNDER");
    return std::string(under == nullptr ? "" : under) + " " + TAGCAL_COMMAND;
  }

  static Outcome run(const std::string& arguments) {
    const std::string out = path("stdout.txt");
    const std::string err = path("stderr.txt");
    std::string line = program();
    line.append(" ").append(arguments).append(" >").append(out).append(" 2>").append(err);
    line.append(" </dev/null");
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err)};
  }

  // A run that must end with exit 0; otherwise the test ends.
  static Outcome good_run(const std::string& arguments) {
    const Outcome outcome = run(arguments);
    if (outcome.exit_code != 0)
      throw std::runtime_error("tagcal " + arguments + ": exit " +
                               std::to_string(outcome.exit_code) + "\n" + outcome.err);
    return outcome;
  }

  // Exit 2, one line that names all of `parts`, nothing on stdout.
  static void expect_bad_input(const std::string& arguments,
                               const std::vector<std::string>& parts) {
    const Outcome outcome = run(arguments);
    const std::string err = without_progress(outcome.err);
    SCOPED_TRACE("tagcal " + arguments + "\n" + err);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(err.starts_with("tagcal: "));
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1);
    for (const std::string& part : parts) EXPECT_HAS(err, part);
  }

  // Every file below a folder, with its bytes.
  static std::map<std::string, std::string> bytes_of(const fs::path& folder) {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) {
        bytes[entry.path().lexically_relative(folder).string()] = slurp(entry.path());
      }
    }
    return bytes;
  }

  // A copy of the rendered set whose observations are the exact ones.
  static fs::path exact_set(const std::string& name) {
    const fs::path folder = root() / name;
    fs::remove_all(folder);
    fs::copy(root() / "set", folder, fs::copy_options::recursive);
    spill(folder / "dataset.yaml",
          "image_size: [640, 400]\ntarget: target.yaml\nobservations: observations_exact.csv\n"
          "truth: truth.yaml\n");
    return folder;
  }

  // Everything in the root, to see that a failed command leaves nothing behind.
  static std::vector<std::string> names() {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(root())) {
      const std::string name = entry.path().filename().string();
      if (name != "stdout.txt" && name != "stderr.txt") found.push_back(name);
    }
    std::sort(found.begin(), found.end());
    return found;
  }
};

}  // namespace tagcal::tools
