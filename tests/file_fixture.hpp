#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "expect.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/random.hpp"

// Helpers of the tests of files.

namespace tagcal {

namespace fs = std::filesystem;

// A folder of its own for every test, removed at the end.
class FileTest : public testing::Test {
 protected:
  FileTest() {
    std::string name = (fs::temp_directory_path() / "tagcal-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~FileTest() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;  // faster than write_whole's fsync
    return folder_ / name;
  }

  // The message, of one line, of the Error that `f` throws about a file, behind the file's path.
  template <typename F>
  static std::string error_about(const std::string& path, F&& f) {
    const std::string message = error_of(f);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message.starts_with(path) ? message.substr(path.size()) : "names no file: " + message;
  }

  std::size_t num_files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

// A change of a good file that makes it bad, and what the message must then say after the name.
struct BadFile {
  std::string from;
  std::string to;
  std::string message;
};

// Bytes changed, put in, taken out and parts copied over others, at random.
inline std::string mutated(std::string text, Random& random) {
  static const std::string kBytes = "[]{},:-\"'#&*?|>%@!~ \n\t\\.0123456789eE+naif\xff\xc3\x01";
  const std::size_t num_changes = 1 + random.index(4);
  for (std::size_t i = 0; i < num_changes && !text.empty(); ++i) {
    const std::size_t at = random.index(text.size());
    const std::size_t length = 1 + random.index(12);
    switch (random.index(4)) {
      case 0:
        text[at] = kBytes[random.index(kBytes.size())];
        break;
      case 1:
        text.insert(at, 1, kBytes[random.index(kBytes.size())]);
        break;
      case 2:
        text.erase(at, length);
        break;
      default:
        text.insert(at, text.substr(random.index(text.size()), length));
    }
  }
  return text;
}

inline bool same(const Pose& a, const Pose& b) {
  return a.rotation().coeffs() == b.rotation().coeffs() && a.translation() == b.translation();
}

// Its numbers differ by twelve orders of magnitude.
inline Pose pose_of_many_sizes(Random& random) {
  const Eigen::Quaterniond q(random.normal(), random.normal(), random.normal(), random.normal());
  return {q, {random.normal(), random.normal() * 1e-7, random.normal() * 1e5}};
}

}  // namespace tagcal
