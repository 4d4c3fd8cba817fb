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

std::string ok_text(std::span<const Finding> findings) {
  const auto count = static_cast<std::size_t>(
      std::ranges::count(in_groups(findings), Severity::warning, &Finding::severity));
  return count == 0 ? "OK: " : "OK, " + counted(count, "warning") + ": ";
}

std::string no_answer_text(Status status, std::span<const Finding> findings) {
  const Finding* const reason = reason_of(findings);
  return "NO ANSWER: " + (reason ? reason->sentence : std::string(status_name(status)));
}

std::string verdict_lines(const std::string& verdict, Status status,
                          std::span<const Finding> findings) {
  const std::size_t end = verdict.find(": ") + 1;
  const bool warns = std::ranges::count(findings, Severity::warning, &Finding::severity) > 0;
  const Tone tone = !is_answer(status) ? Tone::bad : warns ? Tone::caution : Tone::good;
  return wrapped(toned(tone, verdict.substr(0, end)) + " ", verdict.substr(end + 1), 2);
}

}  // namespace tagcal::tools
