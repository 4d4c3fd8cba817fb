#include "tagcal/detect/checker_search/junctions.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "tagcal/detect/opencv/picture_filters.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

// Grey levels per px^2. Least root of minus the Hessian's determinant of the smoothed picture: a
// junction of contrast C and spread s has C / (pi s^2).
constexpr double kSpreadPx = 1.46;  // numeric: of a picture that is sharp enough, smoothed
constexpr double kMinStrength = policy::kMinContrast / (kSpreadPx * kSpreadPx * pi);

struct Hessian {
  float xx, xy, yy;
};

// From the rows above, of and below a pixel.
inline Hessian hessian(const float* a, const float* b, const float* c) {
  const float two = 2, quarter = 0.25F;  // numeric: second differences
  return {b[-1] - two * b[0] + b[1], quarter * (c[1] - c[-1] - a[1] + a[-1]),
          a[0] - two * b[0] + c[0]};
}

// Saddle strength of a row: minus the determinant of the Hessian; zero at the picture's border.
void saddles(const ImageF& image, int y, float* to) {
  std::fill_n(to, image.width(), 0.F);
  if (y == 0 || y + 1 == image.height()) return;
  const float *a = image.row(y - 1), *b = image.row(y), *c = image.row(y + 1);
  for (int x = 1; x + 1 < image.width(); ++x) {
    const Hessian h = hessian(a + x, b + x, c + x);
    to[x] = std::max(0.F, h.xy * h.xy - h.xx * h.yy);
  }
}

// Precondition: the place is in the picture, a pixel from its right and lower edge.
inline float sample(const ImageF& image, const Vector2d& at) {
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  const auto u = static_cast<float>(at.x() - x), v = static_cast<float>(at.y() - y);
  const float *a = image.row(y) + x, *b = image.row(y + 1) + x;
  return (1 - v) * ((1 - u) * a[0] + u * a[1]) + v * ((1 - u) * b[0] + u * b[1]);
}

// True if opposite quarters have one colour: a third one, of a table or wall beside the board, is
// nearer to one of the two than half of their difference.
bool has_two_colours(const ImageF& image, const Junction& junction, double radius) {
  const auto level = [&](double angle) {
    return sample(image, junction.at + radius * Vector2d(std::cos(angle), std::sin(angle)));
  };
  const double white = (junction.first + junction.second) / 2, black = white + pi / 2;
  const auto [least_white, most_white] = std::minmax({level(white), level(white + pi)});
  const auto [least_black, most_black] = std::minmax({level(black), level(black + pi)});
  return 2 * (least_white - most_black) > most_white - least_black;
}

constexpr int kSamples = 32;  // on a circle
using CircleLevels = Eigen::Array<float, kSamples, 1>;

struct UnitCircle {
  CircleLevels x, y;

  UnitCircle() {
    for (int i = 0; i < kSamples; ++i) {
      const double angle = 2 * pi * i / kSamples;
      x[i] = static_cast<float>(std::cos(angle));
      y[i] = static_cast<float>(std::sin(angle));
    }
  }
};

// Precondition: the circle is in the picture, a pixel from its right and lower edge.
CircleLevels levels_on_circle(const ImageF& image, const Vector2d& at, double radius) {
  static const UnitCircle kCircle;
  // Places from the pixel of the circle's corner: positive, of few digits.
  const Vector2d corner = (at.array() - radius).floor();
  const auto first_x = static_cast<float>(at.x() - corner.x()),
             first_y = static_cast<float>(at.y() - corner.y()), r = static_cast<float>(radius);
  const float* first = image.row(static_cast<int>(corner.y())) + static_cast<int>(corner.x());
  const std::ptrdiff_t width = image.width();
  const CircleLevels in_x = first_x + r * kCircle.x, in_y = first_y + r * kCircle.y;
  const Eigen::Array<std::int32_t, kSamples, 1> x = in_x.cast<std::int32_t>(),
                                                y = in_y.cast<std::int32_t>();
  const CircleLevels u = in_x - x.cast<float>(), v = in_y - y.cast<float>();
  CircleLevels level;
  for (int i = 0; i < kSamples; ++i) {
    const float *a = first + y[i] * width + x[i], *b = a + width;
    const float above = a[0] + u[i] * (a[1] - a[0]), below = b[0] + u[i] * (b[1] - b[0]);
    level[i] = above + v[i] * (below - above);
  }
  return level;
}

// The two lines through a place, from the four borders that a circle about it crosses; no value for
// another number of borders, or borders that are not opposite.
std::optional<Junction> junction_on_circle(const ImageF& image, const Vector2d& at, double radius) {
  const Vector2d reach = Vector2d::Constant(radius + 1);
  const Vector2d last(image.width() - 1, image.height() - 1);
  if (((at - reach).array() < 0).any() || ((at + reach).array() >= last.array()).any())
    return std::nullopt;
  const CircleLevels level = levels_on_circle(image, at, radius);
  const float low = level.minCoeff(), high = level.maxCoeff();
  if (high - low < policy::kMinContrast) return std::nullopt;
  const float middle = (low + high) / 2;
  std::uint32_t white = 0;  // bit i: of sample i
  for (int i = 0; i < kSamples; ++i) white |= static_cast<std::uint32_t>(level[i] > middle) << i;
  std::uint32_t borders = white ^ std::rotr(white, 1);  // before the next sample
  if (std::popcount(borders) != 4) return std::nullopt;
  std::array<double, 2> up{}, down{};  // angles at which white begins and ends
  std::size_t num_up = 0, num_down = 0;
  for (; borders != 0; borders &= borders - 1) {
    const int i = std::countr_zero(borders);
    const float a = level[i] - middle, b = level[(i + 1) % kSamples] - middle;
    (b > 0 ? up[num_up++] : down[num_down++]) =
        2 * pi * (static_cast<float>(i) + a / (a - b)) / kSamples;
  }
  if (std::abs(up[1] - up[0] - pi) > policy::kMaxTurn ||
      std::abs(down[1] - down[0] - pi) > policy::kMaxTurn)
    return std::nullopt;
  Junction junction{at, (up[0] + up[1] - pi) / 2, (down[0] + down[1] - pi) / 2, high - low, 0};
  while (junction.second <= junction.first) junction.second += pi;
  while (junction.second > junction.first + pi) junction.second -= pi;
  const double width = junction.second - junction.first;
  if (width < policy::kMaxTurn || width > pi - policy::kMaxTurn) return std::nullopt;
  if (!has_two_colours(image, junction, radius)) return std::nullopt;
  return junction;
}

// The saddle point near a pixel: where the gradient vanishes.
Vector2d saddle_point(const ImageF& image, int x, int y) {
  const Hessian h = hessian(image.row(y - 1) + x, image.row(y) + x, image.row(y + 1) + x);
  const Vector2d gradient(image(x + 1, y) - image(x - 1, y), image(x, y + 1) - image(x, y - 1));
  const double det = h.xx * h.yy - h.xy * h.xy;
  const Vector2d step(-(h.yy * gradient.x() - h.xy * gradient.y()) / (2 * det),
                      -(h.xx * gradient.y() - h.xy * gradient.x()) / (2 * det));
  return Vector2d(x, y) + step.cwiseMax(-1.0).cwiseMin(1.0);
}

constexpr int kStrengthRows = 5;  // numeric: a window about a peak

using StrengthRows = std::array<const float*, kStrengthRows>;

// True for the strongest of 5x5 pixels, in rows from above to below; of equal ones the first.
bool is_peak(const StrengthRows& rows, int x) {
  constexpr int kReach = kStrengthRows / 2;
  const float here = rows[kReach][x];
  for (int v = -kReach; v <= kReach; ++v)
    for (int u = -kReach; u <= kReach; ++u) {
      const float there = rows[static_cast<std::size_t>(v + kReach)][x + u];
      if ((u != 0 || v != 0) && (there > here || (there == here && (v < 0 || (v == 0 && u < 0)))))
        return false;
    }
  return true;
}

// Calls visit(x) for the peaks of a row that are as strong as `least`, but for 3 px at its ends.
template <typename Visit>
void visit_peaks(const StrengthRows& rows, int width, float least, const Visit& visit) {
  constexpr int kAtOnce = 32;  // numeric: pixels that are compared without a branch
  std::array<std::uint8_t, kAtOnce> may_be_peak;
  const float *above = rows[1], *row = rows[2], *below = rows[3];
  const int last = width - 3;
  for (int begin = 3; begin < last; begin += kAtOnce) {
    const int count = std::min(last - begin, kAtOnce);
    int any = 0;
    for (int i = 0; i < count; ++i) {
      const int x = begin + i;
      const bool is_strong = (row[x] >= least) & (row[x] > row[x - 1]) & (row[x] >= row[x + 1]) &
                             (row[x] > above[x]) & (row[x] >= below[x]);
      may_be_peak[static_cast<std::size_t>(i)] = is_strong;
      any |= is_strong;
    }
    if (any == 0) continue;
    for (int i = 0; i < count; ++i)
      if (may_be_peak[static_cast<std::size_t>(i)] && is_peak(rows, begin + i)) visit(begin + i);
  }
}

}  // namespace

std::vector<Junction> find_junctions(const ImageView8& image) {
  const ImageF smooth = smoothed(image);
  ImageF strength({image.width(), kStrengthRows});  // the last rows
  const auto least = static_cast<float>(std::pow(kMinStrength, 2));
  std::vector<Junction> junctions;
  int next = 0;
  for (int y = 3; y + 3 < image.height(); ++y) {
    for (; next <= y + 2; ++next) saddles(smooth, next, strength.row(next % kStrengthRows));
    StrengthRows rows;
    for (int i = 0; i < kStrengthRows; ++i)
      rows[static_cast<std::size_t>(i)] = strength.row((y + i - kStrengthRows / 2) % kStrengthRows);
    visit_peaks(rows, image.width(), least, [&](int x) {
      const Vector2d at = saddle_point(smooth, x, y);
      for (const double radius : policy::kJunctionRadiiPx) {
        auto junction = junction_on_circle(smooth, at, radius);
        if (!junction) continue;
        junction->strength = std::sqrt(rows[2][x]);
        junctions.push_back(*junction);
        break;
      }
    });
  }
  std::ranges::stable_sort(junctions, std::ranges::greater(), &Junction::strength);
  return junctions;
}

}  // namespace tagcal::internal
