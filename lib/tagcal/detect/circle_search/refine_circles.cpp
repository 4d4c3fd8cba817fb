#include "tagcal/detect/circle_search/refine_circles.hpp"

#include "tagcal/detect/board_search/refine_grids.hpp"
#include "tagcal/detect/circle_search/circle_centres.hpp"

namespace tagcal::internal {
namespace {

RefinedGrid refine(const ImageView8& image, const CircleGrid& grid, const Camera& camera,
                   View& view) {
  const CircleCentres on_board = centres_on_board(grid);
  CircleCentres centres;
  for (const Observation& seen : view.observations) {
    const auto centre = on_board.find(seen.id.tag_id);
    if (seen.id.corner != 0 || centre == on_board.end()) continue;
    centres[seen.id.tag_id] = {centre->second.on_board, seen.pixel};
  }
  const int count = fit_centres(image, &camera, centres);
  for (Observation& seen : view.observations) {
    const auto centre = centres.find(seen.id.tag_id);
    if (centre == centres.end() || centre->second.covariance_px2.trace() == 0) continue;
    seen.pixel = centre->second.at;
    seen.covariance_px2 = centre->second.covariance_px2;
  }
  return {static_cast<int>(centres.size()), count};
}

}  // namespace

RefinedCorners refine_circles(const std::vector<ImageSource>& images,
                              const std::vector<PlacedBoard>& boards,
                              const std::vector<View>& views, const Camera& camera, int threads) {
  std::vector<const CircleGrid*> grids;
  for (const PlacedBoard& placed : boards)
    if (const auto* const grid = std::get_if<CircleGrid>(&placed.board.pattern))
      grids.push_back(grid);
  return refine_grids(images, grids, views, threads,
                      [&](const ImageView8& image, const CircleGrid* grid, View& view) {
                        return refine(image, *grid, camera, view);
                      });
}

}  // namespace tagcal::internal
