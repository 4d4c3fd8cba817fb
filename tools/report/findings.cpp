#include "report/findings.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "job/terminal.hpp"
#include "job/warning_groups.hpp"

namespace tagcal::tools {

nlohmann::ordered_json findings_json(std::span<const Finding> findings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings)
    list.push_back({{"code", finding.code},
                    {"severity", severity_name(finding.severity)},
                    {"sentence", finding.sentence}});
  return list;
}

const Finding* reason_of(std::span<const Finding> findings) {
  const auto reason = std::ranges::find(findings, Severity::refusal, &Finding::severity);
  return reason == findings.end() ? nullptr : &*reason;
}

std::vector<Finding> without_reason(std::span<const Finding> findings) {
  const Finding* const reason = reason_of(findings);
  std::vector<Finding> others;
  for (const Finding& finding : findings)
    if (&finding != reason) others.push_back(finding);
  return others;
}

std::string findings_text(std::span<const Finding> findings, const std::string& indent) {
  std::string text;
  for (const Finding& finding : in_groups(findings)) {
    const bool is_note = finding.severity == Severity::note;
    const std::string mark = is_note ? "note: " : toned(Tone::caution, "! ");
    text += wrapped(indent + mark, finding.sentence, indent.size() + 2);
  }
  return text;
}

}  // namespace tagcal::tools
