#pragma once

#include <string>
#include <vector>

// Words in scripts for gnuplot. Private to study.

namespace tagcal::study {

// As a string of gnuplot's, in single quotes.
std::string quoted(std::string text);

// Words up to so many letters a line.
std::vector<std::string> wrapped(const std::string& text, std::size_t width);

}  // namespace tagcal::study
