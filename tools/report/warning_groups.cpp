#include "report/warning_groups.hpp"

#include <fmt/format.h>

#include <map>
#include <regex>

namespace tagcal::tools {
namespace {

// The name that a warning begins with, up to the first colon; "" without one.
std::string name_of(const std::string& warning) {
  const std::size_t colon = warning.find(": ");
  return colon == std::string::npos ? "" : warning.substr(0, colon);
}

// What is left without name and numbers: ": # tags on no board: tag36h11 #".
std::string kind_of(const std::string& warning) {
  static const std::regex numbers("[0-9]([0-9., ]*[0-9])?");
  return std::regex_replace(warning.substr(name_of(warning).size()), numbers, "#");
}

}  // namespace

std::vector<std::string> in_groups(const std::vector<std::string>& warnings) {
  constexpr std::size_t kLeast = 3;
  std::map<std::string, std::vector<std::string>> names;
  for (const std::string& warning : warnings)
    if (const std::string name = name_of(warning); !name.empty())
      names[kind_of(warning)].push_back(name);

  std::vector<std::string> lines;
  for (const std::string& warning : warnings) {
    const auto group = names.find(kind_of(warning));
    if (group == names.end() || group->second.size() < kLeast) {
      lines.push_back(warning);
      continue;
    }
    const std::vector<std::string>& all = group->second;
    if (all.front() != name_of(warning)) continue;
    lines.push_back(fmt::format("{}; and {} more like it: {}, {}{}", warning, all.size() - 1,
                                all[1], all[2], all.size() > 3 ? ", .." : ""));
  }
  return lines;
}

}  // namespace tagcal::tools
