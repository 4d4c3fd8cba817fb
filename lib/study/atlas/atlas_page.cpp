#include "study/atlas/atlas_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tagcal::study {
namespace {

constexpr const char* kIntroduction =
    "# Where methods fail: the atlas\n\n"
    "Each map sweeps one or two quantities to where methods break. In every cell the same seeded "
    "problems go to ours and to the peers, and what each says is held against the truth:\n\n"
    "- **right and said so**: an answer, and the truth is where it says;\n"
    "- **wrong and said so**: refused where nothing could be known, or two answers of which the "
    "truth is the second;\n"
    "- **wrong and silent**: an answer, and none of what it says is true;\n"
    "- **right but refused**: refused what could be known.\n\n"
    "*Wrong* of a method that claims a covariance (ours): the truth is outside of the 5-sigma "
    "ellipsoid of what it claims (chi-square, probability 5.7e-7). Of one that claims none (the "
    "peers): the error is outside of that ellipsoid of the Cramér-Rao bound at the truth (never of "
    "less noise than 0.01 px), or gross: a rotation off by 30°, a focal length by half, a point "
    "behind the camera. *Could be known*: a standard deviation at the bound below 5 % of the focal "
    "length; of a pose below 0.05 rad and 5 % of the distance; of data that are wrong in part, the "
    "right ones agree better than wrong ones would by chance. Refused between the two rules is "
    "neither right nor wrong, and counts as said so.\n\n"
    "Of calibrations focal length and principal point are judged, of maps of lenses the projection "
    "at infinity (RMS, a turned camera taken out), of extrapolation that at the image's corners; "
    "coefficients never are. OpenCV claims its standard deviations, taken as independent. *Could "
    "be known*: the bound has below 5 % of the focal length and 1 px RMS of the projection. An "
    "answer with a warning that lens or board may not be as stated has said so.\n\n"
    "Of tags in pictures *wrong* is a corner outside of its 5-sigma ellipse: of ours that which it "
    "claims, 0.5 px where it claims none (so the estimators take it); of the peers that of the "
    "bound and 0.1 px. A tag *could be known* that is 12 px wide and more, its narrowest cells "
    "twice as wide as the blur's standard deviation (a pixel's square included).\n\n"
    "The marks: in each cell of a map of poses, and over each map of calibrations or of pictures, "
    "ours is wrong and silent in fewer than 1 of 1,000 trials, and refuses fewer than 2 % of what "
    "can be known. The columns of the tables behind the pictures are "
    "explained in `lib/study/atlas/stability_file.hpp`.\n";

std::string percent(double share) {
  const double p = 100 * share;
  if (p == 0) return "0 %";
  return p < 0.1 ? fmt::format("{:.2g} %", p) : fmt::format("{:.3g} %", p);
}

class Sheet {
 public:
  explicit Sheet(const AtlasSheet& sheet) : map_(sheet.map), result_(sheet.result) {}

  std::string text() const {
    std::string page = fmt::format("\n## {}\n\n", map_.title);
    page += fmt::format("![{0}]({0}.png)\n\n", map_.name);
    page +=
        fmt::format("{}{}. {}. {}{}.\n\n", map_.what, failures(), map_.why, map_.answer, ours());
    page += flips() + table();
    for (const std::string& why : map_.exempt) page += fmt::format("- Exempt: {}.\n", why);
    return page + fmt::format("{}Numbers: [{}.csv]({}.csv)\n", map_.exempt.empty() ? "" : "\n",
                              map_.name, map_.name);
  }

  std::string misses() const {
    std::string text;
    for (const StabilityTally& t : missing_marks(map_, result_)) {
      const std::string where =
          map_.mark_over_map ? fmt::format("over the map (trials of {})", map_.cell_label(t.cell))
                             : map_.cell_label(t.cell);
      text += fmt::format("- {}: {}, {}: wrong and silent {} of {}{}, refused {}{}\n", map_.name,
                          map_.methods[t.method].name, where,
                          t.of(StabilityOutcome::wrong_and_silent), t.trials, trial(t.first_silent),
                          t.of(StabilityOutcome::right_but_refused), trial(t.first_refused));
    }
    return text;
  }

 private:
  static std::string trial(int t) { return t < 0 ? "" : fmt::format(" (the first: trial {})", t); }

  // An outcome of a method over the map: its share, and the cell with the largest share.
  struct Sum {
    int of = 0, trials = 0;
    double worst = 0;
    std::size_t cell = 0;
    double share() const { return trials > 0 ? static_cast<double>(of) / trials : 0; }
  };

  Sum sum_of(std::size_t method, StabilityOutcome outcome) const {
    Sum sum;
    for (const StabilityTally& t : result_.tallies) {
      if (t.method != method) continue;
      sum.of += t.of(outcome);
      sum.trials += t.trials;
      if (t.share(outcome) > sum.worst) sum.worst = t.share(outcome), sum.cell = t.cell;
    }
    return sum;
  }

  // The two peers of the picture with the most silent failures.
  std::string failures() const {
    std::vector<std::pair<double, std::size_t>> peers;
    for (std::size_t m = 0; m < map_.methods.size(); ++m) {
      const Sum sum = sum_of(m, StabilityOutcome::wrong_and_silent);
      if (!map_.methods[m].ours && map_.methods[m].drawn && sum.of > 0)
        peers.emplace_back(-sum.share(), m);
    }
    std::sort(peers.begin(), peers.end());
    std::string text;
    for (std::size_t i = 0; i < std::min<std::size_t>(2, peers.size()); ++i) {
      const std::size_t m = peers[i].second;
      const Sum sum = sum_of(m, StabilityOutcome::wrong_and_silent);
      text += fmt::format("{}{} is wrong and silent in {} of all trials, and in {} at {}",
                          i == 0 ? ": " : "; ", map_.methods[m].name, percent(sum.share()),
                          percent(sum.worst), map_.cell_label(sum.cell));
    }
    return text;
  }

  std::string ours() const {
    std::string text;
    for (std::size_t m = 0; m < map_.methods.size(); ++m) {
      if (!map_.methods[m].ours) continue;
      const Sum silent = sum_of(m, StabilityOutcome::wrong_and_silent);
      const Sum refused = sum_of(m, StabilityOutcome::right_but_refused);
      const Sum said = sum_of(m, StabilityOutcome::wrong_and_said);
      text += fmt::format(
          "{}{}wrong and silent {} of {} times ({} in the worst cell), wrong and said so in {}, "
          "refused what could be known in {}",
          text.empty() ? ": " : "; ", text.empty() ? "" : map_.methods[m].name + " ", silent.of,
          silent.trials, percent(silent.worst), percent(said.share()), percent(refused.share()));
    }
    return text;
  }

  std::string flips() const {
    if (!map_.expected_flips) return "";
    double worst = 0;
    std::size_t cell = 0;
    double measured = 0, expected = 0;
    int cells = 0;
    for (const StabilityTally& t : result_.tallies) {
      const auto share = map_.expected_flips(map_.values(t.cell));
      if (t.method != 0 || !share || t.trials == 0) continue;
      ++cells;
      const double flipped = static_cast<double>(t.flips) / t.trials;
      if (std::abs(flipped - *share) < worst) continue;
      worst = std::abs(flipped - *share), cell = t.cell, measured = flipped, expected = *share;
    }
    return fmt::format(
        "The likeliest pose is the mirrored one as often as the closed form has it to within "
        "{:.1f} "
        "points in all of {} cells; most differs {}: {} measured, {} expected.\n\n",
        100 * worst, cells, map_.cell_label(cell), percent(measured), percent(expected));
  }

  std::string table() const {
    std::string text =
        "| method | right and said so | wrong and said so | wrong and silent | in the worst cell | "
        "refused what could be known | time, µs |\n|---|--:|--:|--:|--:|--:|--:|\n";
    for (std::size_t m = 0; m < map_.methods.size(); ++m) {
      const Sum silent = sum_of(m, StabilityOutcome::wrong_and_silent);
      std::vector<double> times;
      for (const StabilityTally& t : result_.tallies)
        if (t.method == m) times.push_back(t.time_us);
      std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2),
                       times.end());
      text += fmt::format("| {} | {} | {} | {} | {} | {} | {:.3g} |\n", map_.methods[m].name,
                          percent(sum_of(m, StabilityOutcome::right_and_said).share()),
                          percent(sum_of(m, StabilityOutcome::wrong_and_said).share()),
                          percent(silent.share()), percent(silent.worst),
                          percent(sum_of(m, StabilityOutcome::right_but_refused).share()),
                          times[times.size() / 2]);
    }
    return text + "\n";
  }

  const StabilityMap& map_;
  const StabilityResult& result_;
};

std::string methods(std::span<const AtlasSheet> sheets) {
  std::vector<std::string> lines;
  for (const AtlasSheet& sheet : sheets)
    for (const StabilityMethod& m : sheet.map.methods) {
      const std::string line = fmt::format("- {}: {}\n", m.name, m.settings);
      if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
    }
  std::string text = "\n## Methods\n\n";
  for (const std::string& line : lines) text += line;
  return text;
}

struct Entry {
  const char* id;
  const char* condition;
  const char* map;     // its name; empty: none
  const char* remark;  // why no map shows it, or what the map omits
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

// The known failures of geometry (G), models (M) and data (D) in Markdown, each with its map, the
// reason of its exemption, or neither. Maps that are on the page are linked.
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

}  // namespace

std::string atlas_page(std::span<const AtlasSheet> sheets, std::span<const std::string> origin) {
  std::string page = kIntroduction, misses;
  for (const AtlasSheet& sheet : sheets) {
    const Sheet one(sheet);
    page += one.text();
    misses += one.misses();
  }
  page += "\n## Cells that miss the marks\n\n";
  page += misses.empty() ? "None.\n" : misses;
  page += catalogue_text(sheets) + methods(sheets) + "\n## Origin\n\n";
  for (const std::string& line : origin) page += fmt::format("- {}\n", line);
  return page;
}

}  // namespace tagcal::study
