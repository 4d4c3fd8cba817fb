#pragma once

#include <string_view>
#include <vector>

#include "record.hpp"

namespace tagcal {

// The kinds of false diagnoses in this record, each once: findings that blame what is right in its
// world. A bent board in a world with a bend is no false diagnosis.
std::vector<std::string_view> false_diagnoses(const Record& record);

}  // namespace tagcal
