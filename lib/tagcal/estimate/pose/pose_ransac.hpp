#pragma once

#include "tagcal/estimate/pose/ransac.hpp"
#include "tagcal/estimate/pose/view_equations.hpp"

namespace tagcal::internal {

// A view with wrong correspondences.
struct RansacProblem {
  const Lens& lens;             // with focal length: a pinhole, whose focal length is free
  ViewPoints view;              // points about their centre
  std::span<const int> groups;  // tag of each point, sampled as a whole; or empty
  double sigma_px = 1;          // noise per coordinate; whitened: 1
  std::uint64_t seed = 0;
  double least_share = 0;  // of inliers below which the search may miss a consensus
  std::span<const std::size_t> known = {};  // inliers of another pose, ascending
};

using PoseConsensus = Consensus<ViewState>;

// Searches for the largest consensus (`ransac`, truncated squares). Minimal samples are three
// points (p3p), with the focal length four (p4pf, or in a plane the closed form); tags are sampled
// as a whole. No value if the best consensus may be chance: if the expected number of samples with
// as many inliers among wrong corners exceeds policy::kWrongConsensus. A wrong corner is an inlier
// with the probability of the area of its tolerance over that of the image, or of the density of
// corners around the tolerance. N = 6: pose, 7: pose and focal length.
template <int N>
std::optional<PoseConsensus> pose_ransac(const RansacProblem& view);

}  // namespace tagcal::internal
