#pragma once

#include "measure.hpp"

namespace tagcal {

// Takes the world's corners from pictures or by projection, calibrates with `auto` and with the
// model that made the data, and compares the results with the truth, on one thread.
Record judge(const World& world);

}  // namespace tagcal
