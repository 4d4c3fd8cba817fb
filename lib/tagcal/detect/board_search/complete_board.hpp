#pragma once

#include <vector>

#include "tagcal/detect/board_search/completion.hpp"
#include "tagcal/scene/board.hpp"

// Private to detect.
namespace tagcal::internal {

// The tags of a board, from those that a detector found.
//  1. Each found tag is compared with the picture: wrong corners are corrected, and a tag whose
//     cells have other colours is dropped.
//  2. Every other tag is predicted by the homography of the nearest tags in its plane, moved to the
//     highest correlation with its pattern, read, and added if border, frame and bits agree. It
//     predicts further tags, until none is added.
//  3. If tags next to missing ones are not where the others predict them, or were read but not
//     refined, a lens may bend the panel too strongly: the others are found under it (BentPanel).
//  4. A tag that no other tag of its plane confirms is dropped if its code is likely to be read by
//     chance: in small families, or with wrong bits.
// Tags of other boards in `found` are ignored. `family` has the border of the board; ids beyond the
// family are missing with other_bits.
Completion complete_board(const ImageView8& image, const Board& board, const TagFamily& family,
                          const std::vector<FoundTag>& found, const CompletionRules& rules);

}  // namespace tagcal::internal
