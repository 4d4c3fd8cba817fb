#pragma once

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/complete_board.hpp"

// Private to detect.
namespace tagcal::internal {

// Lenses may bend tags beyond what the fit of one tag allows for. The tags of a panel together show
// its lens: those that could not be fitted, or only corner by corner, are fitted again under it.
// Where a panel shows too few tags for that, they stay as they are.
void fit_under_lens(const Image8& image, const Board& board, const FamilyDetector& detector,
                    Completion& completion);

}  // namespace tagcal::internal
