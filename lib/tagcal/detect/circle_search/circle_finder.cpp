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

// The picture and its halved versions: a large picture is slow, and its discs are larger than the
// search for blobs needs.
class HalvedPictures {
 public:
  explicit HalvedPictures(const ImageView8& image) : image_(image) {
    while (is_large(at(halves_.size()))) halves_.push_back(halved(at(halves_.size())));
  }

  std::size_t size() const { return halves_.size() + 1; }
  // Halved k times.
  ImageView8 at(std::size_t k) const { return k ? ImageView8(halves_[k - 1]) : image_; }

 private:
  static bool is_large(const ImageView8& view) {
    return static_cast<double>(view.width()) * view.height() / 4 >= policy::kBoardMinHalvedPixels;
  }

  ImageView8 image_;
  std::vector<Image8> halves_;
};

// In the picture halved as often as is useful, then in finer ones, until all discs are found.
CirclePlaces find_places(const ImageView8& image, const CircleGrid& grid) {
  const HalvedPictures pictures(image);
  const auto num_discs = static_cast<std::size_t>(grid.columns * grid.rows);
  CirclePlaces best;
  for (std::size_t k = pictures.size(); k-- > 0 && best.size() < num_discs;) {
    CirclePlaces places =
        places_among(circle_blobs(pictures.at(k), grid.columns * grid.rows), grid);
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

std::optional<CircleGrid> whole_grid_in(const ImageView8& image) {
  constexpr int kFewest = policy::kGridOfOtherTarget * policy::kGridOfOtherTarget;
  const HalvedPictures pictures(image);
  for (std::size_t k = pictures.size(); k-- > 0;)
    if (const auto grid = whole_grid_among(circle_blobs(pictures.at(k), kFewest)))
      if (!seen(image, *grid, nullptr).centres.empty()) return grid;  // they look like discs
  return std::nullopt;
}

}  // namespace tagcal::internal
