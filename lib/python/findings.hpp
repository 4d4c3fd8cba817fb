#pragma once

#include <string>

#include "tagcal/estimate/types.hpp"

namespace tagcal::python {

// The text of an estimate without an answer: its status and the sentence of its refusal.
std::string refusal(Status status, const std::vector<Finding>& findings);

// "; 2 warnings", or nothing.
std::string warnings_text(const std::vector<Finding>& findings);

}  // namespace tagcal::python
