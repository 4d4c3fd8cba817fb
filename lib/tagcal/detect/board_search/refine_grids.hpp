#pragma once

#include <map>
#include <string>
#include <vector>

#include "tagcal/detect/board_search/refine_corners.hpp"
#include "tagcal/internal/parallel.hpp"

// Private to detect.
namespace tagcal::internal {

// The points of a grid in one view: those seen, and of these those that were refined.
struct RefinedGrid {
  int num_seen = 0;
  int num_refined = 0;
};

// Calls `refine(image, grid, view)`, which returns a RefinedGrid, for each grid in each view whose
// picture is known; in parallel for the views. Here `num_tags` counts points.
template <typename Grid, typename Refine>
RefinedCorners refine_grids(const std::vector<ImageSource>& images, const std::vector<Grid>& grids,
                            const std::vector<View>& views, int threads, const Refine& refine) {
  RefinedCorners result{views};
  if (grids.empty()) return result;
  std::map<std::string, const ImageSource*> by_name;
  for (const ImageSource& image : images) by_name[image.name] = &image;
  std::vector<RefinedGrid> counts(views.size());
  parallel_for(views.size(), threads, [&](std::size_t i) {
    const auto source = by_name.find(views[i].image);
    if (source == by_name.end() || views[i].observations.empty()) return;
    const Image8 image = source->second->load();
    for (const Grid& grid : grids) {
      const RefinedGrid of_grid = refine(image, grid, result.views[i]);
      counts[i].num_seen += of_grid.num_seen;
      counts[i].num_refined += of_grid.num_refined;
    }
  });
  for (const RefinedGrid& of_view : counts) {
    result.num_tags += of_view.num_seen;
    result.num_refined += of_view.num_refined;
  }
  return result;
}

}  // namespace tagcal::internal
