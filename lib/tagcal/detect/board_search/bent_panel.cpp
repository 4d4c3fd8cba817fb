#include "tagcal/detect/board_search/bent_panel.hpp"

#include <algorithm>
#include <utility>

#include "tagcal/detect/board_search/straight_tag.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

namespace tagcal::internal {
namespace {

using namespace policy;

constexpr double kMarginCells = kBoardReachCells + 2;  // the frame, and half a cell of samples
constexpr std::size_t kAnchors = 3;  // numeric: limit of work; the largest tags are the most bent
constexpr int kBentRounds = 8;       // numeric: limit of work
constexpr double kPlaceCells = 1.0 / 8;  // numeric: a fit starts within half a cell

}  // namespace

BentPanel::BentPanel(const ImageView8& image, const TagFamily& family,
                     const CellSurroundings& surroundings, const CompletionRules& rules,
                     std::vector<PlacedTag> tags)
    : image_(image),
      family_(family),
      surroundings_(surroundings),
      rules_(rules),
      tags_(std::move(tags)) {}

std::vector<FoundTag> BentPanel::find(const std::map<int, FoundTag>& fitted,
                                      std::map<int, MissingTag>& missing) {
  for (const auto& [id, tag] : fitted) fitted_.insert(id);
  estimate_lens();
  std::vector<FoundTag> found;
  if (!camera_ && !choose_focal_length()) return found;
  for (int round = 0; round < kBentRounds; ++round) {
    const std::size_t before = found.size();
    for (PlacedTag* tag : missing_tags()) {
      const auto there = try_tag(*tag, missing[tag->id]);
      if (!there) continue;
      tag->seen = there->corners;
      fitted_.insert(tag->id);
      found.push_back(*there);
    }
    if (found.size() == before) break;
    estimate_lens();
  }
  if (panel_lens_) return found;
  for (const FoundTag& tag : found) missing[tag.id] = {tag.id, WhyNot::no_fit, tag.corners};
  return {};
}

double BentPanel::correlation_under(const Lens* lens, const PlacedTag& tag) const {
  const auto view = PlaneView::about(tag, {&tag}, 1, lens);
  if (!view) return 0;
  const auto straight = StraightTag::of(image_, tag, *view, family_.width_at_border, kMarginCells);
  if (!straight) return 0;
  const TagCells cells(family_, tag.id, surroundings_);
  Quad quad = straight->expected();
  if (!fitted_.contains(tag.id))
    quad = best_correlated_quad(straight->image(), quad, cells, 0, kPlaceCells);
  return pattern_correlation(straight->image(), quad, cells);
}

// The one that explains the largest tags best. False if it does not explain them clearly better
// than straight lines.
bool BentPanel::choose_focal_length() {
  std::vector<const PlacedTag*> anchors;
  for (const PlacedTag& tag : tags_)
    if (tag.seen) anchors.push_back(&tag);
  const std::size_t count = std::min(kAnchors, anchors.size());
  std::ranges::partial_sort(anchors, anchors.begin() + static_cast<std::ptrdiff_t>(count),
                            std::ranges::greater(),
                            [](const PlacedTag* tag) { return shortest_side(*tag->seen); });
  const auto unexplained = [&](const Lens* lens) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += 1 - correlation_under(lens, *anchors[i]);
    return sum;
  };
  const double straight = unexplained(nullptr);
  if (straight > kBentMostUnexplained * static_cast<double>(count)) return false;
  double least = kBentUnexplainedShare * straight;
  for (const double focal : kPanelFocals) {
    const Camera camera = equidistant(focal, image_.size());
    const double left = unexplained(&camera.lens);
    if (left >= least) continue;
    least = left;
    camera_ = camera;
  }
  return camera_.has_value();
}

void BentPanel::estimate_lens() {
  std::vector<PanelCorner> corners;
  for (const PlacedTag& tag : tags_)
    if (fitted_.contains(tag.id))
      for (std::size_t i = 0; i < 4; ++i) corners.push_back({tag.corners[i], (*tag.seen)[i]});
  auto lens = lens_of_panel(corners, image_.size(), panel_lens_ ? &*panel_lens_ : nullptr);
  if (!lens || lens->spread > kTagMaxMovePx) return;
  panel_lens_ = std::move(lens);
  camera_ = panel_lens_->camera;
}

// Those with a place first, then those nearest to a fitted one.
std::vector<PlacedTag*> BentPanel::missing_tags() {
  std::vector<std::pair<double, PlacedTag*>> order;
  for (PlacedTag& tag : tags_) {
    if (fitted_.contains(tag.id) || rules_.excluded.contains(tag.id)) continue;
    const std::vector<const PlacedTag*> from = neighbours(tag);
    if (from.empty() && !tag.seen) continue;
    order.emplace_back(tag.seen ? 0 : (from.front()->centre - tag.centre).norm(), &tag);
  }
  return nearest_first(std::move(order));
}

std::vector<const PlacedTag*> BentPanel::neighbours(const PlacedTag& tag) const {
  std::vector<const PlacedTag*> fitted;
  for (const PlacedTag& other : tags_)
    if (fitted_.contains(other.id)) fitted.push_back(&other);
  return nearest_tags(tag, fitted);
}

std::optional<FoundTag> BentPanel::try_tag(PlacedTag& tag, MissingTag& missing) const {
  std::vector<std::vector<const PlacedTag*>> sources;
  if (tag.seen) sources.push_back({&tag});
  if (const auto from = neighbours(tag); !from.empty()) sources.push_back(from);
  for (const auto& from : sources) {
    const auto view = PlaneView::about(tag, from, from.size(), &camera_->lens);
    if (!view) continue;
    FoundTag found;
    const auto why = try_at(tag, *view, found);
    if (!why) return found;
    missing = {tag.id, *why, predicted(tag, from, from.size(), &camera_->lens)};
  }
  return std::nullopt;
}

std::optional<WhyNot> BentPanel::try_at(const PlacedTag& tag, const PlaneView& view,
                                        FoundTag& found) const {
  const auto straight = StraightTag::of(image_, tag, view, family_.width_at_border, kMarginCells);
  if (!straight || !is_inside(straight->in_picture(), image_.size(), -kMarginCells))
    return WhyNot::outside;
  if (shortest_side(straight->in_picture()) < family_.width_at_border) return WhyNot::too_small;
  if (static_cast<std::size_t>(tag.id) >= family_.codes.size()) return WhyNot::other_bits;
  const TagCells cells(family_, tag.id, surroundings_);
  Quad best = straight->expected();
  WhyNot why = WhyNot::no_edges;
  for (const double last_step : {kPlaceCells, 0.}) {
    best = best_correlated_quad(straight->image(), best, cells,
                                last_step > 0 ? kBoardReachCells : 0, last_step);
    if (const auto no = reason_to_reject(straight->image(), best, cells, rules_.max_hamming)) {
      why = *no;
      continue;
    }
    const auto place = straight->in_picture(best);
    if (!place || !is_inside(*place, image_.size())) return WhyNot::outside;
    const auto fitted = rules_.fit_under(tag.id, *place, *camera_);
    why = WhyNot::no_edges;
    if (!fitted || !is_face(fitted->corners) || !is_whole(*fitted, image_.size())) continue;
    const auto there = straight->straightened(fitted->corners);
    if (!there || reason_to_reject(straight->image(), *there, cells, rules_.max_hamming)) continue;
    found = *fitted;
    return std::nullopt;
  }
  return why;
}

}  // namespace tagcal::internal
