#include "tagcal/detect/explain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "tagcal/detect/apriltag/kind_search.hpp"
#include "tagcal/detect/board_search/board_symmetry.hpp"
#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/circle_search/circle_finder.hpp"
#include "tagcal/detect/mistakes/mistakes.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr int kSmallestTagPx = 20;  // side that a tag should have
// px. A picture with a shorter side that shows no tag is called too small: a board hardly fits in.
constexpr int kSmallPictureSidePx = 8 * kSmallestTagPx;
// numeric: pictures that are looked at for mistakes of the target file, which all of them show.
constexpr std::size_t kProbes = 3;

std::vector<int> ids_of(const std::vector<FoundTag>& tags) {
  std::vector<int> ids;
  for (const FoundTag& tag : tags) ids.push_back(tag.id);
  std::ranges::sort(ids);
  return ids;
}

SeenQuads quads_of(const std::vector<FoundTag>& tags) {
  SeenQuads quads;
  std::set<int> repeated;
  for (const FoundTag& tag : tags)
    if (!quads.emplace(tag.id, tag.corners).second) repeated.insert(tag.id);
  for (const int id : repeated) quads.erase(id);
  return quads;
}

// The picture at the size at which detection searches it first.
Image8 at_first_size(const ImageView8& image) {
  Image8 result = part_of(image, {0, 0, image.size()});
  for (int i = 0; i < num_halvings(image.size()); ++i) result = halved(result);
  return result;
}

class Explainer {
 public:
  Explainer(const ImageView8& image, const std::vector<PlacedBoard>& boards)
      : image_(image), first_size_(at_first_size(image)), boards_(boards) {
    result_.size = image.size();
  }

  Explanation run() {
    if (std::min(image_.width(), image_.height()) < kMinPictureSidePx) {
      add(small_picture());
      return result_;
    }
    find_kinds();
    for (const PlacedBoard& placed : boards_) {
      if (point_kind(placed.board) == PointKind::tag_corner) explain_board(placed.board);
      if (tag_kind(placed.board) && checkers(placed.board)) explain_markers(placed.board);
    }
    explain_checkers();
    explain_circles();
    if (!shows_target_ && result_.mistakes.empty())
      if (auto mistake = target_type_mistake(image_, boards_)) {
        mistakes_.clear();
        add(std::move(*mistake));
      }
    std::ranges::sort(result_.reported);
    std::ranges::sort(result_.not_reported, {}, &NotReported::id);
    if (result_.reported.empty() && std::min(image_.width(), image_.height()) < kSmallPictureSidePx)
      add(small_picture());
    return result_;
  }

  const std::vector<TargetMistake>& mistakes() const { return mistakes_; }

 private:
  void add(TargetMistake mistake) {
    if (!mistake.needs_others) result_.mistakes.push_back(mistake.text());
    mistakes_.push_back(std::move(mistake));
  }

  // A large picture is searched at its full size only if it shows nothing at the first one.
  void find_kinds() {
    search_for_kinds(first_size_);
    if (sure_.empty() && first_size_.size() != image_.size()) search_for_kinds(image_);
    for (const TagsOfKind& seen : sure_)
      result_.decoded.push_back({seen.kind.family, seen.kind.border_bits, ids_of(seen.tags)});
  }

  // Null without sure tags of a kind.
  const TagsOfKind* sure_of(const TagKind& kind) const {
    const auto seen = std::ranges::find_if(sure_, [&](const TagsOfKind& other) {
      return other.kind.family == kind.family && other.kind.border_bits == kind.border_bits;
    });
    return seen == sure_.end() ? nullptr : &*seen;
  }

  void search_for_kinds(const ImageView8& searched) {
    KindsInPicture seen = search_kinds(searched, kinds_beside(boards_));
    result_.quads = seen.quads;
    read_ = seen.kinds;
    sure_ = std::move(seen.kinds);
    keep_sure(searched, sure_);
  }

  void explain_board(const Board& board) {
    TagSearch finder({&board}, {});
    const SeenTags seen = finder.find(image_);
    const Completion& completion = seen.completions.front();
    report(completion, seen.repeated);
    name_mistakes(board, seen);
    const TagsOfKind* const sure = sure_of(tag_kind(board).value());
    const bool has_strange = !seen.strange.empty() && !completion.tags.empty() && sure;
    for (TargetMistake& mistake :
         layout_mistakes(board, quads_of(has_strange ? sure->tags : completion.tags)))
      add(std::move(mistake));
  }

  // The markers of a ChArUco board, at the size of the picture that shows them.
  void explain_markers(const Board& board) {
    const TagKind wanted = tag_kind(board).value();
    const auto read = std::ranges::find_if(
        read_, [&](const TagsOfKind& seen) { return seen.kind.family == wanted.family; });
    const bool nothing_read = read == read_.end();
    if (auto mistake = kind_mistake(first_size_, board, sure_, nothing_read))
      return add(std::move(*mistake));
    if (nothing_read) return;
    const TagsOfKind* const sure = sure_of(wanted);
    for (TargetMistake& mistake : layout_mistakes(board, quads_of((sure ? *sure : *read).tags)))
      add(std::move(mistake));
  }

  void explain_checkers() {
    CheckerFinder finder(boards_, {});
    const std::vector<SeenChecker> seen = finder.find(image_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Board& board = *finder.boards()[i];
      const Checkerboard squares = checkers(board).value();
      shows_target_ |= !seen[i].corners.empty();
      result_.checkerboards.push_back(
          seen[i].answer == CheckerAnswer::found
              ? fmt::format("the checkerboard of {} x {} corners: {} of {} corners are reported",
                            squares.columns, squares.rows, seen[i].corners.size(),
                            squares.columns * squares.rows)
              : why_not_text(seen[i], board));
      if (auto mistake = grid_size_mistake(seen[i], board)) add(std::move(*mistake));
    }
  }

  void explain_circles() {
    const CircleFinder finder(boards_, {});
    const std::vector<SeenCircles> seen = finder.find(image_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const CircleGrid& grid = *finder.grids()[i];
      shows_target_ |= !seen[i].centres.empty();
      result_.checkerboards.push_back(
          seen[i].why_not.empty() ? fmt::format("{}: {} of {} centres are reported", name_of(grid),
                                                seen[i].centres.size(), grid.columns * grid.rows)
                                  : seen[i].why_not);
    }
  }

  void report(const Completion& completion, const std::set<int>& repeated) {
    for (const FoundTag& tag : completion.tags) result_.reported.push_back(tag.id);
    shows_target_ |= !completion.tags.empty() || !repeated.empty();
    for (const MissingTag& tag : completion.missing)
      result_.not_reported.push_back({tag.id, std::string(why_not_text(tag.why))});
    const std::string twice = "seen more than once";
    for (const int id : repeated) result_.not_reported.push_back({id, twice});
  }

  void name_mistakes(const Board& board, const SeenTags& seen) {
    const std::set<int>& strange = seen.strange;
    const bool nothing_found = seen.completions.front().tags.empty() && seen.repeated.empty();
    if (nothing_found && !strange.empty()) {
      const std::vector<Tag> tags = tags_of(board);
      const auto [least, most] = std::ranges::minmax_element(tags, {}, &Tag::id);
      return add(
          {"wrong ids",
           fmt::format("{} tags of {} with ids from {} to {} are in the picture, none of them "
                       "is on the target, whose ids run from {} to {}; correct the ids in "
                       "the target file (first_id)",
                       strange.size(), tag_kind(board)->family, *strange.begin(), *strange.rbegin(),
                       least->id, most->id),
           true});
    }
    if (auto mistake = kind_mistake(first_size_, board, sure_, nothing_found))
      add(std::move(*mistake));
  }

  TargetMistake small_picture() const {
    return {"picture too small",
            fmt::format("{}x{} pixels; a tag needs about {} pixels along a side", image_.width(),
                        image_.height(), kSmallestTagPx)};
  }

  ImageView8 image_;
  Image8 first_size_;
  const std::vector<PlacedBoard>& boards_;
  std::vector<TagsOfKind> read_, sure_;  // tags of each kind, surely of it
  std::vector<TargetMistake> mistakes_;
  bool shows_target_ = false;
  Explanation result_;
};

// True if the picture shows less of the boards than it should, or tags at other places.
bool is_suspicious(const DetectedPicture& found, const std::vector<PlacedBoard>& boards) {
  if (!found.unreadable.empty()) return false;
  if (found.num_unread > found.num_sure || found.view.observations.empty() ||
      found.has_strange_tags)
    return true;
  const SeenQuads quads = internal::quads_of(found.view);
  std::size_t points = 0;
  for (const PlacedBoard& placed : boards) {
    const PointKind kind = point_kind(placed.board);
    if (kind == PointKind::checker_corner) points += target_points(placed.board).size();
    if (kind == PointKind::tag_corner && boards.size() == 1 &&
        !layout_mistakes(placed.board, quads).empty())
      return true;
  }
  return static_cast<double>(found.view.observations.size()) <
         policy::kSuspiciousShare * static_cast<double>(points);
}

std::vector<std::size_t> evenly_spread(const std::vector<std::size_t>& all, std::size_t n) {
  if (all.size() <= n) return all;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < n; ++i) some.push_back(all[i * (all.size() - 1) / (n - 1)]);
  return some;
}

// The mistakes that most of the pictures show, and how many show each.
std::vector<TargetMistake> common_mistakes(const std::vector<std::vector<TargetMistake>>& shown) {
  std::vector<TargetMistake> common;
  std::set<std::string> names;
  for (const auto& of_picture : shown)
    for (const TargetMistake& mistake : of_picture) {
      if (names.contains(mistake.name)) continue;
      const auto count = std::ranges::count_if(shown, [&](const auto& others) {
        return std::ranges::any_of(others, [&](const TargetMistake& other) {
          return other.name == mistake.name &&
                 (!mistake.needs_others || other.sentence == mistake.sentence);
        });
      });
      if (2 * count <= std::ssize(shown)) continue;
      if (mistake.needs_others && count < static_cast<std::ptrdiff_t>(kProbes)) continue;
      names.insert(mistake.name);
      common.push_back(mistake);
    }
  return common;
}

std::vector<TargetMistake> missing_rows(const std::vector<ImageSource>& images,
                                        const std::vector<DetectedPicture>& found,
                                        const std::vector<PlacedBoard>& boards) {
  std::vector<TargetMistake> mistakes;
  for (const PlacedBoard& placed : boards)
    if (auto mistake = internal::missing_rows(images, found, placed.board))
      mistakes.push_back(*std::move(mistake));
  return mistakes;
}

// The mistakes that each of some pictures shows.
std::vector<std::vector<TargetMistake>> mistakes_in(const std::vector<std::size_t>& probes,
                                                    const std::vector<ImageSource>& images,
                                                    const std::vector<PlacedBoard>& boards,
                                                    const DetectOptions& options) {
  std::vector<std::vector<TargetMistake>> shown(probes.size());
  parallel_for(probes.size(), options.threads, [&](std::size_t i) {
    const Image8 image = images[probes[i]].load();
    const PictureToSearch picture(image);
    Explainer explainer(picture.pixels, boards);
    explainer.run();
    shown[i] = explainer.mistakes();
  });
  return shown;
}

// All corners of a ChArUco board are found with markers of another size as well, but not as
// exactly: one picture, the most complete, tells.
std::vector<TargetMistake> wrong_marker_size(const std::vector<ImageSource>& images,
                                             const std::vector<DetectedPicture>& found,
                                             const std::vector<PlacedBoard>& boards,
                                             const DetectOptions& options) {
  const bool has_markers = std::ranges::any_of(boards, [](const PlacedBoard& placed) {
    return std::holds_alternative<Charuco>(placed.board.pattern);
  });
  const auto best = std::ranges::max_element(
      found, {}, [](const DetectedPicture& picture) { return picture.view.observations.size(); });
  // If no picture shows a corner, the first one may be a file that cannot be read.
  if (!has_markers || best == found.end() || best->view.observations.empty()) return {};
  const auto probe = static_cast<std::size_t>(best - found.begin());
  std::vector<TargetMistake> mistakes = mistakes_in({probe}, images, boards, options).front();
  std::erase_if(mistakes, [](const TargetMistake& mistake) {
    return mistake.name != kWrongMarkerSize && mistake.name != kWrongFirstId;
  });
  return mistakes;
}

}  // namespace

Explanation explain(const ImageView8& image, const std::vector<PlacedBoard>& boards) {
  return Explainer(PictureToSearch(image).pixels, boards).run();
}

std::vector<TargetMistake> target_mistakes(const std::vector<ImageSource>& images,
                                           const std::vector<DetectedPicture>& found,
                                           const std::vector<PlacedBoard>& boards,
                                           const DetectOptions& options) {
  std::vector<std::size_t> suspicious;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (is_suspicious(found[i], boards)) suspicious.push_back(i);
  std::vector<TargetMistake> common =
      2 * suspicious.size() > found.size()
          ? common_mistakes(
                mistakes_in(evenly_spread(suspicious, kProbes), images, boards, options))
          : wrong_marker_size(images, found, boards, options);
  return common.empty() ? missing_rows(images, found, boards) : common;
}

std::vector<std::string> board_warnings(const std::vector<PlacedBoard>& boards,
                                        const std::vector<TargetMistake>& mistakes) {
  std::vector<std::string> warnings = symmetry_warnings(boards);
  for (const TargetMistake& mistake : mistakes)
    warnings.push_back("the pictures and the target file do not agree: " + mistake.text());
  return warnings;
}

}  // namespace tagcal
