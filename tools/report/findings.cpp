#include "report/findings.hpp"

#include <nlohmann/json.hpp>

namespace tagcal::tools {

nlohmann::ordered_json findings_json(std::span<const Finding> findings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings)
    list.push_back({{"code", finding.code},
                    {"severity", severity_name(finding.severity)},
                    {"sentence", finding.sentence}});
  return list;
}

std::string findings_text(std::span<const Finding> findings, const std::string& indent) {
  std::string text;
  for (const Finding& finding : findings)
    text += indent + (finding.severity == Severity::note ? "note: " : "warning: ") +
            finding.sentence + "\n";
  return text;
}

}  // namespace tagcal::tools
