#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/circle_search/circle_centres.hpp"
#include "tagcal/detect/types.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to detect.
namespace tagcal::internal {

struct SeenCircles {
  std::vector<Observation> centres;
  std::string why_not;  // one sentence that says why a grid is not reported; empty if it is
};

// Finds grids of circles. Single discs may be hidden, but not whole outermost rows or columns.
class CircleFinder {
 public:
  // The boards must outlive it; those that are no grids of circles are left out.
  CircleFinder(const std::vector<PlacedBoard>& boards, const DetectOptions& options);

  // For each grid, in the order of the boards.
  std::vector<SeenCircles> find(const ImageView8& image) const;
  const std::vector<const CircleGrid*>& grids() const { return grids_; }

 private:
  const Camera* camera_;
  std::vector<const CircleGrid*> grids_;
};

// The grid of circles, of any size, that a picture shows with all of its discs.
std::optional<CircleGrid> whole_grid_in(const ImageView8& image);

}  // namespace tagcal::internal
