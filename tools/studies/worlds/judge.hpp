#pragma once

#include "draw.hpp"
#include "record.hpp"

namespace tagcal {

// Renders the world, finds its corners, calibrates with `auto`, and compares the results with the
// truth, on one thread. Times are processor times of this thread.
Record judge(const World& world);

}  // namespace tagcal
