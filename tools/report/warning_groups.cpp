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

// A line that stands for one warning or for many alike.
struct Line {
  std::size_t index = 0;  // of the first warning
  std::string text;
};

std::vector<Line> lines_of(const std::vector<std::string>& warnings) {
  constexpr std::size_t kLeast = 3;
  std::map<std::string, std::vector<std::string>> names;
  for (const std::string& warning : warnings)
    if (const std::string name = name_of(warning); !name.empty())
      names[kind_of(warning)].push_back(name);

  std::vector<Line> lines;
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    const std::string& warning = warnings[i];
    const auto group = names.find(kind_of(warning));
    if (group == names.end() || group->second.size() < kLeast) {
      lines.push_back({i, warning});
      continue;
    }
    const std::vector<std::string>& all = group->second;
    if (all.front() != name_of(warning)) continue;
    lines.push_back({i, fmt::format("{}; and {} more like it: {}, {}{}", warning, all.size() - 1,
                                    all[1], all[2], all.size() > 3 ? ", .." : "")});
  }
  return lines;
}

}  // namespace

std::vector<std::string> in_groups(const std::vector<std::string>& warnings) {
  std::vector<std::string> texts;
  for (Line& line : lines_of(warnings)) texts.push_back(std::move(line.text));
  return texts;
}

std::vector<Finding> in_groups(std::span<const Finding> findings) {
  std::vector<Finding> groups;
  for (Line& line : lines_of(sentences(findings))) {
    const Finding& first = findings[line.index];
    groups.push_back({first.code, first.severity, std::move(line.text)});
  }
  return groups;
}

}  // namespace tagcal::tools
