#include "tagcal/detect/explain.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tagcal/detect/apriltag/kind_search.hpp"
#include "tagcal/detect/board_search/board_symmetry.hpp"
#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/board_search/wrong_border.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/circle_search/circle_finder.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/internal/overloaded.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;

constexpr int kSmallestTagPx = 20;  // side that a tag should have
// px. A picture with a shorter side that shows no tag is called too small: a board hardly fits in.
constexpr int kSmallPictureSidePx = 8 * kSmallestTagPx;

std::vector<int> ids_of(const std::vector<FoundTag>& tags) {
  std::vector<int> ids;
  for (const FoundTag& tag : tags) ids.push_back(tag.id);
  std::ranges::sort(ids);
  return ids;
}

Image8 mirrored(const ImageView8& image) {
  Image8 result(image.size());
  for (int y = 0; y < image.height(); ++y)
    std::reverse_copy(image.row(y), image.row(y) + image.width(), result.row(y));
  return result;
}

Image8 inverted(const ImageView8& image) {
  Image8 result(image.size());
  for (int y = 0; y < image.height(); ++y)
    std::transform(image.row(y), image.row(y) + image.width(), result.row(y),
                   [](std::uint8_t level) { return static_cast<std::uint8_t>(255 - level); });
  return result;
}

// The tags of all kinds that the library knows, without those that were probably misread.
std::vector<SeenKind> sure_kinds(const ImageView8& image, KindsInPicture seen) {
  std::vector<SeenKind> kinds;
  for (TagsOfKind& of_kind : seen.kinds) {
    const auto& [family, border_bits] = of_kind.kind;
    const TagFamily patterns = tag_family(family, border_bits);
    std::erase_if(of_kind.tags,
                  [&](const FoundTag& tag) { return !is_sure(image, tag, patterns); });
    if (!of_kind.tags.empty()) kinds.push_back({family, border_bits, ids_of(of_kind.tags)});
  }
  return kinds;
}

bool is_kind(const SeenKind& seen, const TagKind& kind) {
  return seen.family == kind.family && seen.border_bits == kind.border_bits;
}

// Number of tags of a kind in a picture.
int count_in(const ImageView8& image, const TagKind& kind) {
  const KindsInPicture seen = search_kinds(image, {kind});
  return seen.kinds.empty() ? 0 : static_cast<int>(seen.kinds.front().tags.size());
}

// The picture at the size at which detection searches it first.
Image8 at_first_size(const ImageView8& image) {
  Image8 result = part_of(image, {0, 0, image.size()});
  for (int i = 0; i < num_halvings(image.size()); ++i) result = halved(result);
  return result;
}

// The centre of another tag in the frame of this one: origin at its centre, unit its side.
std::optional<Vector2d> centre_seen_from(const Quad& from, const Quad& other) {
  constexpr double h = 1.0 / 2;
  const Vector2d corners[4] = {{-h, -h}, {h, -h}, {h, h}, {-h, h}};
  Eigen::Vector3d rays[4];
  const Vector2d middle = centre_of(from);
  for (std::size_t i = 0; i < 4; ++i) rays[i] = (from[i] - middle).homogeneous();
  const auto pixels_from_tag = homography(corners, rays);
  if (!pixels_from_tag) return std::nullopt;
  // The diagonals meet at the centre, under perspective too.
  const auto line = [&](std::size_t a, std::size_t b) {
    return Eigen::Vector3d((other[a] - middle).homogeneous())
        .cross(Eigen::Vector3d((other[b] - middle).homogeneous()));
  };
  return (pixels_from_tag->inverse() * line(0, 2).cross(line(1, 3))).hnormalized();
}

// Median of the gaps between neighbouring tags in the picture, in sides of a tag.
std::optional<double> measured_spacing(const AprilGrid& grid, const std::map<int, Quad>& seen) {
  std::vector<double> gaps;
  for (const auto& [id, quad] : seen) {
    const int place = id - grid.first_id;
    const auto add = [&, &quad = quad](int next, Eigen::Index along) {
      const auto it = seen.find(next);
      if (it == seen.end()) return;
      if (const auto there = centre_seen_from(quad, it->second))
        gaps.push_back((*there)[along] - 1);
    };
    if (place % grid.columns != grid.columns - 1) add(id + 1, 0);
    add(id + grid.columns, 1);
  }
  if (gaps.size() < 3) return std::nullopt;  // of three, one may be wrong
  return median(std::move(gaps));
}

class Explainer {
 public:
  Explainer(const ImageView8& image, const std::vector<PlacedBoard>& boards)
      : image_(image), first_size_(at_first_size(image)), boards_(boards) {
    result_.size = image.size();
  }

  Explanation run() {
    if (std::min(image_.width(), image_.height()) < kMinPictureSidePx) {
      result_.mistakes.push_back(small_text());
      return result_;
    }
    find_kinds();
    for (const PlacedBoard& placed : boards_) {
      if (point_kind(placed.board) == PointKind::tag_corner) explain_board(placed.board);
    }
    explain_checkers();
    explain_circles();
    std::ranges::sort(result_.reported);
    std::ranges::sort(result_.not_reported, {}, &NotReported::id);
    if (result_.reported.empty() && std::min(image_.width(), image_.height()) < kSmallPictureSidePx)
      result_.mistakes.push_back(small_text());
    return result_;
  }

 private:
  // A large picture is searched at its full size only if it shows nothing at the first one.
  void find_kinds() {
    search_for_kinds(first_size_);
    if (result_.decoded.empty() && first_size_.size() != image_.size()) search_for_kinds(image_);
  }

  void search_for_kinds(const ImageView8& searched) {
    KindsInPicture seen = search_kinds(searched, all_kinds());
    result_.quads = seen.quads;
    result_.decoded = sure_kinds(searched, std::move(seen));
  }

  void explain_board(const Board& board) {
    TagSearch finder({&board}, {});
    const SeenTags seen = finder.find(image_);
    const Completion& completion = seen.completions.front();
    report(completion, seen.repeated);
    name_mistakes(tag_kind(board).value(), completion, seen.strange.size());
    std::visit(Overloaded{[&](const AprilGrid& grid) { name_wrong_spacing(grid, completion); },
                          [](const auto&) {}},
               board.pattern);
  }

  void explain_checkers() {
    CheckerFinder finder(boards_, {});
    const std::vector<SeenChecker> seen = finder.find(image_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Board& board = *finder.boards()[i];
      const Checkerboard squares = checkers(board).value();
      result_.checkerboards.push_back(
          seen[i].answer == CheckerAnswer::found
              ? fmt::format("the checkerboard of {} x {} corners: {} of {} corners are reported",
                            squares.columns, squares.rows, seen[i].corners.size(),
                            squares.columns * squares.rows)
              : why_not_text(seen[i], board));
    }
  }

  void explain_circles() {
    const CircleFinder finder(boards_, {});
    const std::vector<SeenCircles> seen = finder.find(image_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const CircleGrid& grid = *finder.grids()[i];
      result_.checkerboards.push_back(
          seen[i].why_not.empty() ? fmt::format("{}: {} of {} centres are reported", name_of(grid),
                                                seen[i].centres.size(), grid.columns * grid.rows)
                                  : seen[i].why_not);
    }
  }

  void report(const Completion& completion, const std::set<int>& repeated) {
    for (const FoundTag& tag : completion.tags) result_.reported.push_back(tag.id);
    for (const MissingTag& tag : completion.missing)
      result_.not_reported.push_back({tag.id, std::string(why_not_text(tag.why))});
    const std::string twice = "seen more than once";
    for (const int id : repeated) result_.not_reported.push_back({id, twice});
  }

  void name_mistakes(const TagKind& wanted, const Completion& completion, std::size_t strange) {
    if (completion.tags.empty() && strange > 0) {
      result_.mistakes.push_back(
          fmt::format("wrong ids: {} tags of {} are in the picture, none of them is on the target; "
                      "correct the ids in the target file",
                      strange, wanted.family));
    } else {
      name_wrong_kind(wanted, completion.tags.empty());
    }
  }

  // Tags printed with one border are often read as tags with the other, but with wrong cells.
  void name_wrong_kind(const TagKind& wanted, bool nothing_found) {
    int of_target = 0;
    for (const SeenKind& kind : result_.decoded)
      if (is_kind(kind, wanted)) of_target = static_cast<int>(kind.ids.size());
    bool named = false;
    for (const SeenKind& kind : result_.decoded) {
      const int n = static_cast<int>(kind.ids.size());
      const bool is_border = kind.family == wanted.family;
      if (is_kind(kind, wanted) || !shows_other_kind(n, of_target)) continue;
      if (!nothing_found && !is_border) continue;  // tags of another object
      named = true;
      result_.mistakes.push_back(fmt::format(
          "wrong {}: {} tags of {} with border_bits {} are in the picture, but the "
          "target file says {}; correct the target file",
          is_border ? "border" : "family", n, kind.family, kind.border_bits,
          is_border ? fmt::format("border_bits {}", wanted.border_bits) : wanted.family));
    }
    if (named || !nothing_found) return;
    if (const int n = count_in(mirrored(first_size_), wanted); shows_other_kind(n, 0))
      result_.mistakes.push_back(fmt::format(
          "mirrored picture: {} tags are read after mirroring it; mirror the picture back", n));
    if (const int n = count_in(inverted(first_size_), wanted); shows_other_kind(n, 0))
      result_.mistakes.push_back(
          fmt::format("inverted picture: {} tags are read after exchanging black and white; invert "
                      "the picture back",
                      n));
  }

  void name_wrong_spacing(const AprilGrid& grid, const Completion& completion) {
    std::map<int, Quad> seen;
    for (const FoundTag& tag : completion.tags) seen[tag.id] = tag.corners;
    const std::optional<double> spacing = measured_spacing(grid, seen);
    if (!spacing || std::abs(*spacing - grid.tag_spacing) < policy::kSpacingTolerance) return;
    const bool metres =
        std::abs(grid.tag_spacing / grid.tag_size - *spacing) < policy::kSpacingTolerance;
    result_.mistakes.push_back(fmt::format(
        "wrong tag spacing: the gap is {:.2f} of a tag's side in the picture, {:.4g} in the "
        "target file{}; correct the target file",
        *spacing, grid.tag_spacing,
        metres ? ", which looks like metres, but must be gap / tag size" : ""));
  }

  std::string small_text() const {
    return fmt::format("picture too small: {}x{} pixels; a tag needs about {} pixels along a side",
                       image_.width(), image_.height(), kSmallestTagPx);
  }

  ImageView8 image_;
  Image8 first_size_;
  const std::vector<PlacedBoard>& boards_;
  Explanation result_;
};

}  // namespace

Explanation explain(const ImageView8& image, const std::vector<PlacedBoard>& boards) {
  return Explainer(PictureWithoutMosaic(image).pixels, boards).run();
}

}  // namespace tagcal
