#include "studies/studies.hpp"

#include <ctime>
#include <fstream>

#include "study/chart/chart.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
namespace {

std::string processor_name() {
  std::ifstream lines("/proc/cpuinfo");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("model name"))
      if (const std::size_t at = line.find(": "); at != std::string::npos)
        return line.substr(at + 2);
  return "unknown processor";
}

// UTC, as 2026-01-31.
std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[16] = {};
  std::strftime(text, sizeof text, "%Y-%m-%d", &parts);
  return text;
}

}  // namespace

std::vector<std::string> origin_of(const std::string& command) {
  return {command, "tagcal " TAGCAL_VERSION, study::peers_versions(), processor_name(), today()};
}

}  // namespace tagcal::tools
