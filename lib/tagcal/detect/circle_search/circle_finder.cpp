#include "tagcal/detect/circle_search/circle_finder.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tagcal/detect/board_search/board_symmetry.hpp"
#include "tagcal/detect/circle_search/circle_lattice.hpp"
#include "tagcal/detect/opencv/circle_blobs.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// In the picture halved as often as is useful, then in finer ones, until all discs are found: a
// large picture is slow, and its discs are larger than the search for blobs needs.
CirclePlaces find_places(const ImageView8& image, const CircleGrid& grid) {
  std::vector<Image8> halves;
  const auto picture = [&](std::size_t k) -> ImageView8 { return k ? halves[k - 1] : image; };
  const auto is_large = [](const ImageView8& view) {
    return static_cast<double>(view.width()) * view.height() / 4 >= policy::kBoardMinHalvedPixels;
  };
  while (is_large(picture(halves.size()))) halves.push_back(halved(picture(halves.size())));
  const auto num_discs = static_cast<std::size_t>(grid.columns * grid.rows);
  CirclePlaces best;
  for (std::size_t k = halves.size() + 1; k-- > 0 && best.size() < num_discs;) {
    CirclePlaces places = places_among(circle_blobs(picture(k), grid.columns * grid.rows), grid);
    if (places.size() <= best.size()) continue;
    const double scale = std::exp2(k);
    for (auto& [id, at] : places) at = scale * at + Vector2d::Constant((scale - 1) / 2);
    best = std::move(places);
  }
  return best;
}

SeenCircles seen(const ImageView8& image, const CircleGrid& grid, const Camera* camera) {
  CircleCentres centres;
  const CircleCentres on_board = centres_on_board(grid);
  for (const auto& [id, at] : find_places(image, grid))
    centres[id] = {on_board.at(id).on_board, at};
  if (centres.empty()) return {{}, fmt::format("{} is not found", name_of(grid))};
  const int count = fit_centres(image, camera, centres);
  if (2 * count <= grid.columns * grid.rows)
    return {{}, fmt::format("{}: its circles do not look like dark discs", name_of(grid))};
  SeenCircles result;
  for (const auto& [id, centre] : centres)
    if (centre.covariance_px2.trace() > 0)
      result.centres.push_back({{id, 0}, centre.at, centre.covariance_px2});
  return result;
}

}  // namespace

CircleFinder::CircleFinder(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
    : camera_(options.camera) {
  for (const PlacedBoard& placed : boards)
    if (const auto* const grid = std::get_if<CircleGrid>(&placed.board.pattern))
      grids_.push_back(grid);
}

std::vector<SeenCircles> CircleFinder::find(const ImageView8& image) const {
  std::vector<SeenCircles> result;
  for (const CircleGrid* grid : grids_) result.push_back(seen(image, *grid, camera_));
  return result;
}

}  // namespace tagcal::internal
