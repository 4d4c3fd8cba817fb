#pragma once

#include <string>
#include <vector>

#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal {

// Tags of one kind in a picture.
struct SeenKind {
  std::string family;
  int border_bits = 1;
  std::vector<int> ids;  // ascending; an id that was seen twice is listed twice
};

struct NotReported {
  int id = 0;
  std::string why;
};

// The content of a picture, and the reasons why tags are missing.
struct Explanation {
  ImageSize size;
  int quads = 0;                           // shapes with four sides, tags or not
  std::vector<SeenKind> decoded;           // one for each known family and border with tags; a
                                           // large picture is searched at a reduced size first
  std::vector<int> reported;               // ids of the boards' tags that detect() reports
  std::vector<NotReported> not_reported;   // the boards' other tags, by id
  std::vector<std::string> checkerboards;  // a sentence for each checkerboard and ChArUco board
  std::vector<std::string> mistakes;       // probable mistakes of target file or picture
};

// Searches a picture for all families and borders, mirrored and inverted too, and measures the
// spacing of the tags found. Costs two to three times as much as detect().
Explanation explain(const ImageView8& image, const std::vector<PlacedBoard>& boards);

// Mistakes of the target file that most of the pictures show, as detect_all() answered them. If
// more than half of them show little of the boards, or tags at other places, a few are explained;
// one, if the board has markers in its squares.
std::vector<TargetMistake> target_mistakes(const std::vector<ImageSource>& images,
                                           const std::vector<DetectedPicture>& found,
                                           const std::vector<PlacedBoard>& boards,
                                           const DetectOptions& options = {});

// Warnings about the boards: those that look the same after a turn, and the mistakes.
std::vector<std::string> board_warnings(const std::vector<PlacedBoard>& boards,
                                        const std::vector<TargetMistake>& mistakes);

}  // namespace tagcal
