#include "report/detection_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "job/find_corners.hpp"
#include "job/terminal.hpp"
#include "tagcal/scene/board.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kIndent = 11;

// One picture: what was found, and what was read but not reported.
struct Picture {
  std::string name;
  std::size_t tags = 0;
  std::size_t corners = 0;
  std::size_t unfitted = 0;  // tags
};

// Tags if the boards have any that are observed, else corners.
struct Unit {
  bool is_tag = false;
  std::size_t of_boards = 0;

  std::size_t of(const Picture& picture) const { return is_tag ? picture.tags : picture.corners; }
  std::string text(const Picture& picture) const {
    return fmt::format("{} of {} {}s", of(picture), of_boards, is_tag ? "tag" : "corner");
  }
};

Unit unit_of(const std::vector<PlacedBoard>& boards) {
  Unit unit{has_tags(boards), 0};
  for (const PlacedBoard& placed : boards)
    unit.of_boards +=
        (unit.is_tag ? tags_of(placed.board).size() : target_points(placed.board).size());
  return unit;
}

std::vector<Picture> pictures_of(const Input& input) {
  std::vector<Picture> pictures;
  for (std::size_t i = 0; i < input.dataset.views.size(); ++i) {
    const View& view = input.dataset.views[i];
    pictures.push_back({view.image, static_cast<std::size_t>(num_tags({view})),
                        view.observations.size(),
                        i < input.unfitted.size() ? input.unfitted[i].size() : 0});
  }
  return pictures;
}

// "a.png, b.png and 7 more"
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i)
    text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kShown ? fmt::format("{} and {} more", text, names.size() - kShown) : text;
}

template <typename Has>
std::vector<std::string> names_with(const std::vector<Picture>& pictures, const Has& has) {
  std::vector<std::string> names;
  for (const Picture& picture : pictures)
    if (has(picture)) names.push_back(picture.name);
  return names;
}

// The pictures that show least of the target, if not all show the same.
std::string fewest_text(std::vector<Picture> pictures, const Unit& unit) {
  std::erase_if(pictures, [&](const Picture& p) { return unit.of(p) == 0; });
  if (pictures.size() < 2) return "";
  const auto count = [&](const Picture& picture) { return unit.of(picture); };
  std::ranges::stable_sort(pictures, {}, count);
  const std::size_t most = count(pictures.back());
  std::vector<std::string> fewest;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, pictures.size()); ++i)
    if (count(pictures[i]) < most)
      fewest.push_back(fmt::format("{} ({})", pictures[i].name, unit.text(pictures[i])));
  return fewest.empty() ? "" : wrapped("fewest     ", some_of(fewest), kIndent);
}

std::string unfitted_text(const std::vector<Picture>& pictures) {
  std::size_t count = 0;
  for (const Picture& picture : pictures) count += picture.unfitted;
  if (count == 0) return "";
  const auto names = names_with(pictures, [](const Picture& p) { return p.unfitted > 0; });
  return wrapped("left out   ",
                 fmt::format("{}, read but not reported because the print could not be fitted to "
                             "the pixels (blur, or partly covered): {}",
                             counted(count, "tag"), some_of(names)),
                 kIndent);
}

std::string verdict(std::size_t num_showing, std::size_t num_pictures, const std::string& what,
                    const std::string& found, bool is_doubtful = false) {
  if (num_showing == 0) {
    return toned(Tone::bad, "NOTHING FOUND: ") +
           (num_pictures == 1 ? what + " is not in the picture\n"
                              : fmt::format("{} is in none of {} pictures\n", what, num_pictures));
  }
  const bool is_all = num_showing == num_pictures;
  const std::string_view word = is_doubtful ? "DOUBTFUL:" : is_all ? "OK:" : "PARTLY:";
  return wrapped(toned(word == "OK:" ? Tone::good : Tone::caution, word) + " ",
                 fmt::format("{} of {} {} {}: {}", num_showing, counted(num_pictures, "picture"),
                             num_showing == 1 ? "shows" : "show", what, found),
                 kIndent);
}

std::string picture_line(const Picture& picture, const Unit& unit, std::size_t width) {
  std::string text = fmt::format("  {:<{}}  {}", picture.name, width, unit.text(picture));
  if (unit.is_tag) text += fmt::format(", {}", counted(picture.corners, "corner"));
  if (picture.unfitted > 0) text += fmt::format(", {} left out", picture.unfitted);
  return text + "\n";
}

std::size_t widest(const std::vector<Picture>& pictures) {
  std::size_t width = 0;
  for (const Picture& picture : pictures) width = std::max(width, picture.name.size());
  return width;
}

}  // namespace

std::string detection_summary(const Input& input, bool verbose, bool is_explained) {
  const Unit unit = unit_of(input.dataset.boards);
  const std::vector<Picture> pictures = pictures_of(input);
  const auto nothing = names_with(pictures, [&](const Picture& p) { return p.corners == 0; });
  const std::size_t num_all_corners = static_cast<std::size_t>(num_corners(input.dataset.views));
  std::string found = counted(num_all_corners, "corner");
  if (unit.is_tag)
    found = counted(static_cast<std::size_t>(num_tags(input.dataset.views)), "tag") + ", " + found;

  std::string text = verdict(pictures.size() - nothing.size(), pictures.size(), "the target", found,
                             !input.mistakes.empty());
  if (!input.mistakes.empty())
    text += wrapped("mistake    ", input.mistakes.front().text(), kIndent);
  if (!nothing.empty() && nothing.size() < pictures.size())
    text += wrapped("nothing    ", some_of(nothing), kIndent);
  text += fewest_text(pictures, unit) + unfitted_text(pictures);
  if (input.corner_error_px > 0)
    text += wrapped("corners    ",
                    fmt::format("scatter by {} px per coordinate beyond what each fit claims; the "
                                "covariances include it",
                                two_digits(input.corner_error_px)),
                    kIndent);
  if (!nothing.empty() && input.mistakes.empty() && !is_explained)
    text += "what to do --explain tells what is in a picture, and why tags are not found\n";
  if (verbose)
    for (const Picture& picture : pictures) text += picture_line(picture, unit, widest(pictures));
  return text;
}

std::string tag_summary(const std::vector<std::string>& pictures,
                        const std::vector<std::size_t>& num_tags, const std::string& family,
                        bool verbose) {
  std::vector<std::string> nothing;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (num_tags[i] == 0) nothing.push_back(pictures[i]);
  const std::size_t count = std::accumulate(num_tags.begin(), num_tags.end(), std::size_t{0});
  std::string text = verdict(pictures.size() - nothing.size(), pictures.size(),
                             "a tag of " + family, counted(count, "tag"));
  if (!nothing.empty() && nothing.size() < pictures.size())
    text += wrapped("nothing    ", some_of(nothing), kIndent);
  if (verbose)
    for (std::size_t i = 0; i < pictures.size(); ++i)
      text += fmt::format("  {}: {}\n", pictures[i], counted(num_tags[i], "tag"));
  return text;
}

nlohmann::ordered_json detection_json(const Input& input, nlohmann::ordered_json corners) {
  nlohmann::ordered_json pictures = nlohmann::ordered_json::array();
  for (const Picture& picture : pictures_of(input)) {
    pictures.push_back({{"image", picture.name}, {"corners", picture.corners}});
    if (!has_tags(input.dataset.boards)) continue;
    pictures.back()["tags"] = picture.tags;
    pictures.back()["tags_left_out"] = picture.unfitted;
  }
  std::vector<std::string> mistakes;
  for (const auto& mistake : input.mistakes) mistakes.push_back(mistake.text());
  return {{"pictures", std::move(pictures)},
          {"mistakes", mistakes},
          {"warnings", input.warnings},
          {"corners", std::move(corners)}};
}

nlohmann::ordered_json tags_json(const std::vector<std::string>& pictures,
                                 const std::vector<std::size_t>& num_tags, const Input& input,
                                 nlohmann::ordered_json corners) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < pictures.size(); ++i)
    list.push_back({{"image", pictures[i]}, {"tags", num_tags[i]}});
  return {
      {"pictures", std::move(list)}, {"warnings", input.warnings}, {"corners", std::move(corners)}};
}

}  // namespace tagcal::tools
