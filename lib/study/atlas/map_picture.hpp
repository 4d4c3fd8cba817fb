#pragma once

#include "study/atlas/stability.hpp"
#include "study/chart/corner_methods.hpp"

// Maps of failure of tags in pictures. Private to study.

namespace tagcal::study {

// Standard deviation that is added to the bound for a corner of the peers, which have none of their
// own; ours have that of the estimators (policy::kAssumedSigmaPx).
inline constexpr double kLeastPeerCornerSigmaPx = 0.1;

// A tag must be read if it is at least this wide, and if its narrowest cells are at least this many
// standard deviations of the blur (including that of a pixel's square).
inline constexpr double kReadableSidePx = 12, kReadableCellOverBlur = 2;

bool is_readable(const TagViewSpec& spec);

// An answer is wrong if a corner is outside of its 5-sigma ellipse.
StabilityVerdict judge_corners(const std::optional<CornerAnswer>& answer, const CornerTask& task,
                               bool ours);

StabilityMap tag_size_blur_map();

std::vector<StabilityMap> picture_maps();

}  // namespace tagcal::study
