#include "study/atlas/atlas_page.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tagcal::study {
namespace {

struct Entry {
  const char* id;
  const char* condition;
  const char* map;     // its name; empty: none
  const char* remark;  // why there is none, or what the map does not say
};

constexpr Entry kCatalogue[] = {
    {"G1", "a plane parallel to the image", "focal-tilt-noise", ""},
    {"G2", "planes parallel to one another", "calibrate-parallel", ""},
    {"G3", "turns about the optical axis only", "calibrate-roll", ""},
    {"G4", "copies of one view", "calibrate-repeated", ""},
    {"G5", "two parallel views", "calibrate-parallel",
     "of three views; two of any attitude in calibrate-views-tilt"},
    {"G6", "small tilts everywhere", "calibrate-views-tilt", ""},
    {"G7", "weak perspective", "focal-distance", ""},
    {"G8", "principal point against tilt, in one view", "",
     "one view never frees the principal point: it is held at the centre of the image"},
    {"G9", "correlated coefficients of distortion", "calibrate-fold",
     "coefficients are never judged, the projection is"},
    {"G10", "corners in a part of the image only", "calibrate-extrapolation", ""},
    {"G11", "tilts about one axis only", "",
     "accepted: the information holds them, with a wider principal point"},
    {"G12", "the two poses of a plane", "tag-tilt-distance", ""},
    {"G13", "corners in mirrored order, a square turned by a quarter", "swapped",
     "exempt in a lone tag: nothing disagrees with it"},
    {"G14", "points on a line", "line", ""},
    {"G15", "three points: four poses, the danger cylinder", "points", "three points are refused"},
    {"G16", "a wrong scale of the board", "",
     "exempt: the picture is the same, only the distance is scaled"},
    {"M1", "beyond the fold of the distortion", "calibrate-fold", ""},
    {"M2", "undistortion that has not converged", "", "a test of the lens, not of an estimate"},
    {"M3", "a field of 180 degrees and more", "", "a test of the lens, not of an estimate"},
    {"M4", "the wrong lens for the data", "calibrate-wrong-lens", ""},
    {"M5", "a bent board", "calibrate-bent", ""},
    {"M6", "points at the camera's plane or behind it", "behind-camera", ""},
    {"M7", "blur", "tag-size-blur", ""},
    {"M8", "rolling shutter", "", "exempt: measured by tagcal-study shutter"},
    {"M9", "a pixel centre that is off by a half", "",
     "exempt: it moves the principal point and leaves no residual"},
    {"M10", "corners pushed outwards", "tag-size-blur", "and tag-tilt-noise"},
    {"D1", "wrong corners", "wrong-corners", "of calibrations: calibrate-wrong-views"},
    {"D2", "wrong ids, corners in another order", "swapped",
     "of one view; of calibrations: calibrate-wrong-views"},
    {"D3", "NaN and infinity", "bad-data", ""},
    {"D4", "points at one place, a point twice", "bad-data", ""},
    {"D5", "units of length", "units", "of calibrations: calibrate-unit"},
    {"D6", "a target far from the origin", "units", ""},
    {"D7", "rotations next to none and to half a turn", "turns", ""},
    {"D8", "tiny tags, corners of whole pixels", "tag-size-blur", ""},
    {"D9", "too few data", "points", "of one view; of calibrations: calibrate-views-tilt"},
    {"D10", "nearly a plane", "flatness", ""},
    {"D11", "targets that are not the plane z = 0", "flatness", "of one view"},
    {"D12", "pictures that are empty or broken", "", "a test of the reader, not of an estimate"},
};

}  // namespace

std::string catalogue_text(std::span<const AtlasSheet> sheets) {
  std::string text = "\n## The catalogue of failures\n\n| | condition | where |\n|---|---|---|\n";
  for (const Entry& entry : kCatalogue) {
    const std::string name = entry.map;
    const bool here = std::any_of(sheets.begin(), sheets.end(),
                                  [&](const AtlasSheet& sheet) { return sheet.map.name == name; });
    std::string where = here ? fmt::format("[{}]({}.csv)", name, name) : name;
    if (*entry.remark) where += (where.empty() ? "no map: " : "; ") + std::string(entry.remark);
    text += fmt::format("| {} | {} | {} |\n", entry.id, entry.condition, where);
  }
  return text;
}

}  // namespace tagcal::study
