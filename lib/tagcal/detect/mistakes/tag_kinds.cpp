#include "tagcal/detect/mistakes/mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "tagcal/detect/board_search/tag_count.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

bool is_dictionary(const std::string& family) {
  return std::ranges::count(tag_dictionary_names(), family) > 0;
}

bool is_same_kind(const TagKind& a, const TagKind& b) {
  return a.family == b.family && a.border_bits == b.border_bits;
}

// "DICT_4X4_" of "DICT_4X4_50"; dictionaries of one series begin with the same markers.
std::string series_of(const std::string& dictionary) {
  return dictionary.substr(0, dictionary.find_last_of('_') + 1);
}

std::size_t num_codes(const std::string& family) { return tag_family(family, 1).codes.size(); }

// The largest dictionary of each series.
std::vector<TagKind> series_of_dictionaries() {
  std::vector<TagKind> largest;
  for (const std::string& name : tag_dictionary_names()) {
    const auto known = std::ranges::find_if(
        largest, [&](const TagKind& kind) { return series_of(kind.family) == series_of(name); });
    if (known == largest.end() || name.starts_with("DICT_APRILTAG"))
      largest.push_back({name, 1});
    else if (num_codes(name) > num_codes(known->family))
      known->family = name;
  }
  return largest;
}

// True if a picture shows another kind of tags than the target's: `read` of that kind were surely
// read, and `of_target` of the target's.
bool shows_other_kind(std::size_t read, std::size_t of_target) {
  return read >= policy::kOtherTagsRatio * std::max<std::size_t>(1, of_target);
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

// Number of tags in a picture that were surely read as of a kind.
std::size_t count_in(const ImageView8& image, const TagKind& kind) {
  std::vector<TagsOfKind> kinds = search_kinds(image, {kind}).kinds;
  keep_sure(image, kinds);
  return kinds.empty() ? 0 : kinds.front().tags.size();
}

std::string dictionary_of(const TagsOfKind& seen, const Board& board) {
  // The picture may show a part of the board.
  const int last = std::max(std::ranges::max_element(seen.tags, {}, &FoundTag::id)->id,
                            std::ranges::max(tags_of(board), {}, &Tag::id).id);
  return smallest_dictionary_with(seen.kind.family, last);
}

// Tags of AprilTag are those of a ChArUco board with another dictionary only if they are on its
// squares.
bool are_on_squares(const ImageView8& image, const TagsOfKind& seen, const Board& board) {
  const std::string dictionary = dictionary_of(seen, board);
  if (!dictionary.starts_with("DICT_APRILTAG")) return true;
  Charuco charuco = std::get<Charuco>(board.pattern);
  charuco.dictionary = dictionary;
  if (std::ranges::max(tags_of(board), {}, &Tag::id).id >=
      std::ssize(tag_family(dictionary, 1).codes))
    return true;
  const std::vector<PlacedBoard> other = {{make_board(charuco), Pose()}};
  return !CheckerFinder(other, {}).find(image).front().corners.empty();
}

TargetMistake other_kind(const TagsOfKind& seen, const TagKind& wanted, const Board& board) {
  const std::size_t n = seen.tags.size();
  if (checkers(board)) {
    const std::string dictionary = dictionary_of(seen, board);
    return {"wrong dictionary",
            fmt::format("{} markers of {} are in the picture, but the target file says {}; write "
                        "dictionary: {}",
                        n, dictionary, wanted.family, dictionary),
            true};
  }
  if (seen.kind.family == wanted.family)
    return {"wrong border",
            fmt::format("{} tags of {} with border_bits {} are in the picture, but the target file "
                        "says border_bits {}; write border_bits: {}",
                        n, wanted.family, seen.kind.border_bits, wanted.border_bits,
                        seen.kind.border_bits),
            true};
  return {"wrong family",
          fmt::format("{} tags of {} with border_bits {} are in the picture, but the target file "
                      "says {}; write family: {}, border_bits: {}",
                      n, seen.kind.family, seen.kind.border_bits, wanted.family, seen.kind.family,
                      seen.kind.border_bits),
          true};
}

std::optional<TargetMistake> wrong_picture(const ImageView8& image, const TagKind& wanted) {
  if (const auto n = count_in(mirrored(image), wanted); shows_other_kind(n, 0))
    return TargetMistake{
        "mirrored picture",
        fmt::format("{} tags are read after mirroring it; mirror the picture back", n)};
  if (const auto n = count_in(inverted(image), wanted); shows_other_kind(n, 0))
    return TargetMistake{
        "light on dark",
        fmt::format("{} tags are read after exchanging black and white; print the board dark on "
                    "light, or invert the pictures",
                    n)};
  return std::nullopt;
}

}  // namespace

std::string smallest_dictionary_with(const std::string& dictionary, int id) {
  std::string smallest = dictionary;
  if (dictionary.starts_with("DICT_APRILTAG")) return smallest;
  for (const std::string& name : tag_dictionary_names())
    if (series_of(name) == series_of(dictionary) &&
        num_codes(name) > static_cast<std::size_t>(id) && num_codes(name) < num_codes(smallest))
      smallest = name;
  return smallest;
}

std::vector<TagKind> kinds_of_all_targets() {
  std::vector<TagKind> kinds = all_kinds();
  for (TagKind& kind : series_of_dictionaries()) kinds.push_back(std::move(kind));
  return kinds;
}

std::vector<TagKind> kinds_beside(const std::vector<PlacedBoard>& boards) {
  std::vector<TagKind> kinds = all_kinds();
  for (const PlacedBoard& placed : boards) {
    const auto kind = tag_kind(placed.board);
    if (!kind || !is_dictionary(kind->family)) continue;
    std::vector<TagKind> dictionaries = series_of_dictionaries();
    std::erase_if(dictionaries, [&](const TagKind& other) {
      return series_of(other.family) == series_of(kind->family);
    });
    dictionaries.push_back(*kind);
    return dictionaries;
  }
  return kinds;
}

void keep_sure(const ImageView8& image, std::vector<TagsOfKind>& kinds) {
  for (TagsOfKind& of_kind : kinds) {
    const TagFamily patterns = tag_family(of_kind.kind.family, of_kind.kind.border_bits);
    std::erase_if(of_kind.tags,
                  [&](const FoundTag& tag) { return !is_sure(image, tag, patterns); });
  }
  std::erase_if(kinds, [](const TagsOfKind& of_kind) { return of_kind.tags.empty(); });
}

// Tags printed with one border are often read as tags with the other, but with wrong cells.
std::optional<TargetMistake> kind_mistake(const ImageView8& image, const Board& board,
                                          const std::vector<TagsOfKind>& sure, bool nothing_found) {
  const TagKind wanted = tag_kind(board).value();
  std::size_t of_target = 0;
  for (const TagsOfKind& seen : sure)
    if (is_same_kind(seen.kind, wanted)) of_target = seen.tags.size();
  const TagsOfKind* most = nullptr;
  for (const TagsOfKind& seen : sure) {
    const bool is_border = seen.kind.family == wanted.family;
    if (is_same_kind(seen.kind, wanted) || !shows_other_kind(seen.tags.size(), of_target)) continue;
    if (!nothing_found && !is_border) continue;  // tags of another object
    if (!most || seen.tags.size() > most->tags.size()) most = &seen;
  }
  if (most && checkers(board) && !are_on_squares(image, *most, board))
    if (auto type = target_type_mistake(image, {{board, Pose()}})) return type;
  if (most) return other_kind(*most, wanted, board);
  return nothing_found ? wrong_picture(image, wanted) : std::nullopt;
}

}  // namespace tagcal::internal
