#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect: the tags of a board that are found in a picture, and why others are not.
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
  std::vector<MissingTag> missing;  // by id
};

struct CompletionRules {
  int max_hamming = 1;     // wrong bits accepted in a tag
  std::set<int> excluded;  // ids that are not looked for
  // Refines a tag's corners known to 2 px; no value if they cannot be fitted.
  std::function<std::optional<FoundTag>(int id, const Quad& start)> refine;
  // Fits a tag under a rough lens, from corners known to a third of a cell; empty: no lens is taken
  // into account.
  std::function<std::optional<FoundTag>(int id, const Quad& start, const Camera& camera)> fit_under;
};

// Reason why the picture does not show a tag at a place.
std::optional<WhyNot> reason_to_reject(const ImageView8& image, const Quad& quad,
                                       const TagCells& cells, int most_wrong_bits);

}  // namespace tagcal::internal
