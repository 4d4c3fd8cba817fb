#pragma once

#include <memory>
#include <set>
#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/complete_board.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

// The boards of one family and border in a picture.
struct SeenBoards {
  std::vector<Completion> completions;  // for each board
  std::set<int> strange;                // ids of the family that are on no board
  std::set<int> repeated;               // ids seen at more than one place, which are not reported
};

// Finds the boards of one family and border. Halved pictures are searched first, which is quick and
// shows large tags; the boards are completed from these. Tags that are still missing, and may be in
// the picture, are searched for in less halved ones, only where they may be. A picture that shows
// no tag at all and is not large is doubled: then tags are read down to 10 px.
class BoardFinder {
 public:
  // The boards must outlive it and be of one family and border. Throws Error as tag_family() does.
  BoardFinder(std::vector<const Board*> boards, const DetectOptions& options);

  const Wanted& wanted() const { return detector_.wanted(); }
  const TagFamily& family() const { return family_; }

  // Precondition: the picture is 8x8 or larger.
  SeenBoards find(const ImageView8& image);

 private:
  std::vector<FoundTag> unique_tags(const std::vector<FoundTag>& tags, SeenBoards& seen) const;
  void search(const ImageView8& image, const Search& where, SeenBoards& seen);
  void complete(const ImageView8& image, const std::vector<FoundTag>& tags, SeenBoards& seen);

  std::vector<const Board*> boards_;
  int max_hamming_;
  bool halves_;     // halved pictures are searched
  bool is_fitted_;  // tags are fitted, and only fitted tags are reported
  FamilyDetector detector_;
  TagFamily family_;
};

// One finder for each family and border of the boards, which must outlive the finders.
std::vector<std::unique_ptr<BoardFinder>> board_finders(const std::vector<PlacedBoard>& boards,
                                                        const DetectOptions& options);

}  // namespace tagcal::internal
