#include "tagcal/detect/board_search/complete_board.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/board_search/tag_cells.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/print/board_ink.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNeighbours = 4;  // tags that predict one
constexpr double kReach = 2;            // cells, how far a prediction may be off
constexpr double kMinCellPx = 0.9;
constexpr double kMinLikeness = 0.5;
constexpr double kMinContrast = 8;      // grey levels
constexpr double kNoSettling = 0.93;    // likeness of a found tag that is not looked into
constexpr double kLessLike = 0.02;      // likeness lost by a refinement that went astray: so much
constexpr double kAstrayCells = 0.35;   // and so far: lenses that bend a tag cost some, too
constexpr double kAstrayPx = 1;         // the search is no finer
constexpr double kMaxWrongFixed = 0.1;  // of the cells of border and frame
constexpr double kMaxWrongFixedIfFound = 0.25;
constexpr double kSupport = 0.5;         // sides of a tag, between prediction and find
constexpr double kChance = 5e-4;         // that random bits in a frame are taken for a lone tag
constexpr double kChanceRefuted = 1e-5;  // where others of its plane should be in sight
constexpr double kCutShare = 0.15;       // of a tag's side: nearer to the edge, it may be whole

// How many cells may answer wrongly.
struct Tolerance {
  int bits = 1;
  double fixed = kMaxWrongFixed;
};

// How often random bits, in any of four turns, give one of so many codes.
double chance(const TagFamily& family, std::size_t ids, int wrong_bits) {
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
  PanelCompletion(const Image8& image, const Board& board, const TagFamily& family,
                  const CompletionRules& rules)
      : image_(image), family_(family), rules_(rules), num_ids_(board.tags.size()) {
    surroundings_.corner_squares = board.corner_squares && board.grid;
    if (board.grid) {
      surroundings_.white_frame = board.grid->tag_spacing * family.width_at_border >= 1;
    }
  }

  void run(const BoardPanel& panel, const std::map<int, FoundTag>& found, Completion& result) {
    place(panel);
    std::map<int, MissingTag> missing;
    for (PlacedTag& tag : tags_) {
      if (const auto it = found.find(tag.id); it != found.end())
        confirm(it->second, tag, missing[tag.id], result);
    }
    bool added = true;
    while (added) {
      added = false;
      for (PlacedTag* tag : missing_tags()) added |= look_for(*tag, missing[tag->id], result);
    }
    drop_lone(missing, result);
    for (PlacedTag* tag : missing_tags()) result.missing.push_back(missing[tag->id]);
  }

 private:
  void place(const BoardPanel& panel) {
    tags_.clear();
    const Pose panel_from_board = panel.tags.front().board_from_tag.inverse();
    for (const Tag& tag : panel.tags) {
      PlacedTag placed;
      placed.id = tag.id;
      const auto corners = tag_corners(tag);
      for (std::size_t i = 0; i < 4; ++i)
        placed.corners[i] = (panel_from_board * corners[i]).head<2>();
      placed.centre = centre_of(placed.corners);
      tags_.push_back(placed);
    }
  }

  // Holds a found tag against the picture.
  void confirm(const FoundTag& found, PlacedTag& tag, MissingTag& missing,
               Completion& result) const {
    const TagCells cells(family_, tag.id, surroundings_);
    FoundTag kept = found;
    const double before = likeness(image_, found.corners, cells);
    if (!found.refined || before < kNoSettling) {
      const Quad settled = settle(image_, found.corners, cells, 0);
      if (found.refined ? is_astray(found.corners, settled, cells)
                        : likeness(image_, settled, cells) > before + kLessLike) {
        kept = rules_.refine(tag.id, settled).value_or(FoundTag{tag.id, settled, false});
        if (is_astray(kept.corners, settled, cells)) kept = {tag.id, settled, false};
      }
    }
    // The detector has read the bits once, and hands may hide the frame.
    const auto why = doubt(kept.corners, cells, {rules_.max_hamming + 2, kMaxWrongFixedIfFound});
    if (why || !is_whole(kept, image_.size())) {
      missing = {tag.id, why.value_or(WhyNot::outside), kept.corners};
      return;
    }
    tag.seen = kept.corners;
    result.tags.push_back(kept);
  }

  // Those nearest to a found one first.
  std::vector<PlacedTag*> missing_tags() {
    std::vector<std::pair<double, PlacedTag*>> order;
    for (PlacedTag& tag : tags_) {
      if (tag.seen || rules_.left_out.contains(tag.id)) continue;
      const std::vector<const PlacedTag*> from = neighbours(tag);
      order.emplace_back(from.empty() ? 0 : (from.front()->centre - tag.centre).norm(), &tag);
    }
    std::ranges::stable_sort(order, {}, &std::pair<double, PlacedTag*>::first);
    std::vector<PlacedTag*> result;
    for (const auto& [distance, tag] : order) result.push_back(tag);
    return result;
  }

  // The found tags nearest to a place, nearest first.
  std::vector<const PlacedTag*> neighbours(const PlacedTag& tag) const {
    std::vector<const PlacedTag*> found;
    for (const PlacedTag& other : tags_)
      if (other.seen) found.push_back(&other);
    std::ranges::stable_sort(found, {}, [&](const PlacedTag* other) {
      return (other->centre - tag.centre).squaredNorm();
    });
    found.resize(std::min(found.size(), kNeighbours));
    return found;
  }

  // True where the tag was found.
  bool look_for(PlacedTag& tag, MissingTag& missing, Completion& result) {
    missing.id = tag.id;
    const std::vector<const PlacedTag*> from = neighbours(tag);
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

  // No value where the tag was found.
  std::optional<WhyNot> try_at(const Quad& start, PlacedTag& tag, Completion& result) const {
    if (is_cut(start)) return WhyNot::outside;
    if (shortest_side(start) < kMinCellPx * family_.width_at_border) return WhyNot::too_small;
    if (static_cast<std::size_t>(tag.id) >= family_.codes.size()) return WhyNot::other_bits;
    const TagCells cells(family_, tag.id, surroundings_);
    const Quad settled = settle(image_, start, cells, kReach);
    const Tolerance tolerance{rules_.max_hamming, kMaxWrongFixed};
    if (const auto why = doubt(settled, cells, tolerance)) return why;
    if (!is_inside(settled, image_.size())) return WhyNot::outside;
    const std::optional<FoundTag> refined = rules_.refine(tag.id, settled);
    if (!refined || !is_face(refined->corners)) return WhyNot::no_edges;
    if (!is_whole(*refined, image_.size())) return WhyNot::outside;
    if (is_astray(refined->corners, settled, cells)) return WhyNot::no_edges;
    if (const auto why = doubt(refined->corners, cells, tolerance)) return why;
    tag.seen = refined->corners;
    result.tags.push_back(*refined);
    result.added.push_back(tag.id);
    return std::nullopt;
  }

  // Tags that chance may have read, and no other supports.
  void drop_lone(std::map<int, MissingTag>& missing, Completion& result) {
    const bool refuted = std::ranges::any_of(tags_, [&](const PlacedTag& tag) {
      return !tag.seen && !rules_.left_out.contains(tag.id) && is_refuted(missing[tag.id].why);
    });
    std::vector<PlacedTag*> lone;
    for (PlacedTag& tag : tags_)
      if (tag.seen && !is_supported(tag) && is_by_chance(tag, refuted)) lone.push_back(&tag);
    for (PlacedTag* tag : lone) {
      missing[tag->id] = {tag->id, WhyNot::alone, tag->seen};
      tag->seen.reset();
      std::erase_if(result.tags, [&](const FoundTag& found) { return found.id == tag->id; });
    }
  }

  // The place is in the picture, and the tag is not there.
  static bool is_refuted(WhyNot why) {
    return why == WhyNot::no_contrast || why == WhyNot::no_border || why == WhyNot::other_bits;
  }

  bool is_supported(const PlacedTag& tag) const {
    return std::ranges::any_of(tags_, [&](const PlacedTag& other) {
      if (&other == &tag || !other.seen) return false;
      const std::optional<Quad> there = predicted(tag, {&other}, 1);
      return there && largest_distance(*there, *tag.seen) < kSupport * shortest_side(*tag.seen);
    });
  }

  bool is_by_chance(const PlacedTag& tag, bool refuted) const {
    const TagCells cells(family_, tag.id, surroundings_);
    const int wrong_bits = read_tag(image_, *tag.seen, cells).wrong_bits;
    if (tags_.size() == 1 && wrong_bits == 0) return false;
    return chance(family_, num_ids_, wrong_bits) > (refuted ? kChanceRefuted : kChance);
  }

  bool is_astray(const Quad& refined, const Quad& settled, const TagCells& cells) const {
    const double cell = shortest_side(settled) / cells.width_at_border();
    return largest_distance(refined, settled) > std::max(kAstrayCells * cell, kAstrayPx) &&
           likeness(image_, refined, cells) < likeness(image_, settled, cells) - kLessLike;
  }

  std::optional<WhyNot> doubt(const Quad& quad, const TagCells& cells,
                              const Tolerance& tolerance) const {
    const TagAnswer answer = read_tag(image_, quad, cells);
    if (answer.contrast < kMinContrast) return WhyNot::no_contrast;
    if (answer.wrong_fixed > tolerance.fixed) return WhyNot::no_border;
    if (answer.wrong_bits > tolerance.bits) return WhyNot::other_bits;
    if (likeness(image_, quad, cells) < kMinLikeness) return WhyNot::other_bits;
    return std::nullopt;
  }

  // Further out of the picture than the prediction may err.
  bool is_cut(const Quad& quad) const {
    const double margin = kCutShare * shortest_side(quad);
    return std::ranges::any_of(quad, [&](const Vector2d& corner) {
      return corner.minCoeff() < -margin || corner.x() > image_.width() - 1 + margin ||
             corner.y() > image_.height() - 1 + margin;
    });
  }

  const Image8& image_;
  const TagFamily& family_;
  const CompletionRules& rules_;
  std::size_t num_ids_;
  CellSurroundings surroundings_;
  std::vector<PlacedTag> tags_;
};

}  // namespace

std::string_view why_not_text(WhyNot why) {
  switch (why) {
    case WhyNot::no_neighbour:
      return "no other tag of its plane found to say where it is";
    case WhyNot::outside:
      return "outside of the picture, or cut by its edge";
    case WhyNot::too_small:
      return "too small: cells below a pixel";
    case WhyNot::no_contrast:
      return "the picture is flat where it should be";
    case WhyNot::no_border:
      return "no black border where it should be";
    case WhyNot::other_bits:
      return "its bits do not answer where it should be";
    case WhyNot::no_edges:
      return "its edges cannot be fitted";
    case WhyNot::no_fit:
      return "seen, but its pattern cannot be fitted to the pixels: its corners are not known";
    case WhyNot::alone:
      return "read alone, and codes of so few bits are read by chance";
  }
  return "";
}

Completion complete_board(const Image8& image, const Board& board, const TagFamily& family,
                          const std::vector<FoundTag>& found, const CompletionRules& rules) {
  std::map<int, FoundTag> by_id;
  for (const FoundTag& tag : found) by_id.emplace(tag.id, tag);
  Completion result;
  PanelCompletion completion(image, board, family, rules);
  if (!board.tags.empty()) {
    for (const BoardPanel& panel : board_panels(board, 0)) completion.run(panel, by_id, result);
  }
  std::ranges::sort(result.tags, {}, &FoundTag::id);
  std::ranges::sort(result.missing, {}, &MissingTag::id);
  return result;
}

}  // namespace tagcal::internal
