#pragma once

// Every number that decides an uncertainty or a sentence about it, as estimate/policy/policy.hpp.

namespace tagcal::internal::policy {

// Parts of the image without corners (seen_region.cpp): a corner of the image counts as seen if the
// point at this share of width and height from it is in the hull. Chosen by hand.
inline constexpr double kCornerInset = 0.2;

}  // namespace tagcal::internal::policy
