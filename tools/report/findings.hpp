#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "tagcal/estimate/types.hpp"

namespace tagcal::tools {

// [{code, severity, sentence}, ..]
nlohmann::ordered_json findings_json(std::span<const Finding> findings);

// One line per finding: "note: .." or "warning: ..".
std::string findings_text(std::span<const Finding> findings, const std::string& indent = "");

}  // namespace tagcal::tools
