#include "page_data/page_parts.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "draw/rectified_sheet.hpp"
#include "report/rig_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kLongest = 1200;  // px of both pictures together; numeric: what a page shows

struct PicturesOfInstant {
  std::size_t instant = 0, num_corners = 0;  // corners of the picture that shows fewer
  std::array<fs::path, 2> files;
};

// Panoramas where pinholes would not hold the view.
RectifiedPair rectified(const KnownRig& rig, const RigPair& pair) {
  try {
    return rectify(rig, pair.a, pair.b);
  } catch (const Error&) {
    RectifyOptions options;
    options.longlat = true;
    return rectify(rig, pair.a, pair.b, options);
  }
}

}  // namespace

PageJson rectified_json(const RigDataset& data, const RigCalibration& answer,
                        const std::vector<std::map<std::string, fs::path>>& pictures) {
  const auto pair = std::ranges::max_element(answer.pairs, {}, &RigPair::num_instants);
  if (pair == answer.pairs.end()) return nullptr;
  std::optional<PicturesOfInstant> best;
  for (const RigInstant& used : answer.instants) {
    PicturesOfInstant seen{used.index, SIZE_MAX, {}};
    const std::array<std::size_t, 2> cameras = {pair->a, pair->b};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto& view = data.instants[used.index].view[cameras[k]];
      if (!view) break;
      const View& v = data.cameras[cameras[k]].data.views[*view];
      if (const auto file = pictures[cameras[k]].find(v.image); file != pictures[cameras[k]].end())
        seen.files[k] = file->second;
      seen.num_corners = std::min(seen.num_corners, v.observations.size());
    }
    const bool has_both = !seen.files[0].empty() && !seen.files[1].empty();
    if (has_both && (!best || seen.num_corners > best->num_corners)) best = seen;
  }
  if (!best) return nullptr;
  try {
    const KnownRig rig = known_rig(answer);
    const RectifiedPair lines = rectified(rig, *pair);
    const ImageRgb sheet = rectified_sheet(
        rig, lines, {read_image(best->files[0]), read_image(best->files[1])}, kLongest);
    return {{"a", pair->a},
            {"b", pair->b},
            {"instant", name_of(data.instants[best->instant], data)},
            {"is_vertical", lines.is_vertical},
            {"size", {sheet.width(), sheet.height()}},
            {"uri", jpeg_uri(sheet)}};
  } catch (const Error&) {  // the page is whole without it
    return nullptr;
  }
}

}  // namespace tagcal::tools
