#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "tagcal/detect/board_search/completion.hpp"
#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/board_search/tag_cells.hpp"

// Private to detect.
namespace tagcal::internal {

// Finds the tags of a panel that a lens bends too strongly for homographies between pixels: each is
// predicted under a lens from the nearest ones, compared with its pattern in a straightened picture
// of its place, and fitted under the lens. The lens is a fisheye with equal angles a pixel, of the
// focal length that explains the largest tags best, until enough tags are fitted to estimate one.
class BentPanel {
 public:
  // The tags of the panel; `seen`: their places, also those that are only approximate. What is
  // given by reference must outlive it.
  BentPanel(const ImageView8& image, const TagFamily& family, const CellSurroundings& surroundings,
            const CompletionRules& rules, std::vector<PlacedTag> tags);

  // The tags that are not among the fitted ones, in the order in which they are found. Says why
  // others are missing. None without enough tags to estimate the lens: large tags are bent beyond
  // what their fits under a guessed one allow for.
  std::vector<FoundTag> find(const std::map<int, FoundTag>& fitted,
                             std::map<int, MissingTag>& missing);

  // The lens under which they were found; precondition: there are some.
  const Lens& lens() const { return camera_->lens; }

 private:
  bool choose_focal_length();
  double correlation_under(const Lens* lens, const PlacedTag& tag) const;
  void estimate_lens();
  std::vector<PlacedTag*> missing_tags();
  std::vector<const PlacedTag*> neighbours(const PlacedTag& tag) const;
  std::optional<FoundTag> try_tag(PlacedTag& tag, MissingTag& missing) const;
  std::optional<WhyNot> try_at(const PlacedTag& tag, const PlaneView& view, FoundTag& found) const;

  ImageView8 image_;
  const TagFamily& family_;
  const CellSurroundings& surroundings_;
  const CompletionRules& rules_;
  std::vector<PlacedTag> tags_;
  std::set<int> fitted_;  // ids
  std::optional<Camera> camera_;
  std::optional<PanelLens> panel_lens_;
};

}  // namespace tagcal::internal
