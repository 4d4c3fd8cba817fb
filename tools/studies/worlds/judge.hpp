#pragma once

#include "draw.hpp"
#include "record.hpp"

namespace tagcal {

// Renders the world, finds its corners, calibrates by `auto`, and holds all against the truth; by
// one thread. The time is that of this thread's processor.
Record judge(const World& world);

}  // namespace tagcal
