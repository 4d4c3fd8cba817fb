#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

#include "tagcal/error.hpp"

// What the fuzz targets share. A target is a program with LLVMFuzzerTestOneInput: built by the
// preset `fuzz` it searches for inputs (tools/fuzz.sh), in every other build it replays the files
// of tests/fuzz/corpus/TARGET (replay_main.cpp), so that each finding stays a test.
namespace tagcal::fuzz {

// What must hold for every input.
inline void require(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: does not hold: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

// Runs `function`, which may refuse its input by tagcal::Error, in one line. Any other exception
// ends the program. Returns true if it was not refused.
template <typename Function>
bool is_accepted(Function&& function) {
  try {
    std::forward<Function>(function)();
    return true;
  } catch (const Error& error) {
    const std::string_view line = error.what();
    require(!line.empty(), "a refusal says something");
    require(line.find('\n') == std::string_view::npos, "a refusal is one line");
    require(line.size() < 2000, "a refusal is short");
    return false;
  }
}

// A folder of this process, removed at its end.
class Scratch {
 public:
  Scratch()
      : folder_(std::filesystem::temp_directory_path() /
                ("tagcal_fuzz_" + std::to_string(reinterpret_cast<std::uintptr_t>(this)) + "_" +
                 std::to_string(std::filesystem::hash_value(std::filesystem::current_path())))) {
    std::filesystem::create_directories(folder_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

  std::filesystem::path write(std::string_view name, std::string_view content) const {
    const std::filesystem::path file = folder_ / name;
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    return file;
  }

 private:
  std::filesystem::path folder_;
};

// Numbers out of the input, for problems that are not files; zeros after its end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  bool empty() const { return size_ == 0; }

  std::uint8_t byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  std::uint16_t two_bytes() {
    const unsigned low = byte();
    return static_cast<std::uint16_t>(low | unsigned{byte()} << 8U);
  }
  bool flag() { return byte() % 2 == 1; }

  // A whole number from `least` to `most`.
  int whole(int least, int most) { return least + two_bytes() % (most - least + 1); }

  // A number between the bounds, in steps of 1/65535 of their distance.
  double number(double least, double most) {
    return least + (most - least) * two_bytes() / 65535.0;
  }

  // Any number that a program may pass: mostly one between the bounds, at times an extreme one.
  double wild(double least, double most) {
    constexpr double kExtremes[] = {0.0,   -0.0,   1e-310, 1e-150,   -1e-20,    1e20,
                                    1e150, -1e300, 1e308,  HUGE_VAL, -HUGE_VAL, NAN};
    const unsigned kind = byte();
    if (kind < 244) return number(least, most);
    return kExtremes[255 - kind];
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

// An input of two files, which a line `--8<--` parts; the second is empty without it.
inline std::pair<std::string_view, std::string_view> two_files(std::string_view text) {
  constexpr std::string_view kCut = "\n--8<--\n";
  const std::size_t cut = text.find(kCut);
  if (cut == std::string_view::npos) return {text, {}};
  return {text.substr(0, cut + 1), text.substr(cut + kCut.size())};
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace tagcal::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
