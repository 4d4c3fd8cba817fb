#include "python/findings.hpp"

#include <algorithm>
#include <array>

namespace tagcal::python {
namespace {

struct Row {
  std::string_view option;
  std::string_view argument;
  bool has_value;  // a word that follows, which becomes the argument's in quotes
};

// tests/python/test_sentences.py checks that every option in a sentence of the library is here, and
// that the arguments exist.
constexpr std::array kRows = {
    Row{"--board-warp", "board_warp=True", false},
    Row{"--fix", "fixed", false},
    Row{"--focal", "start_focal_px", false},
    Row{"--image-size", "tagcal convert --image-size", false},  // Python has none
    Row{"--keep-all", "reject_outliers=False", false},
    Row{"--model", "model=", true},
    Row{"--mount", "mount=", true},
    Row{"--pair time:find", "find_clocks=True", false},
    Row{"--robot-format", "columns", false},
    Row{"--shutter rolling", "times_s", false},
    Row{"--sigma-px", "sigma_px", false},
    Row{"--start", "start", false},
    Row{"--time-offset find", "find_time_offset=True", false},
    Row{"--tolerance", "tolerance_px", false},
};

bool is_of_option(char c) { return c == '-' || (c >= 'a' && c <= 'z'); }
bool ends_value(char c) { return std::string_view(" ,;:)").find(c) != std::string_view::npos; }

const Row* row_at(std::string_view text) {
  const auto starts = [&](const Row& row) {
    const std::size_t end = row.option.size();
    return text.starts_with(row.option) && (text.size() == end || !is_of_option(text[end]));
  };
  const auto row = std::ranges::find_if(kRows, starts);
  return row == kRows.end() ? nullptr : &*row;
}

}  // namespace

std::string in_python(std::string_view sentence) {
  std::string result;
  for (std::size_t i = 0; i < sentence.size();) {
    if (sentence.substr(i).starts_with("tagcal ")) return result + std::string(sentence.substr(i));
    const bool is_start = i == 0 || sentence[i - 1] == ' ' || sentence[i - 1] == '(';
    const Row* row = is_start ? row_at(sentence.substr(i)) : nullptr;
    if (!row) {
      result += sentence[i++];
      continue;
    }
    result += row->argument;
    i += row->option.size();
    if (!row->has_value) continue;
    if (i < sentence.size()) ++i;  // the space
    result += '"';
    while (i < sentence.size() && !ends_value(sentence[i])) result += sentence[i++];
    result += '"';
  }
  return result;
}

std::vector<std::string> in_python(const std::vector<std::string>& sentences) {
  std::vector<std::string> result;
  for (const std::string& sentence : sentences) result.push_back(in_python(sentence));
  return result;
}

}  // namespace tagcal::python
