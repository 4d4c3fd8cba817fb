#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// Why a tag of a board is not reported.
enum class WhyNot {
  no_neighbour,  // no other tag of its plane was found, so its place is unknown
  outside,       // outside the picture, wholly or in part
  too_small,     // its cells are smaller than pixels
  no_contrast,   // the picture is flat at its place
  no_border,     // no black border with white around it: hidden, or not there
  other_bits,    // a border, but not the bits of this tag
  no_edges,      // its edges cannot be fitted: too blurred
  no_fit,        // its pattern cannot be fitted, so its corners are unreliable
  alone,         // no other tag confirms it, and its code is likely to be read by chance
};
std::string_view why_not_text(WhyNot why);

struct MissingTag {
  int id = 0;
  WhyNot why = WhyNot::no_neighbour;
  std::optional<Quad> expected;  // its predicted place, px
};

struct Completion {
  std::vector<FoundTag> tags;       // by id: found ones that were kept, and added ones
  std::vector<int> added;           // ids, in the order in which they were found
  std::vector<MissingTag> missing;  // by id
};

struct CompletionRules {
  int max_hamming = 1;     // wrong bits accepted in a tag
  std::set<int> excluded;  // ids that are not looked for
  // Refines a tag's corners known to 2 px; no value if they cannot be fitted.
  std::function<std::optional<FoundTag>(int id, const Quad& start)> refine;
};

// The tags of a board, from those that a detector found.
//  1. Each found tag is compared with the picture: wrong corners are corrected, and a tag whose
//  cells
//     have other colours is dropped.
//  2. Every other tag is predicted by the homography of the nearest tags in its plane (so that a
//     strong lens does not matter), moved to the highest correlation with its pattern, read, and
//     added if border, frame and bits agree. It predicts further tags, until none is added.
//  3. A tag that no other tag of its plane confirms is dropped if its code is likely to be read by
//     chance: in small families, or with wrong bits.
// Tags of other boards in `found` are ignored. `family` has the border of the board; ids beyond the
// family are missing with other_bits.
Completion complete_board(const ImageView8& image, const Board& board, const TagFamily& family,
                          const std::vector<FoundTag>& found, const CompletionRules& rules);

}  // namespace tagcal::internal
