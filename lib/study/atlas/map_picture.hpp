#pragma once

#include "study/atlas/stability.hpp"
#include "study/chart/corner_methods.hpp"

// Maps of failure of tags in pictures. Private to study.

namespace tagcal::study {

// A corner that is claimed by no covariance is taken for one of this standard deviation: of ours,
// what the estimators take it for; of the peers, no less than that beyond the bound.
inline constexpr double kUnclaimedSigmaPx = 0.5, kLeastPeerCornerSigmaPx = 0.1;

// A tag must be read where it is at least so wide, and its narrowest cells are at least so many
// standard deviations of the blur (that of a pixel's square included).
inline constexpr double kReadableSidePx = 12, kReadableCellOverBlur = 2;

bool is_readable(const TagViewSpec& spec);

// Wrong is an answer of which a corner is outside of its 5-sigma ellipse.
StabilityVerdict judge_corners(const std::optional<CornerAnswer>& answer, const CornerTask& task,
                               bool ours);

StabilityMap tag_size_blur_map();
StabilityMap tag_tilt_noise_map();

std::vector<StabilityMap> picture_maps();

}  // namespace tagcal::study
