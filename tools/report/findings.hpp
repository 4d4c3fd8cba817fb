#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

namespace tagcal::tools {

// [{code, severity, sentence}, ..]
nlohmann::ordered_json findings_json(std::span<const Finding> findings);

// A line or more per finding, many alike as one (in_groups): "note: ..", or "! .." for warnings and
// refusals; at most 100 columns.
std::string findings_text(std::span<const Finding> findings, const std::string& indent = "");

// The first refusal, which the verdict gives as its reason (null: none), and all other findings.
const Finding* reason_of(std::span<const Finding> findings);
std::vector<Finding> without_reason(std::span<const Finding> findings);

// The starts of a verdict, "OK: " or "OK, 2 warnings: " (as many as findings_text has lines), and
// "NO ANSWER: .." with the reason; and the lines of a verdict, which begins with one of the two.
std::string ok_text(std::span<const Finding> findings);
std::string no_answer_text(Status status, std::span<const Finding> findings);
std::string verdict_lines(const std::string& verdict, Status status,
                          std::span<const Finding> findings);

}  // namespace tagcal::tools
