#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/kind_search.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

// The kinds of tags that a picture of these boards may show instead of theirs: all families and
// borders, and OpenCV's dictionaries if a board has one.
std::vector<TagKind> kinds_beside(const std::vector<PlacedBoard>& boards);

// All kinds that a target may have, the largest dictionary of each series for all of its markers.
std::vector<TagKind> kinds_of_all_targets();

// The smallest dictionary of a series that has an id.
std::string smallest_dictionary_with(const std::string& dictionary, int id);

// Keeps the tags that were surely read as their kind.
void keep_sure(const ImageView8& image, std::vector<TagsOfKind>& kinds);

// The mistake in the kind of a board's tags, by the tags that surely were read of each kind; or a
// picture that is mirrored, or light on dark. `nothing_found`: of the board.
std::optional<TargetMistake> kind_mistake(const ImageView8& image, const Board& board,
                                          const std::vector<TagsOfKind>& sure, bool nothing_found);

}  // namespace tagcal::internal
