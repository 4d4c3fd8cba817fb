#include "job/warning_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace tagcal::tools {
namespace {

// The name that a warning begins with, up to the first colon; "" without one.
std::string name_of(const std::string& warning) {
  const std::size_t colon = warning.find(": ");
  return colon == std::string::npos ? "" : warning.substr(0, colon);
}

// What is left without name and numbers: ": # tags on no board: tag36h11 #".
std::string kind_of(const std::string& warning) {
  constexpr std::string_view kDigits = "0123456789", kWithin = "0123456789., ";
  const std::string text = warning.substr(name_of(warning).size());
  std::string kind;
  for (std::size_t i = 0; i < text.size();) {
    if (kDigits.find(text[i]) == kDigits.npos) {
      kind += text[i++];
      continue;
    }
    const std::size_t end = std::min(text.find_first_not_of(kWithin, i), text.size());
    i = text.find_last_of(kDigits, end - 1) + 1;
    kind += '#';
  }
  return kind;
}

// A line that stands for one warning or for many alike.
struct Line {
  std::size_t index = 0;  // of the first warning
  std::string text;
};

// "; and 4 more like it: b.png, c.png, .."
std::string others(const std::vector<std::string>& names) {
  std::vector<std::string> shown;
  for (const std::string& name : names)
    if (std::ranges::find(shown, name) == shown.end() && shown.size() < 4) shown.push_back(name);
  std::string text = fmt::format("; and {} more like it", names.size() - 1);
  for (std::size_t i = 1; i < shown.size(); ++i)
    text += (i == 1 ? ": " : ", ") + (i < 3 ? shown[i] : "..");
  return text;
}

std::vector<Line> lines_of(const std::vector<std::string>& warnings) {
  constexpr std::size_t kLeast = 3;
  struct Group {
    std::size_t first = 0;
    std::vector<std::string> names;
  };
  std::map<std::string, Group> groups;
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    const std::string name = name_of(warnings[i]);
    if (name.empty()) continue;
    groups.try_emplace(kind_of(warnings[i]), i).first->second.names.push_back(name);
  }
  std::vector<Line> lines;
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    const auto group = groups.find(kind_of(warnings[i]));
    if (group == groups.end() || group->second.names.size() < kLeast)
      lines.push_back({i, warnings[i]});
    else if (group->second.first == i)
      lines.push_back({i, warnings[i] + others(group->second.names)});
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
