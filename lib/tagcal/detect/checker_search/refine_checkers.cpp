#include "tagcal/detect/checker_search/refine_checkers.hpp"

#include <map>

#include "tagcal/detect/board_search/refine_grids.hpp"
#include "tagcal/detect/checker_search/checker_corners.hpp"

namespace tagcal::internal {
namespace {

RefinedGrid refine(const ImageView8& image, const Board& board, const Camera& camera, View& view) {
  const Checkerboard squares = checkers(board).value();
  CheckerCorners corners;
  std::map<CheckerCell, Observation*> seen;
  for (Observation& observation : view.observations) {
    const int place = observation.id.tag_id - squares.first_id;
    if (observation.id.corner != 0 || place < 0 || place >= squares.columns * squares.rows)
      continue;
    const CheckerCell cell{place % squares.columns, place / squares.columns};
    seen[cell] = &observation;
    corners[cell].at = observation.pixel;
    corners[cell].covariance_px2 =
        observation.covariance_px2.value_or(Matrix2(Eigen::Matrix2d::Zero()));
  }
  CheckerPrint print(board);
  int refined = CheckerFitter(image, print, &camera).fit_again(corners);
  if (refined == 0 && !tag_kind(board)) {
    // A board that looks the same after a turn may have the other colours.
    print.set_starts_black(!print.starts_black());
    refined = CheckerFitter(image, print, &camera).fit_again(corners);
  }
  for (const auto& [cell, corner] : corners) {
    seen[cell]->pixel = corner.at;
    if (corner.covariance_px2.trace() > 0) seen[cell]->covariance_px2 = corner.covariance_px2;
  }
  return {static_cast<int>(corners.size()), refined};
}

}  // namespace

RefinedCorners refine_checkers(const std::vector<ImageSource>& images,
                               const std::vector<PlacedBoard>& boards,
                               const std::vector<View>& views, const Camera& camera, int threads) {
  std::vector<const Board*> checkerboards;
  for (const PlacedBoard& placed : boards)
    if (checkers(placed.board)) checkerboards.push_back(&placed.board);
  return refine_grids(images, checkerboards, views, threads,
                      [&](const ImageView8& image, const Board* board, View& view) {
                        return refine(image, *board, camera, view);
                      });
}

}  // namespace tagcal::internal
