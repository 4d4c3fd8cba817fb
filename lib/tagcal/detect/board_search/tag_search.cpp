#include "tagcal/detect/board_search/tag_search.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/board_search/fit_under_lens.hpp"
#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/board_search/tag_follower.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/print/printed_tag.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kStrongFisheyes = 2;  // numeric: of kPanelFocals, 95 and 64 degrees
constexpr double kMaxPartShare = 0.6;       // numeric: a search of a larger part saves no time

// Throws Error for a tag that its family does not have: nobody can see it.
Wanted wanted_of(const std::vector<const Board*>& boards) {
  Wanted wanted;
  const TagKind kind = tag_kind(*boards.front()).value();
  wanted.family = kind.family;
  wanted.border_bits = kind.border_bits;
  const TagFamily family = tag_family(wanted.family, wanted.border_bits);
  for (const Board* board : boards) {
    wanted.corner_squares |= tag_surroundings(*board).corner_squares;
    for (const Tag& tag : tags_of(*board)) {
      check_tag_id(family, tag.id);
      wanted.ids.insert(tag.id);
    }
    add_patterns(*board, wanted.patterns);
  }
  return wanted;
}

Wanted any_of(const TagKind& kind) {
  Wanted wanted;
  wanted.family = kind.family;
  wanted.border_bits = kind.border_bits;
  wanted.any = tag_family(kind.family, kind.border_bits);
  // Tags with two bits of border mostly come from Kalibr's boards, whose squares touch them.
  wanted.corner_squares = kind.border_bits == 2;
  return wanted;
}

// True if a search in a finer picture may find the tag.
bool may_be_there(const MissingTag& tag) {
  return tag.why != WhyNot::too_small && tag.why != WhyNot::outside;
}

// Moves tags whose pattern could not be fitted to the missing ones: their corners are unreliable.
void drop_unfitted(Completion& completion) {
  for (const FoundTag& tag : completion.tags)
    if (!tag.fitted) completion.missing.push_back({tag.id, WhyNot::no_fit, tag.corners});
  std::erase_if(completion.tags, [](const FoundTag& tag) { return !tag.fitted; });
  std::ranges::sort(completion.missing, {}, &MissingTag::id);
}

// True if a tag of the picture before is missing in the next one, and not because it has left it.
bool has_lost(const Completion& before, const Completion& now) {
  return std::ranges::any_of(now.missing, [&](const MissingTag& missing) {
    return missing.why != WhyNot::outside &&
           std::ranges::binary_search(before.tags, missing.id, {}, &FoundTag::id);
  });
}

// True if there is no tag of the family at all.
bool shows_nothing(const SeenTags& seen) {
  return seen.tags.empty() && seen.strange.empty() && seen.repeated.empty() &&
         std::ranges::all_of(seen.completions,
                             [](const Completion& completion) { return completion.tags.empty(); });
}

// The part of the picture where missing tags may be; no value if nothing is missing.
std::optional<PixelBox> missing_part(const ImageSize& size, const SeenTags& seen) {
  Eigen::AlignedBox2d box;
  const Eigen::AlignedBox2d all(Eigen::Vector2d::Zero(), Eigen::Vector2d(size.width, size.height));
  for (const Completion& completion : seen.completions) {
    for (const MissingTag& tag : completion.missing) {
      if (!may_be_there(tag)) continue;
      if (!tag.expected) return PixelBox{0, 0, size};
      double margin = 0;  // a side of the tag
      for (std::size_t i = 0; i < 4; ++i)
        margin = std::max(margin, ((*tag.expected)[(i + 1) % 4] - (*tag.expected)[i]).norm());
      for (const Eigen::Vector2d& corner : *tag.expected) {
        box.extend((corner.array() - margin).matrix());
        box.extend((corner.array() + margin).matrix());
      }
    }
  }
  box = box.intersection(all);
  if (box.isEmpty() || box.sizes().minCoeff() < 1) return std::nullopt;
  if (box.volume() > kMaxPartShare * all.volume()) return PixelBox{0, 0, size};
  const Eigen::Vector2i first = box.min().cast<int>();
  const Eigen::Vector2i sides = box.max().cast<int>() - first;
  return PixelBox{first.x(), first.y(), {sides.x(), sides.y()}};
}

}  // namespace

TagSearch::TagSearch(const Wanted& wanted, std::vector<const Board*> boards,
                     const DetectOptions& options)
    : boards_(std::move(boards)),
      options_(options),
      detector_(wanted, options),
      family_(tag_family(wanted.family, wanted.border_bits)) {}

TagSearch::TagSearch(std::vector<const Board*> boards, const DetectOptions& options)
    : TagSearch(wanted_of(boards), boards, options) {}

TagSearch::TagSearch(const TagKind& kind, const DetectOptions& options)
    : TagSearch(any_of(kind), {}, options) {}

SeenTags TagSearch::find(const ImageView8& image) {
  SeenTags seen;
  seen.completions.resize(boards_.size());
  if (std::min(image.width(), image.height()) < kMinPictureSidePx) return seen;
  search_scales(image, seen);
  if (options_.refinement != Refinement::fit) return seen;
  if (!boards_.empty()) search_bent(image, seen);
  fit(image, seen);
  return seen;
}

void TagSearch::search_scales(const ImageView8& image, SeenTags& seen) {
  const bool is_refined = options_.refinement != Refinement::stock;
  const PixelBox all{0, 0, image.size()};
  std::optional<PixelBox> part = all;
  for (int halvings = is_refined ? num_halvings(image.size()) : 0; halvings >= 0; --halvings) {
    for (std::size_t pass = 0; part && pass < detector_.num_passes(); ++pass) {
      search(image, {*part, halvings, pass}, seen);
      if (!boards_.empty()) part = missing_part(image.size(), seen);
    }
  }
  if (!is_refined || !is_worth_doubling(image.size()) || !shows_nothing(seen)) return;
  // A search for boards ends with the first tags: the boards are completed from these.
  for (std::size_t pass = 0; pass < detector_.num_passes(); ++pass)
    if (boards_.empty() || shows_nothing(seen)) search(image, {all, -1, pass}, seen);
}

// Searches a picture that shows nothing for tags that are too large and too bent for AprilTag.
void TagSearch::search_bent(const ImageView8& image, SeenTags& seen) {
  for (const double focal : std::span(kPanelFocals).first<kStrongFisheyes>()) {
    if (!shows_nothing(seen)) return;
    std::vector<FoundTag> tags;
    detector_.find_bent(image, equidistant(focal, image.size()).lens, tags);
    if (!tags.empty()) complete(image, unique_tags(tags, seen), seen);
  }
}

void TagSearch::search(const ImageView8& image, const Search& where, SeenTags& seen) {
  if (boards_.empty()) {
    detector_.find(image, where, seen.tags);
    std::erase_if(seen.tags, [](const FoundTag& tag) { return tag.is_approximate; });
    return;
  }
  std::vector<FoundTag> tags;
  for (const Completion& completion : seen.completions)
    tags.insert(tags.end(), completion.tags.begin(), completion.tags.end());
  detector_.find(image, where, tags);
  complete(image, unique_tags(tags, seen), seen);
}

void TagSearch::fit_bent(const ImageView8& image, SeenTags& seen) const {
  for (FoundTag& tag : seen.tags)
    if (!tag.fitted) tag = detector_.refined(image, tag.id, tag.corners, false).value_or(tag);
  for (std::size_t i = 0; i < boards_.size(); ++i)
    fit_under_lens(image, *boards_[i], detector_, seen.completions[i]);
}

// Fits the tags again if the picture has terms.
void TagSearch::fit_with_terms(const ImageView8& image, SeenTags& seen) {
  std::vector<FoundTag*> tags;
  for (FoundTag& tag : seen.tags) tags.push_back(&tag);
  for (Completion& completion : seen.completions)
    for (FoundTag& tag : completion.tags) tags.push_back(&tag);
  if (detector_.find_terms(image, tags)) fit_bent(image, seen);
}

void TagSearch::fit(const ImageView8& image, SeenTags& seen) {
  fit_bent(image, seen);
  fit_with_terms(image, seen);
  seen.terms = detector_.terms();
  detector_.set_terms({});
  std::erase_if(seen.tags, [](const FoundTag& tag) { return !tag.fitted; });
  for (Completion& completion : seen.completions) drop_unfitted(completion);
}

// The boards' tags that were seen once; adds the others to `seen`.
std::vector<FoundTag> TagSearch::unique_tags(const std::vector<FoundTag>& tags,
                                             SeenTags& seen) const {
  std::map<int, int> count;
  for (const FoundTag& tag : tags)
    if (!tag.is_approximate) ++count[tag.id];
  for (const auto& [id, times] : count) {
    if (!wanted().ids.contains(id)) {
      seen.strange.insert(id);
    } else if (times > 1) {
      seen.repeated.insert(id);
    }
  }
  std::vector<FoundTag> single;
  for (const FoundTag& tag : tags)
    if (wanted().ids.contains(tag.id) && !seen.repeated.contains(tag.id) &&
        !(tag.is_approximate && count.contains(tag.id)))
      single.push_back(tag);
  return single;
}

void TagSearch::complete(const ImageView8& image, const std::vector<FoundTag>& tags,
                         SeenTags& seen) {
  CompletionRules rules{options_.max_hamming, seen.repeated, [&](int id, const Quad& start) {
                          return detector_.refined(image, id, start);
                        }};
  if (options_.refinement == Refinement::fit)
    rules.fit_under = [&](int id, const Quad& start, const Camera& camera) {
      FoundTag tag{id, start, false};
      const double cell = shortest_side(start) / family_.width_at_border;
      const double reach_px = std::max(policy::kTagMaxMovePx, policy::kMaxMoveShare * cell);
      return detector_.fit_roughly(tag, image, camera, reach_px) ? std::optional(tag)
                                                                 : std::nullopt;
    };
  seen.completions.clear();
  for (const Board* board : boards_)
    seen.completions.push_back(complete_board(image, *board, family_, tags, rules));
}

std::optional<std::vector<FoundTag>> TagSearch::followed_tags(const ImageView8& image,
                                                              const SeenTags& before,
                                                              const PictureShift& shift) const {
  std::vector<FoundTag> tags;
  for (std::size_t i = 0; i < boards_.size(); ++i) {
    std::map<int, const FoundTag*> of_board;
    for (const FoundTag& tag : before.completions[i].tags) of_board.emplace(tag.id, &tag);
    TagFollower follower(image, detector_, family_, cell_surroundings(*boards_[i], family_));
    for (const BoardPanel& panel : board_panels(*boards_[i], 0)) {
      std::vector<const FoundTag*> of_panel;
      for (const Tag& tag : panel.tags)
        if (const auto seen = of_board.find(tag.id); seen != of_board.end())
          of_panel.push_back(seen->second);
      if (of_panel.empty() || !follower.follow(of_panel, shift, tags)) return std::nullopt;
    }
  }
  return tags;
}

std::optional<SeenTags> TagSearch::follow(const ImageView8& image, const SeenTags& before,
                                          const PictureShift& shift) {
  if (boards_.empty() || !before.strange.empty() || !before.repeated.empty()) return std::nullopt;
  detector_.set_terms(before.terms);
  SeenTags seen;
  seen.terms = before.terms;
  const auto tags = followed_tags(image, before, shift);
  if (tags) {
    complete(image, *tags, seen);
    if (options_.refinement == Refinement::fit) {
      fit_bent(image, seen);
      if (!before.terms.is_none()) fit_with_terms(image, seen);
      seen.terms = detector_.terms();
      for (Completion& completion : seen.completions) drop_unfitted(completion);
    }
  }
  detector_.set_terms({});
  if (!tags) return std::nullopt;
  for (std::size_t i = 0; i < boards_.size(); ++i)
    if (has_lost(before.completions[i], seen.completions[i])) return std::nullopt;
  return seen;
}

std::vector<TagSearch> tag_searches(const std::vector<PlacedBoard>& boards,
                                    const DetectOptions& options) {
  std::map<std::pair<std::string, int>, std::vector<const Board*>> by_family;
  for (const PlacedBoard& placed : boards) {
    if (point_kind(placed.board) != PointKind::tag_corner) continue;
    const TagKind kind = tag_kind(placed.board).value();
    by_family[{kind.family, kind.border_bits}].push_back(&placed.board);
  }
  std::vector<TagSearch> searches;
  for (auto& [family, of_family] : by_family) searches.emplace_back(std::move(of_family), options);
  return searches;
}

}  // namespace tagcal::internal
