#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/pose/pose_minima.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"

namespace tagcal::internal {

// The least-squares fit of all correspondences that agree with it, or why there is none.
template <int N>
struct AgreeingFit {
  std::optional<PoseProblem> problem;  // of the inliers
  std::optional<ViewFit<N>> fit;
  std::vector<std::size_t> outliers;  // ascending
  bool model_error = false;           // the residuals are no noise: the warnings say so
  Status status = Status::ok;         // else: why there is no fit
  std::vector<std::string> warnings;
};

// Fits all correspondences; where they do not agree, searches for those that do. Residuals larger
// than the noise that is stated or assumed raise it (and a warning says so), up to five times;
// beyond that there is no fit: no_consensus.
template <int N>
AgreeingFit<N> fit_agreeing(std::span<const Correspondence> correspondences, const Lens& lens,
                            const PoseOptions& options);

extern template AgreeingFit<6> fit_agreeing<6>(std::span<const Correspondence>, const Lens&,
                                               const PoseOptions&);
extern template AgreeingFit<7> fit_agreeing<7>(std::span<const Correspondence>, const Lens&,
                                               const PoseOptions&);

}  // namespace tagcal::internal
