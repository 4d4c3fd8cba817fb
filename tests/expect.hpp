#pragma once

// What tests expect of texts and of errors.

#include <gtest/gtest.h>

#include <string>

#include "tagcal/error.hpp"

#define EXPECT_HAS(text, part) EXPECT_PRED_FORMAT2(testing::IsSubstring, part, text)
#define EXPECT_LACKS(text, part) EXPECT_PRED_FORMAT2(testing::IsNotSubstring, part, text)
// `statement` throws an Error of this message.
#define EXPECT_ERROR(statement, message) EXPECT_EQ(tagcal::error_of([&] { statement; }), message)

namespace tagcal {

// The message of the Error that `f` throws; "no error" where it throws none.
template <typename F>
std::string error_of(F&& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// `message` is one line that begins with `start`.
inline void expect_line(const std::string& message, const std::string& start) {
  EXPECT_EQ(message.substr(0, start.size()), start) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace tagcal
