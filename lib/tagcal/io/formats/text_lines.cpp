#include "tagcal/io/formats/text_lines.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

TextLines::TextLines(std::string file, std::string_view text)
    : file_(std::move(file)), rest_(text) {}

bool TextLines::next(bool blank_counts) {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    words_ = words_of(line_);
    const bool comment = !words_.empty() && words_[0].starts_with('#');
    if (!comment && (blank_counts || !words_.empty())) return true;
  }
  words_.clear();
  line_ = {};
  return false;
}

double TextLines::number(std::size_t i, std::string_view what) const {
  if (i >= words_.size()) fail(fmt::format("{}: is missing", what));
  const auto value = parse_number(words_[i]);
  if (!value) fail(fmt::format("{}: must be a finite number, got {}", what, shown(words_[i])));
  return *value;
}

int TextLines::whole(std::size_t i, std::string_view what, int low, int high) const {
  if (i >= words_.size()) fail(fmt::format("{}: is missing", what));
  const auto value = parse_whole(words_[i]);
  if (!value || *value < low || *value > high)
    fail(fmt::format("{}: must be a whole number from {} to {}, got {}", what, low, high,
                     shown(words_[i])));
  return *value;
}

void TextLines::fail(const std::string& message) const {
  throw Error(fmt::format("{}: line {}: {}", file_, number_, message));
}

}  // namespace tagcal::internal
