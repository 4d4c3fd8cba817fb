#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "tagcal/language.hpp"

namespace tagcal {

// Bad input. The message is one line for the user and names the file, the key and the value, e.g.
// "desk.yaml: boards[1].tag_size: must be > 0, got -0.03". Thrown by io, detect and by constructors
// whose arguments come from a user; an estimate that fails says so in its status instead.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string message) : std::runtime_error(one_line(std::move(message))) {}

 private:
  // Names of files and values of keys may have line breaks: each becomes a space. Of a message with
  // a name of thousands of characters the middle is left out.
  static std::string one_line(std::string message) {
    for (char& c : message)
      if (c == '\n' || c == '\r') c = ' ';
    constexpr std::size_t kHalf = 500;  // bytes; chosen by hand, longer than names that help
    if (message.size() > 2 * kHalf) message.replace(kHalf, message.size() - 2 * kHalf, " ... ");
    return message;
  }
};

}  // namespace tagcal
