#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tagcal::internal {

// The words of a line, between spaces, tabs and carriage returns.
std::vector<std::string_view> words_of(std::string_view line);

// The lines of a text file in words between spaces and tabs, with messages that name the line.
class TextLines {
 public:
  TextLines(std::string file, std::string_view text);

  // Goes to the next line that is no comment (#) and, unless `blank_counts`, not blank. Returns
  // false at the end.
  bool next(bool blank_counts = false);

  const std::vector<std::string_view>& words() const { return words_; }
  std::string_view line() const { return line_; }

  // Word i as a number. Throws Error, naming it `what`, unless it is a finite number.
  double number(std::size_t i, std::string_view what) const;
  int whole(std::size_t i, std::string_view what, int low, int high) const;

  [[noreturn]] void fail(const std::string& message) const;  // "FILE: line N: message"

 private:
  std::string file_;
  std::string_view rest_;
  std::string_view line_;
  std::vector<std::string_view> words_;
  std::size_t number_ = 0;
};

}  // namespace tagcal::internal
