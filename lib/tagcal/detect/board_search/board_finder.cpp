#include "tagcal/detect/board_search/board_finder.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/board_search/fit_under_lens.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"

namespace tagcal::internal {
namespace {

Wanted wanted_of(const std::vector<const Board*>& boards) {
  Wanted wanted;
  wanted.family = boards.front()->family;
  wanted.border_bits = boards.front()->border_bits;
  for (const Board* board : boards) {
    wanted.corner_squares |= board->corner_squares;
    for (const Tag& tag : board->tags) wanted.ids.insert(tag.id);
    add_patterns(*board, wanted.patterns);
  }
  return wanted;
}

int halvings_for(const ImageSize& size) {
  const double pixels = static_cast<double>(size.width) * size.height;
  return std::max(
      0, static_cast<int>(std::floor(std::log2(pixels / policy::kBoardMinHalvedPixels) / 2)));
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

// True if there is no tag of the family at all.
bool shows_nothing(const SeenBoards& seen) {
  return seen.strange.empty() && seen.repeated.empty() &&
         std::ranges::all_of(seen.completions,
                             [](const Completion& completion) { return completion.tags.empty(); });
}

// The part of the picture where missing tags may be; no box if nothing is missing.
class MissingPart {
 public:
  explicit MissingPart(const ImageSize& size) : size_(size) {}

  void add(const MissingTag& tag) {
    if (!may_be_there(tag)) return;
    if (!tag.expected) {
      low_ = {0, 0};
      high_ = {size_.width, size_.height};
      return;
    }
    double longest = 0;
    for (std::size_t i = 0; i < 4; ++i)
      longest = std::max(longest, ((*tag.expected)[(i + 1) % 4] - (*tag.expected)[i]).norm());
    const double margin = policy::kBoardSearchMarginSides * longest;
    for (const Eigen::Vector2d& corner : *tag.expected) {
      low_ = low_.cwiseMin((corner.array() - margin).matrix());
      high_ = high_.cwiseMax((corner.array() + margin).matrix());
    }
  }

  std::optional<PixelBox> box() const {
    const Eigen::Vector2d low = low_.cwiseMax(0);
    const Eigen::Vector2d high = high_.cwiseMin(Eigen::Vector2d(size_.width, size_.height));
    if (!((high - low).minCoeff() >= 1)) return std::nullopt;
    if ((high - low).prod() > policy::kBoardMaxPartShare * size_.width * size_.height)
      return PixelBox{0, 0, size_};
    const Eigen::Vector2i first = low.cast<int>();
    const Eigen::Vector2i size = high.cast<int>() - first;
    return PixelBox{first.x(), first.y(), {size.x(), size.y()}};
  }

 private:
  ImageSize size_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high_ = Eigen::Vector2d::Constant(-1e9);
};

}  // namespace

BoardFinder::BoardFinder(std::vector<const Board*> boards, const DetectOptions& options,
                         int threads)
    : boards_(std::move(boards)),
      max_hamming_(options.max_hamming),
      halves_(options.refinement != Refinement::stock),
      is_fitted_(options.refinement == Refinement::fit),
      detector_(wanted_of(boards_), options, threads),
      family_(tag_family(wanted().family, wanted().border_bits)) {}

SeenBoards BoardFinder::find(const Image8& image) {
  SeenBoards seen;
  std::optional<PixelBox> part = PixelBox{0, 0, image.size()};
  for (int halvings = halves_ ? halvings_for(image.size()) : 0; part && halvings >= 0; --halvings) {
    search(image, {*part, halvings}, seen);
    MissingPart missing(image.size());
    for (const Completion& completion : seen.completions)
      for (const MissingTag& tag : completion.missing) missing.add(tag);
    part = missing.box();
  }
  const bool small = image.width() * image.height() <= policy::kBoardMaxDoubledPixels;
  if (halves_ && small && shows_nothing(seen)) search(image, {{0, 0, image.size()}, -1}, seen);
  if (is_fitted_) {
    std::vector<FoundTag*> tags;
    for (Completion& completion : seen.completions)
      for (FoundTag& tag : completion.tags) tags.push_back(&tag);
    const auto fit_bent = [&] {
      for (std::size_t i = 0; i < boards_.size(); ++i)
        fit_under_lens(image, *boards_[i], detector_, seen.completions[i]);
    };
    fit_bent();
    if (detector_.find_gamma(image, tags)) fit_bent();
    detector_.forget_gamma();
    for (Completion& completion : seen.completions) drop_unfitted(completion);
  }
  return seen;
}

void BoardFinder::search(const Image8& image, const Search& where, SeenBoards& seen) {
  std::vector<FoundTag> tags;
  for (const Completion& completion : seen.completions)
    tags.insert(tags.end(), completion.tags.begin(), completion.tags.end());
  detector_.find(image, where, tags);
  complete(image, unique_tags(tags, seen), seen);
}

// The boards' tags that were seen once; adds the others to `seen`.
std::vector<FoundTag> BoardFinder::unique_tags(const std::vector<FoundTag>& tags,
                                               SeenBoards& seen) const {
  std::map<int, int> count;
  for (const FoundTag& tag : tags) ++count[tag.id];
  for (const auto& [id, times] : count) {
    if (!wanted().ids.contains(id)) {
      seen.strange.insert(id);
    } else if (times > 1) {
      seen.repeated.insert(id);
    }
  }
  std::vector<FoundTag> single;
  for (const FoundTag& tag : tags)
    if (wanted().ids.contains(tag.id) && !seen.repeated.contains(tag.id)) single.push_back(tag);
  return single;
}

void BoardFinder::complete(const Image8& image, const std::vector<FoundTag>& tags,
                           SeenBoards& seen) {
  const CompletionRules rules{max_hamming_, seen.repeated, [&](int id, const Quad& start) {
                                return detector_.refined(image, id, start);
                              }};
  seen.completions.clear();
  for (const Board* board : boards_)
    seen.completions.push_back(complete_board(image, *board, family_, tags, rules));
}

std::vector<std::unique_ptr<BoardFinder>> board_finders(const std::vector<PlacedBoard>& boards,
                                                        const DetectOptions& options, int threads) {
  std::map<std::pair<std::string, int>, std::vector<const Board*>> by_family;
  for (const PlacedBoard& placed : boards) {
    const Board& board = placed.board;
    if (!board.tags.empty()) by_family[{board.family, board.border_bits}].push_back(&board);
  }
  std::vector<std::unique_ptr<BoardFinder>> finders;
  for (auto& [family, of_family] : by_family)
    finders.push_back(std::make_unique<BoardFinder>(std::move(of_family), options, threads));
  return finders;
}

}  // namespace tagcal::internal
