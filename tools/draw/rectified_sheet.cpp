#include "draw/rectified_sheet.hpp"

#include <algorithm>

#include "draw/canvas.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace tagcal::tools {
namespace {

constexpr int kNumLines = 16;
constexpr Rgb kLineColours[] = {{230, 60, 50}, {40, 160, 60}, {50, 110, 230}};

}  // namespace

ImageRgb rectified_sheet(const KnownRig& rig, const RectifiedPair& pair,
                         const std::array<Image8, 2>& pictures, int longest_px) {
  const ImageSize full = size_of(pair.targets[0]);
  const int step = std::max(1, (2 * std::max(full.width, full.height)) / longest_px);
  const ImageSize size{full.width / step, full.height / step};
  const bool stacked = pair.is_vertical;
  Image8 both({stacked ? size.width : 2 * size.width, stacked ? 2 * size.height : size.height});
  for (std::size_t k = 0; k < 2; ++k) {
    const Image8 view = reproject(pictures[k], rectification(rig, pair, k)).image;
    const int right = stacked ? 0 : static_cast<int>(k) * size.width;
    const int down = stacked ? static_cast<int>(k) * size.height : 0;
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) both(x + right, y + down) = view(x * step, y * step);
  }
  Canvas canvas(both);
  for (int line = 0; line < kNumLines; ++line) {
    const double at = (line + 0.5) / kNumLines * (stacked ? size.width : size.height);
    const double end = stacked ? both.height() : both.width();
    const Polyline across = stacked ? Polyline{{at, 0}, {at, end}} : Polyline{{0, at}, {end, at}};
    canvas.draw({across}, {kLineColours[line % 3], 1, 0.8});
  }
  return canvas.image();
}

}  // namespace tagcal::tools
