#pragma once

#include <vector>

#include "tagcal/scene/surfaces.hpp"

namespace tagcal::internal {

using SheetGroup = std::vector<std::size_t>;

// All sheets in groups, each group before those that it hides. Sheets that hide each other in turn
// and sheets with a common edge, such as the faces of a box, are one group (strongly connected
// components, Tarjan 1972).
std::vector<SheetGroup> groups_from_near(const Shadows& shadows);

}  // namespace tagcal::internal
