#pragma once

namespace tagcal::internal {

// One function object of several lambdas, for std::visit.
template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};

}  // namespace tagcal::internal
