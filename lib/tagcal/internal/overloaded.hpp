#pragma once

namespace tagcal::internal {

// One function object of several lambdas, for std::visit.
template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
// Clang before 17 does not deduce it for an aggregate.
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

}  // namespace tagcal::internal
