#pragma once

#include <vector>

#include "tagcal/estimate/calibration/candidates.hpp"

namespace tagcal::internal {

// The report's steps: each candidate, why it was taken or not.
std::vector<ModelStep> steps_of(const std::vector<Candidate>& candidates, std::size_t answer,
                                const Posterior& posterior);

// Steps of the models nested in a perspective, whose kind lost against the posterior's. `more`: the
// chi-square of that kind above the posterior's.
std::vector<ModelStep> steps_of_loser(const Posterior& loser, double more,
                                      const Posterior& posterior);

}  // namespace tagcal::internal
