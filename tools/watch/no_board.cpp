#include "watch/watched_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tagcal/detect/explain.hpp"

namespace tagcal::tools {
namespace {

constexpr double kDarkLevel = 25;     // numeric: of 255; a picture with so dark a bright part
constexpr double kBrightLevel = 250;  // numeric: and with so bright a dark part

// The grey levels below which 2 % and 98 % of the pixels are.
std::pair<double, double> dark_and_bright(const ImageView8& image) {
  std::array<std::size_t, 256> counts{};
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) ++counts[image.row(y)[x]];
  const double all = static_cast<double>(image.width()) * image.height();
  const auto level = [&](double share) {
    double below = 0;
    for (std::size_t i = 0; i < counts.size(); ++i)
      if ((below += static_cast<double>(counts[i])) >= share * all) return static_cast<double>(i);
    return 255.0;
  };
  return {level(0.02), level(0.98)};  // numeric: shares of the pixels, see above
}

// The reason that most tags of the board have.
std::string commonest_reason(const std::vector<NotReported>& tags) {
  std::map<std::string, int> counts;
  for (const NotReported& tag : tags) ++counts[tag.why];
  const auto most =
      std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  return most == counts.end() ? "" : most->first;
}

}  // namespace

std::string why_no_board(const ImageView8& image, const std::vector<PlacedBoard>& boards) {
  const auto [dark, bright] = dark_and_bright(image);
  if (bright < kDarkLevel) return "the picture is almost black";
  if (dark > kBrightLevel) return "the picture is overexposed";
  const Explanation found = explain(image, boards);
  if (!found.mistakes.empty()) return found.mistakes.front();
  if (!found.checkerboards.empty()) return found.checkerboards.front();
  if (found.quads == 0) return "nothing in the picture looks like a tag";
  const std::string family = tag_kind(boards[0].board).value_or(TagKind{}).family;
  if (std::ranges::find(found.decoded, family, &SeenKind::family) == found.decoded.end())
    return fmt::format("{} black squares, but none can be read as a tag: too far, blurred or cut?",
                       found.quads);
  return fmt::format("tags are read, but {}", commonest_reason(found.not_reported));
}

}  // namespace tagcal::tools
