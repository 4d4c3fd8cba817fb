#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/kind_search.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/board.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect: mistakes of a target file that its pictures show.
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

// The names of the mistakes with which all corners may be found: of a ChArUco board's markers, and
// of the least id, which may move the whole board.
inline constexpr const char* kWrongMarkerSize = "wrong marker size";
inline constexpr const char* kWrongFirstId = "wrong first id";

using SeenQuads = std::map<int, Quad>;  // tags of a picture by id

// The tags of a view's corners; those with fewer than four corners are left out.
SeenQuads quads_of(const View& view);

// Compares the places of the tags relative to their neighbours in a picture with the target file:
// the first id; an AprilGrid's columns and spacing; a ChArUco board's squares, pattern and size of
// markers. `seen`: also tags of its family that are not on the board. Other boards, and pictures
// with few tags, show no mistake.
std::vector<TargetMistake> layout_mistakes(const Board& board, const SeenQuads& seen);

// The mistake in a checkerboard's numbers of corners, if the picture shows a grid of another size.
std::optional<TargetMistake> grid_size_mistake(const SeenChecker& seen, const Board& board);

// The mistake of a picture that shows nothing of the boards, but a board of another type: tags,
// markers of a ChArUco board, a grid of circles (also of another size), or a checkerboard.
std::optional<TargetMistake> target_type_mistake(const ImageView8& image,
                                                 const std::vector<PlacedBoard>& boards);

// The mistake of an AprilGrid or ChArUco board with more rows in the target file than the pictures
// show, although several of them have room for the next one. A few pictures of a ChArUco board are
// loaded again.
std::optional<TargetMistake> missing_rows(const std::vector<ImageSource>& images,
                                          const std::vector<DetectedPicture>& found,
                                          const Board& board);

}  // namespace tagcal::internal
