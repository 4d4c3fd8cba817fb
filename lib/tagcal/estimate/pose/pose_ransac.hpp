#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/estimate/pose/view_equations.hpp"

namespace tagcal::internal {

// A view of which some correspondences are wrong.
struct RobustView {
  const Lens& lens;             // of pose with focal length: a pinhole, whose focal length is free
  ViewPoints view;              // points about their centre
  std::span<const int> groups;  // equal numbers are right or wrong together; or empty
  double sigma_px = 1;          // noise per coordinate; whitened: 1
  std::uint64_t seed = 0;
  double least_share = 0;  // of inliers that are worth the search
};

struct ViewConsensus {
  ViewState state;                   // refined on the inliers
  std::vector<std::size_t> inliers;  // ascending
  int num_samples = 0;               // that it took
};

// Locally optimised random sample consensus (Chum, Matas & Kittler, DAGM 2003) with a truncated
// squared loss (Torr & Zisserman, CVIU 2000). Samples are whole groups (the four corners of a tag)
// and single points, in turn: three of them (p3p), with the focal length four (p4pf, or in a plane
// the closed form). It ends when a better consensus has been missed with a probability below 1e-4,
// by the share of inliers. No value where the best one could have come about by chance: where among
// all samples taken that many of n corners would agree, each by the share of the image that a
// corner's tolerance covers (or the density of corners around it has), with a probability above
// 1e-5.
// N = 6: pose, 7: pose and focal length.
template <int N>
std::optional<ViewConsensus> find_view_consensus(const RobustView& view);

extern template std::optional<ViewConsensus> find_view_consensus<6>(const RobustView&);
extern template std::optional<ViewConsensus> find_view_consensus<7>(const RobustView&);

}  // namespace tagcal::internal
