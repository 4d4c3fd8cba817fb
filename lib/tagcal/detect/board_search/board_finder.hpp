#pragma once

#include <memory>
#include <set>
#include <vector>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/board_search/complete_board.hpp"
#include "tagcal/detect/types.hpp"

// Private to detect.
namespace tagcal::internal {

// What a picture shows of the boards of one family and border.
struct SeenBoards {
  std::vector<Completion> completions;  // of each board
  std::set<int> strange;                // ids of the family that are on no board
  std::set<int> repeated;               // seen at more than one place: left out
};

// Finds the boards of one family and border. First halved pictures are searched, which is quick and
// shows large tags; the boards are completed from these. What is then still missing, and may be in
// the picture, is searched for in less and less halved ones, only where it may be. Where a picture
// that is not large shows nothing at all, it is doubled: then tags are read down to 10 px.
class BoardFinder {
 public:
  // The boards must outlive it and be of one family and border. Throws Error as tag_family() does.
  BoardFinder(std::vector<const Board*> boards, const DetectOptions& options, int threads);

  const Wanted& wanted() const { return detector_.wanted(); }
  const TagFamily& family() const { return family_; }

  // The picture must be 8x8 at least.
  SeenBoards find(const Image8& image);

 private:
  std::vector<FoundTag> without_doubles(const std::vector<FoundTag>& tags, SeenBoards& seen) const;
  void search(const Image8& image, const Search& where, SeenBoards& seen);
  void complete(const Image8& image, const std::vector<FoundTag>& tags, SeenBoards& seen);

  std::vector<const Board*> boards_;
  int max_hamming_;
  bool halves_;     // whether halved pictures are searched
  bool is_fitted_;  // whether tags are fitted, and reported only then
  FamilyDetector detector_;
  TagFamily family_;
};

// A finder for each family and border of the boards, which must outlive them; each may use
// `threads` threads.
std::vector<std::unique_ptr<BoardFinder>> board_finders(const std::vector<PlacedBoard>& boards,
                                                        const DetectOptions& options, int threads);

}  // namespace tagcal::internal
