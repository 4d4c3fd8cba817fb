#pragma once

#include <optional>

#include "tagcal/estimate/checks/evidence.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal::internal {

// How the board differs from its file: notes of what the answer includes, warnings of a shape that
// its substrate does not have, which the answer includes, too.
std::optional<Finding> check_bend(const BoardWarp& board, const FlatBoard& flat);
std::optional<Finding> check_print(const BoardWarp& board, const FlatBoard& flat);

}  // namespace tagcal::internal
