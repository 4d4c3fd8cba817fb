#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "page_data/json_values.hpp"

namespace tagcal::tools {

// The page as one HTML file. Bytes that are not UTF-8 are replaced, and "<" is escaped, so that no
// text of the data can end the script that holds them.
std::string html_page(const PageJson& data);

// Throws Error before any work if the page certainly cannot be written, or would replace one of the
// inputs.
void check_page(const std::filesystem::path& out, const std::vector<std::string>& inputs);

// Writes the page whole or not at all, and says so.
void write_page(const std::filesystem::path& out, const PageJson& data);

}  // namespace tagcal::tools
