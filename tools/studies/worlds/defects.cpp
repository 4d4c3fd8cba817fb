#include "defects.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "draw.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

// In the order of Defect. Four kinds of 15 % leave half of the worlds with right data.
constexpr DefectKind kKinds[] = {
    {"bend", 0.15, true, true, "the board is bent along x and y"},
    {"twist", 0.15, true, true, "the board is twisted"},
    {"aspect", 0.15, false, true, "the print is longer along y, and often skewed"},
    {"rows", 0.15, false, true, "a motion shears the rows of each view"},
    {"few", 1.0 / 3, true, true, "one to five views"},
    {"light", 0.3, true, false, "a lamp near the board, and vignetting"},
    {"outliers", 0.2, false, true, "one to three percent of the corners are grossly wrong"},
    {"bare", 0.25, false, true, "corners without covariances"},
    {"camera", 0, true, false, "the camera changes its pictures in one of the ways below"}};

// Shares of the board's diagonal or of a length. From what no calibration notices to a sheet of
// paper that is glued by hand (0.4 %: 2.4 mm of 60 cm) or scaled by a printer's driver.
constexpr double kLeastShare = 2e-4, kLargestShare = 4e-3;
// px. From the noise of a corner to a camera that is turned by hand during the read-out of its
// rows.
constexpr double kLeastShear_px = 0.05, kLargestShear_px = 2;
constexpr std::size_t kMostFewViews = 5;
constexpr double kShareSkewed = 0.5;          // of the prints with another aspect
constexpr std::uint64_t kFirstStream = 1000;  // stream_of: of the defects

// `name` may be that of a defect and a kind of pictures, "camera:jpeg".
const DefectKind& kind_named(const std::string& name) {
  const std::size_t end = std::min(name.find(':'), name.size());
  const auto* const found = std::ranges::find(kKinds, name.substr(0, end), &DefectKind::name);
  if (found == std::end(kKinds))
    throw Error(fmt::format("{}: unknown defect; they are\n{}", name, help_on_defects()));
  if (end == name.size()) return *found;
  const std::vector<std::string> pictures = picture_kinds();
  if (found != &kind_of(Defect::camera) ||
      std::ranges::find(pictures, name.substr(end + 1)) == pictures.end())
    throw Error(fmt::format("{}: unknown kind of pictures; they are camera:{}", name,
                            fmt::join(pictures, ", camera:")));
  return *found;
}

bool has(const WorldId& id, Defect defect, Random& random) {
  const DefectKind& kind = kind_of(defect);
  const bool drawn = random.uniform() < kind.share;
  if (!(id.mode == kPixels ? kind.in_pixels : kind.in_corners)) return false;
  if (id.switches.find(fmt::format("+{}", kind.name)) != std::string::npos) return true;
  return drawn && id.switches.find(fmt::format("-{}", kind.name)) == std::string::npos;
}

double share(Random& random) { return signed_log_uniform(kLeastShare, kLargestShare, 0.5, random); }

void add(Defect defect, Random& random, Defects& d) {
  switch (defect) {
    case Defect::bend:
      d.bend.x() = share(random);
      d.bend.y() = share(random);
      break;
    case Defect::twist:
      d.twist = share(random);
      break;
    case Defect::aspect:
      d.aspect = share(random);
      if (random.uniform() < kShareSkewed) d.skew = share(random);
      break;
    case Defect::rows:
      d.rows_px = log_uniform(kLeastShear_px, kLargestShear_px, random);
      break;
    case Defect::few:
      d.most_views = 1 + static_cast<int>(random.index(kMostFewViews));
      break;
    case Defect::light:
      d.uneven_light = true;
      break;
    case Defect::outliers:
      d.outliers = true;
      break;
    case Defect::bare:
      d.covariances = false;
      break;
    case Defect::camera:
      d.camera = true;
      break;
  }
}

}  // namespace

const DefectKind& kind_of(Defect defect) { return kKinds[static_cast<std::size_t>(defect)]; }

std::string_view help_on_defects() {
  static const std::string text = [] {
    std::string lines;
    for (const DefectKind& kind : kKinds)
      lines += fmt::format("  {:9} {:3.0f} %  {}{}\n", kind.name, 100 * kind.share, kind.is,
                           !kind.in_pixels    ? " (only with --corners-only)"
                           : !kind.in_corners ? " (not with --corners-only)"
                                              : "");
    return lines + fmt::format("Ways to change pictures, as in --with camera:jpeg:\n  {}\n",
                               fmt::join(picture_kinds(), ", "));
  }();
  return text;
}

std::string switches_text(const std::vector<std::string>& with,
                          const std::vector<std::string>& without, std::string_view mode) {
  for (const std::string& name : without) kind_named(name);
  std::set<std::string> parts;
  for (const std::string& name : without) parts.insert("-" + name);
  for (const std::string& name : with) {
    const DefectKind& kind = kind_named(name);
    if (parts.contains(fmt::format("-{}", kind.name)))
      throw Error("--with and --without: both have " + name);
    if (!(mode == kPixels ? kind.in_pixels : kind.in_corners))
      throw Error(fmt::format("--with {}: worlds of {} do not have it", name, mode));
    parts.insert("+" + name);
  }
  std::string text;
  for (const std::string& part : parts) text += part;
  return text;
}

std::string fixed_pictures(const WorldId& id) {
  constexpr std::string_view kPrefix = "+camera:";
  const std::size_t start = id.switches.find(kPrefix);
  if (start == std::string::npos) return "";
  const std::string rest = id.switches.substr(start + kPrefix.size());
  return rest.substr(0, rest.find_first_of("+-"));
}

Random stream_of(const WorldId& id, std::uint64_t part) {
  return {Random(id.seed, id.index).next(), part};
}

Defects draw_defects(const WorldId& id) {
  Defects defects;
  for (std::size_t i = 0; i < std::size(kKinds); ++i) {
    const auto defect = static_cast<Defect>(i);
    Random random = stream_of(id, kFirstStream + i);
    if (has(id, defect, random)) add(defect, random, defects);
  }
  return defects;
}

std::string names_of(const Defects& d) {
  std::string names;
  const auto add = [&](bool present, Defect defect) {
    if (present) names.append(names.empty() ? "" : "+").append(kind_of(defect).name);
  };
  add(!d.bend.isZero(0), Defect::bend);
  add(d.twist != 0, Defect::twist);
  add(d.aspect != 0, Defect::aspect);
  add(d.rows_px != 0, Defect::rows);
  return names;
}

RealBoard::RealBoard(const Board& board, const Defects& defects) : defects_(defects) {
  const auto points = target_points(board);
  Eigen::Vector3d low = points.front().position, high = low;
  for (const TargetPoint& p : points) {
    low = low.cwiseMin(p.position);
    high = high.cwiseMax(p.position);
  }
  centre_ = (low + high).head<2>() / 2;
  half_size_ = (high - low).head<2>() / 2;
}

Eigen::Vector3d RealBoard::place_of(const Eigen::Vector3d& x_in_board) const {
  const Eigen::Vector2d from_centre = x_in_board.head<2>() - centre_;
  const Eigen::Array2d relative = from_centre.array() / half_size_.array();
  const double height =
      defects_.bend.dot((1 - relative.square()).matrix()) + defects_.twist * relative.prod();
  return x_in_board + Eigen::Vector3d(defects_.skew * from_centre.y(),
                                      defects_.aspect * from_centre.y(),
                                      2 * half_size_.norm() * height);
}

double log_uniform(double low, double high, Random& random) {
  return low * std::pow(high / low, random.uniform());
}

double signed_log_uniform(double low, double high, double share_negative, Random& random) {
  const double size = log_uniform(low, high, random);
  return random.uniform() < share_negative ? -size : size;
}

}  // namespace tagcal
