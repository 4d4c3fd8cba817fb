#include "tagcal/detect/board_search/tag_follower.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr double kStartCells = 1.0 / 8;  // numeric: a fit starts within half a cell

double distance2(const FoundTag& tag, const Vector2d& from) {
  return (centre_of(tag.corners) - from).squaredNorm();
}

Vector2d mean_centre(const std::vector<const FoundTag*>& tags) {
  Vector2d sum = Vector2d::Zero();
  for (const FoundTag* tag : tags) sum += centre_of(tag->corners);
  return sum / static_cast<double>(tags.size());
}

Eigen::AlignedBox2d box_of(const std::vector<const FoundTag*>& tags) {
  Eigen::AlignedBox2d box;
  for (const FoundTag* tag : tags)
    for (const Vector2d& corner : tag->corners) box.extend(corner);
  return box;
}

}  // namespace

TagFollower::TagFollower(const ImageView8& image, const FamilyDetector& detector,
                         const TagFamily& family, const CellSurroundings& surroundings)
    : image_(image), detector_(detector), family_(family), surroundings_(surroundings) {}

// By the highest correlation with the tag's cells, for a start that is off by pixels.
std::optional<FoundTag> TagFollower::find_first(const FoundTag& before, const Quad& start) const {
  const TagCells cells(family_, before.id, surroundings_);
  const Quad best =
      best_correlated_quad(image_, start, cells, policy::kBoardReachCells, kStartCells);
  return is_inside(best, image_.size(), 0) ? detector_.refined(image_, before.id, best)
                                           : std::nullopt;
}

std::optional<FoundTag> TagFollower::find_next(const FoundTag& before, const Quad& start) const {
  auto found = detector_.refined_again(image_, before, start);
  return found ? found : find_first(before, start);
}

std::optional<Quad> TagFollower::predicted_place(const PlacedTag& tag) const {
  std::vector<const PlacedTag*> nearest;
  for (const PlacedTag& other : found_) nearest.push_back(&other);
  const std::size_t count = std::min(nearest.size(), policy::kBoardNeighbours);
  std::ranges::partial_sort(
      nearest, nearest.begin() + static_cast<std::ptrdiff_t>(count), {},
      [&](const PlacedTag* other) { return (other->centre - tag.centre).squaredNorm(); });
  return predicted(tag, nearest, count);
}

bool TagFollower::follow(std::vector<const FoundTag*> before, const PictureShift& shift,
                         std::vector<FoundTag>& tags) {
  found_.clear();
  const auto by = shift.of(box_of(before));
  if (!by) return false;
  const Vector2d middle = mean_centre(before);
  std::ranges::stable_sort(before, {},
                           [&](const FoundTag* tag) { return distance2(*tag, middle); });
  for (const FoundTag* tag : before) {
    PlacedTag placed{tag->id, centre_of(tag->corners), tag->corners, {}, {}};
    std::optional<Quad> start = tag->corners;
    if (found_.empty())
      for (Vector2d& corner : *start) corner += *by;
    else
      start = predicted_place(placed);
    if (!start) return false;
    // A tag at the edge may be found again when the board is completed.
    if (!is_inside(*start, image_.size())) continue;
    const auto found = found_.empty() ? find_first(*tag, *start) : find_next(*tag, *start);
    if (!found || !is_face(found->corners)) return false;
    placed.seen = found->corners;
    found_.push_back(placed);
    tags.push_back(*found);
  }
  return !found_.empty();
}

}  // namespace tagcal::internal
