#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

// Text of files and other programs. Names of pictures are bytes: they may have line ends, control
// characters, and bytes that are not UTF-8.

namespace tagcal::tools {

// JSON with a line end. What is not UTF-8 becomes U+FFFD. An indent of -1: all in one line.
std::string json_text(const nlohmann::ordered_json& value, int indent = 2);

// The rows of CSV with a header, each an object: numbers, and null for an empty field. `texts`: the
// columns whose fields stay texts whatever they look like, because 007 and 7 are two names.
nlohmann::ordered_json rows_json(std::string_view csv, const std::vector<std::string>& texts);

// The text as one line of UTF-8: "?" for each control character, U+FFFD as in JSON.
std::string one_line_text(std::string_view text);

// The same for the content of an element of XML, or of an attribute in double quotes.
std::string xml_text(std::string_view text);

}  // namespace tagcal::tools
