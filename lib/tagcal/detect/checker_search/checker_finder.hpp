#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/checker_search/checker_corners.hpp"
#include "tagcal/detect/checker_search/junction_grid.hpp"
#include "tagcal/detect/opencv/picture_shift.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

// Why a board is not reported, or what a reader of its corners should know.
enum class CheckerAnswer {
  found,
  no_grid,     // no grid of junctions
  other_grid,  // grids of another size: a part of the board, or another one
  not_fitted,  // too few corners look like the pattern
  seen_twice,  // more than one grid has the board's size
};

struct SeenChecker {
  CheckerAnswer answer = CheckerAnswer::no_grid;
  CheckerCell size{0, 0};  // of the largest grid
  std::vector<Observation> corners;
  bool starts_black = true;    // of a board that looks the same after a turn
  bool follows_lines = false;  // the corners were found along bent lines
};

// The size of a grid, as columns and rows of a board that is as wide or high as it if it can be.
CheckerCell size_beside(const CheckerCell& size, const Checkerboard& board);

// One sentence that says why a board is not reported; empty if it is.
std::string why_not_text(const SeenChecker& seen, const Board& board);

// Finds checkerboards and ChArUco boards. Not thread-safe.
class CheckerFinder {
 public:
  // The boards must outlive it; those that are no checkerboards are left out. Throws Error as
  // tag_family() does.
  CheckerFinder(const std::vector<PlacedBoard>& boards, const DetectOptions& options);

  // For each checkerboard, in the order of the boards.
  std::vector<SeenChecker> find(const ImageView8& image);

  // The same for the next picture of a sequence, where the corners of the picture before lead. No
  // value if one is lost, or if the picture before did not show every board: then the picture is to
  // be searched.
  std::optional<std::vector<SeenChecker>> follow(const ImageView8& image,
                                                 const std::vector<SeenChecker>& before,
                                                 const PictureShift& shift) const;
  const std::vector<const Board*>& boards() const { return boards_; }

 private:
  struct Target {
    const Board* board = nullptr;
    Checkerboard squares;
    CheckerPrint print;
    std::optional<TagSearch> markers;  // of a ChArUco board
  };

  void find_junctions_of_levels(const ImageView8& image);
  void find_plain(const ImageView8& image, std::vector<SeenChecker>& result) const;
  // The grid of a halved picture, or a finer one, that shows that the grid goes on; or null.
  const JunctionGrid* larger_grid(const JunctionGrid& grid, const Target& target) const;
  SeenChecker find_plain(const ImageView8& image, const Target& target,
                         const std::vector<JunctionGrid>& grids) const;
  struct Fitted {
    CheckerCorners corners;
    bool starts_black = true;
  };
  std::optional<Fitted> fitted(const ImageView8& image, const Target& target,
                               const JunctionGrid& grid) const;
  SeenChecker find_charuco(const ImageView8& image, Target& target) const;
  std::optional<SeenChecker> follow(const ImageView8& image, const Target& target,
                                    const SeenChecker& before, const PictureShift& shift) const;

  const Camera* camera_;
  std::vector<const Board*> boards_;
  std::vector<Target> targets_;
  struct Level {
    Image8 half;  // empty for the picture itself
    std::vector<Junction> junctions;
  };
  // The junctions of the present picture, then those of its halves, and the grids that they form;
  // each list of grids begins with the largest.
  std::vector<Level> pictures_;
  std::vector<std::vector<JunctionGrid>> levels_;
  bool follows_lines_ = false;  // the grids do: then their corners must determine a lens
};

}  // namespace tagcal::internal
