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
  no_neighbour,  // no tag of the same plane was found: nothing says where to look
  outside,       // of the picture, wholly or in part
  too_small,     // its cells are smaller than pixels
  no_contrast,   // the picture is flat where it should be
  no_border,     // no black border with white around it: hidden, or not there
  other_bits,    // something with a border, but not this tag
  no_edges,      // the tag is there, but its edges cannot be fitted: too blurred
  no_fit,        // the tag is there, but its pattern cannot be fitted: its corners are not known
  alone,         // of a small family, whose codes are read by chance, and no other tag supports it
};
std::string_view why_not_text(WhyNot why);

struct MissingTag {
  int id = 0;
  WhyNot why = WhyNot::no_neighbour;
  std::optional<Quad> expected;  // px, where it was looked for
};

struct Completion {
  std::vector<FoundTag> tags;       // by id: those found that stand, and those added
  std::vector<int> added;           // ids, in the order found
  std::vector<MissingTag> missing;  // by id
};

struct CompletionRules {
  int max_hamming = 1;     // wrong bits accepted in a tag
  std::set<int> left_out;  // ids that are not looked for
  // A tag's corners from ones known to 2 px; no value where they cannot be fitted.
  std::function<std::optional<FoundTag>(int id, const Quad& start)> refine;
};

// The tags of a board, from those that a detector found. First these are held against the picture
// themselves: one whose corners went astray is set right, or dropped where its cells do not answer.
// Then every other tag is predicted by the homography of the tags nearest to it in its plane (so
// that a strong lens does not matter), laid where the picture is most like its pattern, read, and
// added where border, frame and bits answer; from it the next ones are predicted, until nothing is
// added. A tag that no other tag of its plane predicts is dropped where chance would show its code
// too often: in small families, or with wrong bits. Tags of other boards in `found` are ignored.
// `family` has the border of the board; ids
// that it does not have are missing for their bits.
Completion complete_board(const Image8& image, const Board& board, const TagFamily& family,
                          const std::vector<FoundTag>& found, const CompletionRules& rules);

}  // namespace tagcal::internal
