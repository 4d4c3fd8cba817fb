#pragma once

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/complete_board.hpp"

// Private to detect.
namespace tagcal::internal {

// A lens may bend tags beyond the model of a single tag's fit. Estimates the lens from all tags of
// a panel and fits those again under it that could not be fitted, or only corner by corner. Tags
// stay unchanged if a panel has too few of them.
void fit_under_lens(const ImageView8& image, const Board& board, const FamilyDetector& detector,
                    Completion& completion);

}  // namespace tagcal::internal
