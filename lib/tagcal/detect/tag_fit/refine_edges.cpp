#include "tagcal/detect/tag_fit/refine_edges.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tagcal::internal {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr double kStartBlur = 0.85;  // sd of the edge's spread, px: a sharp lens and the pixel
constexpr double kLeastBlur = 0.25;  // sd of a pixel's square and a little less
constexpr double kMostLogBlur = 3;
constexpr double kMaxMove = 2.0;       // px
constexpr double kMinContrast = 8;     // grey levels
constexpr double kBendPerPx = 3e-4;    // sd of the curvature that lenses give to edges, 1/px
constexpr double kTwistPerPx2 = 2e-6;  // and of its change along the edge, 1/px^2
constexpr double kLogBlurSd = 0.5;     // how far the blur is believed to be from its start
constexpr int kSelections = 3;         // times the pixels are chosen anew about the edge
constexpr int kSteps = 6;              // Gauss-Newton steps for each
constexpr double kShorter = 0.3;       // a step that was too long
constexpr double kLevelShare = 0.3;    // sd of the levels, of their difference
constexpr double kSettledPx = 2e-3;    // a smaller step is the last one
constexpr double kSettledLogBlur = 0.02;
constexpr double kSameStripPx = 0.05;  // moves that need no new choice of pixels

// A pixel near an edge: its place along it, in [-1, 1], its signed distance outwards, its level.
struct Sample {
  double along;
  double outwards;
  double level;
};

// An edge from `middle - half * direction` to `middle + half * direction`. Its points lie at
// offset() along the outward normal.
struct Edge {
  Eigen::Vector2d middle;
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;
  double half = 0;
  double reach = 0;  // of the strip of pixels, to either side
  // Offset at the middle, slope, bend; level inside, step to the outside; log of the blur; twist.
  Vector7 fit = Vector7::Zero();

  double blur() const { return std::exp(fit[5]); }
  double slope(double along) const { return fit[1] + along * (2 * fit[2] + along * 3 * fit[6]); }
  double offset(double along) const {
    return fit[0] + along * (fit[1] + along * (fit[2] + along * fit[6]));
  }
};

Edge edge_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Edge edge;
  edge.middle = 0.5 * (from + to);
  edge.half = 0.5 * (to - from).norm();
  edge.direction = (to - from) / (2 * edge.half);
  // Corners run counter-clockwise as seen, y down: outwards is to the right of the way.
  edge.normal = {-edge.direction.y(), edge.direction.x()};
  edge.fit[5] = std::log(kStartBlur);
  return edge;
}

// The pixels of the strip about the edge's present place, without its ends.
std::vector<Sample> samples_about(const Edge& edge, const Image8& image) {
  std::vector<Sample> samples;
  const double margin = std::min(2.5 * edge.blur() + 0.5, 0.6 * edge.half);
  const double longest = edge.half - margin;
  const Eigen::Vector2d extent =
      longest * edge.direction.cwiseAbs() +
      (edge.reach + std::abs(edge.fit[0]) + std::abs(edge.fit[1])) * Eigen::Vector2d::Ones();
  const Eigen::Vector2d low = (edge.middle - extent).cwiseMax(0);
  const Eigen::Vector2d size(image.width() - 1, image.height() - 1);
  const Eigen::Vector2d high = (edge.middle + extent).cwiseMin(size);
  for (int y = static_cast<int>(std::ceil(low.y())); y <= high.y(); ++y) {
    for (int x = static_cast<int>(std::ceil(low.x())); x <= high.x(); ++x) {
      const Eigen::Vector2d away = Eigen::Vector2d(x, y) - edge.middle;
      const double along = away.dot(edge.direction);
      if (std::abs(along) > longest) continue;
      const double outwards = away.dot(edge.normal);
      if (std::abs(outwards - edge.offset(along / edge.half)) > edge.reach) continue;
      samples.push_back({along / edge.half, outwards, static_cast<double>(image(x, y))});
    }
  }
  return samples;
}

// From the outer half of the pixels on either side. False where a side has none.
bool start_levels(Edge& edge, const std::vector<Sample>& samples) {
  double furthest[2] = {0, 0}, sum[2] = {0, 0};
  int count[2] = {0, 0};
  const auto outwards = [&](const Sample& s) { return s.outwards - edge.offset(s.along); };
  for (const Sample& sample : samples) {
    double& so_far = furthest[outwards(sample) > 0];
    so_far = std::max(so_far, std::abs(outwards(sample)));
  }
  for (const Sample& sample : samples) {
    const bool side = outwards(sample) > 0;
    if (std::abs(outwards(sample)) < 0.5 * furthest[side]) continue;
    sum[side] += sample.level;
    ++count[side];
  }
  if (count[0] == 0 || count[1] == 0) return false;
  edge.fit[3] = sum[0] / count[0];
  edge.fit[4] = sum[1] / count[1] - edge.fit[3];
  return true;
}

// The normal distribution and its density, interpolated between places 1/64 apart: to 1e-5.
class NormalTable {
 public:
  struct Value {
    double below = 0;
    double density = 0;
  };

  NormalTable() {
    for (int i = 0; i <= kCount; ++i) {
      const double z = static_cast<double>(i) / kPerUnit - kEnd;
      values_[static_cast<std::size_t>(i)] = {
          0.5 * std::erfc(-z / std::numbers::sqrt2),
          std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2};
    }
  }

  Value at(double z) const {
    const double place = (std::clamp(z, -kEnd, kEnd) + kEnd) * kPerUnit;
    const int i = std::min(static_cast<int>(place), kCount - 1);
    const double share = place - i;
    const Value& a = values_[static_cast<std::size_t>(i)];
    const Value& b = values_[static_cast<std::size_t>(i + 1)];
    return {a.below + share * (b.below - a.below), a.density + share * (b.density - a.density)};
  }

 private:
  static constexpr double kEnd = 5;
  static constexpr int kPerUnit = 64;
  static constexpr int kCount = 2 * 5 * kPerUnit;
  std::array<Value, kCount + 1> values_;
};

const NormalTable kNormal;

struct NormalEquations {
  Matrix7 information = Matrix7::Zero();
  Vector7 gradient = Vector7::Zero();
  double squares = 0;
};

// Of level = inside + step Phi((outwards - offset(along)) / blur).
NormalEquations equations_of(const Edge& edge, const std::vector<Sample>& samples) {
  NormalEquations sums;
  const double per_blur = 1 / edge.blur();
  for (const Sample& sample : samples) {
    const double z = (sample.outwards - edge.offset(sample.along)) * per_blur;
    const auto [share, density] = kNormal.at(z);
    const double residual = sample.level - edge.fit[3] - edge.fit[4] * share;
    const double by_offset = -edge.fit[4] * density * per_blur;
    const double by_slope = by_offset * sample.along, by_bend = by_slope * sample.along;
    Vector7 row;
    row << by_offset, by_slope, by_bend, 1, share, -edge.fit[4] * density * z,
        by_bend * sample.along;
    sums.information.noalias() += row * row.transpose();
    sums.gradient += row * residual;
    sums.squares += residual * residual;
  }
  return sums;
}

// What is believed of an edge before its pixels are seen: short edges say too little of bend and
// twist, and narrow strips too little of blur and levels.
class Beliefs {
 public:
  explicit Beliefs(const Edge& edge) : centre_(edge.fit) {
    centre_[2] = centre_[6] = 0;
    centre_[5] = std::log(kStartBlur);
    const double level = kLevelShare * std::abs(edge.fit[4]) + 1;
    sd_ << 0, 0, 0.5 * kBendPerPx * edge.half * edge.half, level, level, kLogBlurSd,
        kTwistPerPx2 * std::pow(edge.half, 3) / 6;
  }

  double squares(const Edge& edge) const {
    double sum = 0;
    for (const int i : kBelieved) sum += std::pow((edge.fit[i] - centre_[i]) / sd_[i], 2);
    return sum;
  }

  // Weighed against the noise of the pixels.
  void add(const Edge& edge, double variance, NormalEquations& sums) const {
    for (const int i : kBelieved) {
      const double weight = variance / (sd_[i] * sd_[i]);
      sums.information(i, i) += weight;
      sums.gradient[i] -= weight * (edge.fit[i] - centre_[i]);
    }
  }

 private:
  static constexpr std::array kBelieved = {2, 3, 4, 5, 6};
  Vector7 centre_;
  Vector7 sd_;
};

// Gauss-Newton; a step that makes it worse is shortened. False where there is no end.
bool fit_to(const std::vector<Sample>& samples, const Beliefs& beliefs, Edge& edge) {
  Edge best = edge;
  Vector7 change = Vector7::Zero();
  double squares = 0, variance = 0;
  for (int i = 0; i < kSteps; ++i) {
    NormalEquations sums = equations_of(edge, samples);
    const bool worse = i > 0 && sums.squares + variance * beliefs.squares(edge) >
                                    squares + variance * beliefs.squares(best);
    if (worse) {
      change *= kShorter;
    } else {
      best = edge;
      squares = sums.squares;
      variance = std::max(0.1, squares / static_cast<double>(samples.size() - 7));
      beliefs.add(edge, variance, sums);
      change = sums.information.ldlt().solve(sums.gradient);
      if (!change.allFinite()) return false;
      for (const int k : {0, 1, 5}) change[k] = std::clamp(change[k], -0.5, 0.5);
    }
    edge = best;
    edge.fit += change;
    edge.fit[5] = std::max(edge.fit[5], std::log(kLeastBlur));
    if (!(std::abs(edge.fit[0]) < kMaxMove && edge.fit[5] < kMostLogBlur)) return false;
    const double moved = std::abs(change[0]) + std::abs(change[1]) + std::abs(change[2]);
    if (moved < kSettledPx && std::abs(change[5]) < kSettledLogBlur) break;
  }
  return true;
}

bool fit_edge(Edge& edge, const Image8& image, double cell, bool dark_inside) {
  for (int selection = 0; selection < kSelections; ++selection) {
    // At least three rows of pixels, or as many as the neighbouring cells leave free.
    const double least = std::clamp(0.8 * cell, 1.2, 1.6);
    edge.reach = std::max(least, std::min(0.65 * cell, 2.5 * edge.blur() + 1.0));
    const std::vector<Sample> samples = samples_about(edge, image);
    if (samples.size() < 16) return false;
    if (!start_levels(edge, samples)) return false;
    const Vector7 before = edge.fit;
    if (!fit_to(samples, Beliefs(edge), edge)) return false;
    const Vector7 change = (edge.fit - before).cwiseAbs();
    if (selection > 0 && change[0] + change[1] + change[2] < kSameStripPx) break;
  }
  return (dark_inside ? edge.fit[4] : -edge.fit[4]) >= kMinContrast;
}

// Where two edges meet: the intersection of their tangents near the corner, repeated.
Eigen::Vector2d corner_between(const Edge& a, const Edge& b, Eigen::Vector2d corner) {
  const auto tangent = [](const Edge& edge, const Eigen::Vector2d& near) {
    const double along = (near - edge.middle).dot(edge.direction) / edge.half;
    const double slope = edge.slope(along) / edge.half;
    const Eigen::Vector2d point =
        edge.middle + along * edge.half * edge.direction + edge.offset(along) * edge.normal;
    const Eigen::Vector2d normal = edge.normal - slope * edge.direction;
    return Eigen::Vector3d(normal.x(), normal.y(), -normal.dot(point));
  };
  for (int i = 0; i < 3; ++i) corner = tangent(a, corner).cross(tangent(b, corner)).hnormalized();
  return corner;
}

// The distance from edge i to the opposite one, over the cells between them.
double cell_at(const Quad& quad, const Edge& edge, std::size_t i, int cells) {
  const Eigen::Vector2d opposite = 0.5 * (quad[(i + 2) % 4] + quad[(i + 3) % 4]);
  return std::abs((opposite - edge.middle).dot(edge.normal)) / cells;
}

}  // namespace

std::optional<Quad> refine_edges(const Image8& image, const Quad& start, const QuadShape& shape) {
  std::array<Edge, 4> edges;
  for (std::size_t i = 0; i < 4; ++i) {
    edges[i] = edge_between(start[i], start[(i + 1) % 4]);
    const double cell = cell_at(start, edges[i], i, shape.cells);
    if (!fit_edge(edges[i], image, cell, shape.dark_inside)) return std::nullopt;
  }
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    quad[i] = corner_between(edges[(i + 3) % 4], edges[i], start[i]);
    const double moved = (quad[i] - start[i]).norm();
    if (!(moved <= kMaxMove)) return std::nullopt;  // not a number is no corner either
  }
  return quad;
}

}  // namespace tagcal::internal
