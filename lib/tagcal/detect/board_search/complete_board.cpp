#include "tagcal/detect/board_search/complete_board.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tagcal/detect/board_search/bent_panel.hpp"
#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

using namespace policy;

// The fit of a tag mostly succeeds from a place that is this good; if not, from a better one.
constexpr double kRoughCells = 1.0 / 8;  // numeric: a fit starts within half a cell

// Probability that random bits, in any of four rotations, are one of `ids` codes up to `wrong_bits`
// wrong bits.
double chance_of_code(const TagFamily& family, std::size_t ids, int wrong_bits) {
  const auto bits = static_cast<double>(family.bits.size());
  double ways = 1, sum = 1;
  for (int k = 1; k <= wrong_bits; ++k) {
    ways *= (bits - k + 1) / k;
    sum += ways;
  }
  return 4 * static_cast<double>(ids) * sum * std::exp2(-bits);
}

class PanelCompletion {
 public:
  PanelCompletion(const ImageView8& image, const Board& board, const TagFamily& family,
                  const CompletionRules& rules)
      : image_(image),
        family_(family),
        rules_(rules),
        num_ids_(tags_of(board).size()),
        surroundings_(cell_surroundings(board, family)) {}

  void run(const BoardPanel& panel, const std::map<int, FoundTag>& found, Completion& result) {
    place(panel);
    std::map<int, MissingTag> missing;
    for (PlacedTag& tag : tags_) {
      if (const auto it = found.find(tag.id); it != found.end() && !it->second.is_approximate)
        check_found(it->second, tag, missing[tag.id], result);
    }
    bool added = true;
    while (added) {
      added = false;
      for (PlacedTag* tag : missing_tags()) added |= find_missing(*tag, missing[tag->id], result);
    }
    if (rules_.fit_under && is_bent(found, result)) find_bent(found, missing, result);
    drop_chance_tags(missing, result);
    for (PlacedTag* tag : missing_tags()) result.missing.push_back(missing[tag->id]);
  }

 private:
  void place(const BoardPanel& panel) {
    tags_.clear();
    seen_.clear();
    lens_.reset();
    const Pose panel_from_board = panel.tags.front().board_from_tag.inverse();
    for (const Tag& tag : panel.tags) {
      const Quad corners = on_panel(tag, panel_from_board);
      tags_.push_back({tag.id, centre_of(corners), corners, {}, {}});
    }
  }

  // Compares a found tag with the picture and keeps it, corrected if necessary, or names it
  // missing.
  void check_found(const FoundTag& found, PlacedTag& tag, MissingTag& missing, Completion& result) {
    if (found.rough_camera) {  // found by BentPanel before
      set_seen(tag, found.corners);
      lens_ = found.rough_camera->lens;
      result.tags.push_back(found);
      return;
    }
    const TagCells cells(family_, tag.id, surroundings_);
    FoundTag kept = found;
    const double before = pattern_correlation(image_, found.corners, cells);
    if (!found.refined || before < kBoardSureCorrelation) {
      const Quad best = best_correlated_quad(image_, found.corners, cells, 0);
      if (found.refined ? is_misplaced(found.corners, best, cells)
                        : pattern_correlation(image_, best, cells) > before) {
        kept = rules_.refine(tag.id, best).value_or(FoundTag{tag.id, best, false});
        if (is_misplaced(kept.corners, best, cells)) kept = {tag.id, best, false};
      }
    }
    const auto why = reason_to_reject(image_, kept.corners, cells,
                                      rules_.max_hamming + kTagMoreWrongBitsIfFound);
    if (why || !is_whole(kept, image_.size())) {
      missing = {tag.id, why.value_or(WhyNot::outside), kept.corners};
      return;
    }
    set_seen(tag, kept.corners);
    result.tags.push_back(kept);
  }

  // Missing tags, those nearest to a found one first.
  std::vector<PlacedTag*> missing_tags() {
    std::vector<std::pair<double, PlacedTag*>> order;
    for (PlacedTag& tag : tags_) {
      if (tag.seen || rules_.excluded.contains(tag.id)) continue;
      const std::vector<const PlacedTag*> from = nearest_tags(tag, seen_);
      order.emplace_back(from.empty() ? 0 : (from.front()->centre - tag.centre).norm(), &tag);
    }
    return nearest_first(std::move(order));
  }

  // Marks a tag as seen, or as missing.
  void set_seen(PlacedTag& tag, const std::optional<Quad>& corners) {
    tag.seen = corners;
    const auto place = std::ranges::lower_bound(seen_, &tag);
    const bool is_listed = place != seen_.end() && *place == &tag;
    if (corners && !is_listed) seen_.insert(place, &tag);
    if (!corners && is_listed) seen_.erase(place);
  }

  // Predicts a missing tag from its neighbours, unless that was tried before. True if it was found.
  bool find_missing(PlacedTag& tag, MissingTag& missing, Completion& result) {
    missing.id = tag.id;
    const std::vector<const PlacedTag*> from = nearest_tags(tag, seen_);
    std::vector<int> ids;
    for (const PlacedTag* other : from) ids.push_back(other->id);
    if (ids == tag.tried_from) return false;
    tag.tried_from = ids;
    bool first = true;
    for (const std::size_t count : {from.size(), std::size_t{1}}) {
      const std::optional<Quad> start = predicted(tag, from, count);
      if (!start) continue;
      const std::optional<WhyNot> why = try_at(*start, tag, result);
      if (!why) return true;
      if (first || *why > missing.why) missing = {tag.id, *why, start};
      first = false;
      if (from.size() == 1) break;
    }
    if (first) missing.why = WhyNot::outside;
    return false;
  }

  // Reads a tag at a predicted place and adds it. No value if it was found.
  std::optional<WhyNot> try_at(const Quad& start, PlacedTag& tag, Completion& result) {
    if (is_cut(start)) return WhyNot::outside;
    // Cells below a pixel are not sampled.
    if (shortest_side(start) < family_.width_at_border) return WhyNot::too_small;
    if (static_cast<std::size_t>(tag.id) >= family_.codes.size()) return WhyNot::other_bits;
    const TagCells cells(family_, tag.id, surroundings_);
    const Quad rough = best_correlated_quad(image_, start, cells, kBoardReachCells, kRoughCells);
    const auto why = try_from(rough, cells, tag, result);
    if (!why) return why;
    return try_from(best_correlated_quad(image_, rough, cells, 0), cells, tag, result);
  }

  std::optional<WhyNot> try_from(const Quad& best, const TagCells& cells, PlacedTag& tag,
                                 Completion& result) {
    if (const auto why = reason_to_reject(image_, best, cells, rules_.max_hamming)) return why;
    if (!is_inside(best, image_.size())) return WhyNot::outside;
    const std::optional<FoundTag> refined = rules_.refine(tag.id, best);
    if (!refined || !is_face(refined->corners)) return WhyNot::no_edges;
    if (!is_whole(*refined, image_.size())) return WhyNot::outside;
    if (is_misplaced(refined->corners, best, cells)) return WhyNot::no_edges;
    if (const auto why = reason_to_reject(image_, refined->corners, cells, rules_.max_hamming))
      return why;
    set_seen(tag, refined->corners);
    result.tags.push_back(*refined);
    return std::nullopt;
  }

  // True if tags are missing, and those next to them show that homographies do not predict them; or
  // if few tags are fitted, and others were read but not refined.
  bool is_bent(const std::map<int, FoundTag>& found, const Completion& result) {
    if (has_few_fitted(result)) {
      for (const PlacedTag& tag : tags_)
        if (const auto it = found.find(tag.id); !tag.seen && it != found.end())
          if (shortest_side(it->second.corners) >= family_.width_at_border) return true;
      for (const FoundTag& tag : result.tags)
        if (!tag.refined && is_of_panel(tag.id)) return true;
    }
    const std::vector<PlacedTag*> missing = missing_tags();
    return std::ranges::any_of(missing, [&](const PlacedTag* tag) {
      const auto nearest = nearest_tags(*tag, seen_);
      return !nearest.empty() && !is_predicted(*nearest.front());
    });
  }

  // True if the fitted tags do not determine a lens.
  bool has_few_fitted(const Completion& result) const {
    const auto count = std::ranges::count_if(
        result.tags, [&](const FoundTag& tag) { return tag.fitted && is_of_panel(tag.id); });
    return 4 * static_cast<std::size_t>(count) < kPanelMinCorners;
  }

  bool is_of_panel(int id) const {
    return std::ranges::find(tags_, id, &PlacedTag::id) != tags_.end();
  }

  // True if the nearest tags predict a seen one to a cell.
  bool is_predicted(const PlacedTag& tag) const {
    const auto from = nearest_tags(tag, seen_);
    if (from.empty()) return true;
    const auto there = predicted(tag, from, from.size());
    return there && largest_distance(*there, *tag.seen) <
                        kBoardReachCells * shortest_side(*tag.seen) / family_.width_at_border;
  }

  void find_bent(const std::map<int, FoundTag>& found, std::map<int, MissingTag>& missing,
                 Completion& result) {
    // The fit under the lens of enough others follows for tags that are refined.
    const bool is_few = has_few_fitted(result);
    std::map<int, FoundTag> fitted;
    for (const FoundTag& tag : result.tags)
      if ((tag.fitted || (!is_few && tag.refined)) && is_of_panel(tag.id)) fitted[tag.id] = tag;
    std::vector<PlacedTag> tags = tags_;
    for (PlacedTag& tag : tags)
      if (const auto it = found.find(tag.id); it != found.end() && !tag.seen)
        tag.seen = it->second.corners;
    BentPanel panel(image_, family_, surroundings_, rules_, std::move(tags));
    const std::vector<FoundTag> added = panel.find(fitted, missing);
    if (!added.empty()) lens_ = panel.lens();
    for (const FoundTag& tag : added) {
      std::erase_if(result.tags, [&](const FoundTag& old) { return old.id == tag.id; });
      result.tags.push_back(tag);
      set_seen(*std::ranges::find(tags_, tag.id, &PlacedTag::id), tag.corners);
    }
  }

  // Drops tags that no other tag confirms and that may have been read by chance.
  void drop_chance_tags(std::map<int, MissingTag>& missing, Completion& result) {
    const bool refuted = std::ranges::any_of(tags_, [&](const PlacedTag& tag) {
      return !tag.seen && !rules_.excluded.contains(tag.id) && is_refuted(missing[tag.id].why);
    });
    std::vector<PlacedTag*> lone;
    for (PlacedTag& tag : tags_)
      if (tag.seen && !is_confirmed(tag) && is_by_chance(tag, refuted)) lone.push_back(&tag);
    for (PlacedTag* tag : lone) {
      missing[tag->id] = {tag->id, WhyNot::alone, tag->seen};
      set_seen(*tag, std::nullopt);
      std::erase_if(result.tags, [&](const FoundTag& found) { return found.id == tag->id; });
    }
  }

  // True if the tag's place is in the picture and the tag is not there.
  static bool is_refuted(WhyNot why) {
    return why == WhyNot::no_contrast || why == WhyNot::no_border || why == WhyNot::other_bits;
  }

  bool is_confirmed(const PlacedTag& tag) const {
    return std::ranges::any_of(seen_, [&](const PlacedTag* other) {
      if (other == &tag) return false;
      const std::optional<Quad> there = predicted(tag, {other}, 1, lens_ ? &*lens_ : nullptr);
      return there &&
             largest_distance(*there, *tag.seen) < kTagSameShare * shortest_side(*tag.seen);
    });
  }

  bool is_by_chance(const PlacedTag& tag, bool refuted) const {
    const TagCells cells(family_, tag.id, surroundings_);
    const int wrong_bits = read_tag(image_, *tag.seen, cells).wrong_bits;
    if (tags_.size() == 1 && wrong_bits == 0) return false;
    return chance_of_code(family_, num_ids_, wrong_bits) >
           (refuted ? kBoardMaxChanceIfRefuted : kBoardMaxChance);
  }

  // True if refined corners are far from the best correlated ones and correlate clearly less.
  bool is_misplaced(const Quad& refined, const Quad& best, const TagCells& cells) const {
    const double cell = shortest_side(best) / cells.width_at_border();
    return largest_distance(refined, best) > std::max(kMaxMoveShare * cell, kBoardWrongCornerPx) &&
           pattern_correlation(image_, refined, cells) < pattern_correlation(image_, best, cells);
  }

  // True if the quad lies farther outside the picture than the prediction may err.
  bool is_cut(const Quad& quad) const {
    const double margin = kBoardReachCells * shortest_side(quad) / family_.width_at_border;
    return std::ranges::any_of(quad, [&](const Vector2d& corner) {
      return corner.minCoeff() < -margin || corner.x() > image_.width() - 1 + margin ||
             corner.y() > image_.height() - 1 + margin;
    });
  }

  ImageView8 image_;
  const TagFamily& family_;
  const CompletionRules& rules_;
  std::size_t num_ids_;
  CellSurroundings surroundings_;
  std::vector<PlacedTag> tags_;
  std::optional<Lens> lens_;            // if the panel is bent
  std::vector<const PlacedTag*> seen_;  // those of tags_ that are seen, in their order
};

}  // namespace

Completion complete_board(const ImageView8& image, const Board& board, const TagFamily& family,
                          const std::vector<FoundTag>& found, const CompletionRules& rules) {
  std::map<int, FoundTag> by_id;
  for (const FoundTag& tag : found) by_id.emplace(tag.id, tag);
  Completion result;
  PanelCompletion completion(image, board, family, rules);
  if (tag_kind(board))
    for (const BoardPanel& panel : board_panels(board, 0)) completion.run(panel, by_id, result);
  std::ranges::sort(result.tags, {}, &FoundTag::id);
  std::ranges::sort(result.missing, {}, &MissingTag::id);
  return result;
}

}  // namespace tagcal::internal
