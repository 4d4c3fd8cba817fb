#pragma once

#include <nlohmann/json.hpp>
#include <sstream>

#include "cli_fixture.hpp"

namespace tagcal::tools {

// The data in a page.
inline nlohmann::json data_of_page(const fs::path& file) {
  const std::string text = slurp(file);
  const std::string start = "<script type=\"application/json\" id=\"data\">";
  const std::size_t from = text.find(start) + start.size();
  return nlohmann::json::parse(text.substr(from, text.find("</script>", from) - from));
}

// A text without the line ends of wrapping.
inline std::string unwrapped(const std::string& text) {
  std::istringstream words(text);
  std::string all, word;
  while (words >> word) all += (all.empty() ? "" : " ") + word;
  return all;
}

}  // namespace tagcal::tools
