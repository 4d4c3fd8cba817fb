#include "tagcal/detect/tag_fit/refine_edges.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"

namespace tagcal::internal {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;
constexpr std::size_t kFewestSamples = 2 * 7;  // of a side: twice the parameters
using Matrix7 = Eigen::Matrix<double, 7, 7>;

using namespace policy;

constexpr double kHalfPixel = 1.0 / 2;
constexpr double kRounding = 1.0 / 12;  // variance, levels squared
constexpr int kSelections = 3;          // selections of the pixels about the edge, at most
constexpr int kSteps = 6;               // Gauss-Newton steps for each
constexpr double kShorter = 0.3;        // numeric: factor for a step that was too long
constexpr double kMaxStep = 0.5;        // numeric: largest step, of px and of the blur's logarithm
constexpr double kSettledPx = 2e-3;     // numeric: end of the iteration
constexpr double kSettledLogBlur = 0.02;  // numeric: end of the iteration
constexpr double kSameStripPx = 0.05;     // numeric: smaller moves need no new selection of pixels

// A pixel near an edge: its position along it, in [-1, 1], its signed distance outwards, its level.
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
  double reach = 0;  // half the width of the strip of pixels
  // Offset at the middle, slope, bend; level inside, step to the outside; log of the blur; twist.
  Vector7 fit = Vector7::Zero();

  double blur() const { return std::exp(fit[5]); }
  double felt() const { return kTagUnknownReach * blur() + kHalfPixel; }
  double slope(double along) const { return fit[1] + along * (2 * fit[2] + along * 3 * fit[6]); }
  double offset(double along) const {
    return fit[0] + along * (fit[1] + along * (fit[2] + along * fit[6]));
  }
};

Edge edge_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Edge edge;
  edge.middle = (from + to) / 2;
  edge.half = (to - from).norm() / 2;
  edge.direction = (to - from) / (2 * edge.half);
  // Corners run counter-clockwise as seen (y down), so outwards is to the right of `direction`.
  edge.normal = {-edge.direction.y(), edge.direction.x()};
  edge.fit[5] = std::log(kUsualSpreadPx);
  return edge;
}

// The pixels of a strip around the edge's present estimate, without its ends.
std::vector<Sample> samples_about(const Edge& edge, const ImageView8& image) {
  std::vector<Sample> samples;
  const double margin = std::min(edge.felt(), edge.half / 2);
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

// Starts the levels from the outer half of the pixels on either side. False if a side has none.
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
    if (std::abs(outwards(sample)) < furthest[side] / 2) continue;
    sum[side] += sample.level;
    ++count[side];
  }
  if (count[0] == 0 || count[1] == 0) return false;
  edge.fit[3] = sum[0] / count[0];
  edge.fit[4] = sum[1] / count[1] - edge.fit[3];
  return true;
}

// The normal distribution and its density, interpolated linearly between nodes 1/64 apart (error
// below 1e-5).
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
          std::erfc(-z / std::numbers::sqrt2) / 2,
          std::exp(-z * z / 2) * std::numbers::inv_sqrtpi / std::numbers::sqrt2};
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

// Normal equations of level = inside + step Phi((outwards - offset(along)) / blur).
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

// The prior of an edge: short edges do not determine bend and twist, and narrow strips do not
// determine blur and levels.
class EdgePrior {
 public:
  EdgePrior(const Edge& edge, const ImageSize& size) : centre_(edge.fit) {
    centre_[2] = centre_[6] = 0;
    centre_[5] = std::log(kUsualSpreadPx);
    const double level = kEdgeLevelSdShare * std::abs(edge.fit[4]) + 1;
    const TagFitOptions lens = with_usual_priors({}, size);
    sd_ << 0, 0, kEdgeBendShare * lens.bend_sd_per_px / 2 * edge.half * edge.half, level, level,
        kEdgeLogBlurSd, kEdgeBendShare * lens.twist_sd_per_px2 * std::pow(edge.half, 3) / 6;
  }

  double squares(const Edge& edge) const {
    double sum = 0;
    for (const int i : kWithPrior) sum += std::pow((edge.fit[i] - centre_[i]) / sd_[i], 2);
    return sum;
  }

  // Weighted against the variance of the pixels.
  void add(const Edge& edge, double variance, NormalEquations& sums) const {
    for (const int i : kWithPrior) {
      const double weight = variance / (sd_[i] * sd_[i]);
      sums.information(i, i) += weight;
      sums.gradient[i] -= weight * (edge.fit[i] - centre_[i]);
    }
  }

 private:
  static constexpr std::array kWithPrior = {2, 3, 4, 5, 6};
  Vector7 centre_;
  Vector7 sd_;
};

// Gauss-Newton; a step that raises the cost is shortened. False if the edge leaves its bounds.
bool fit_to(const std::vector<Sample>& samples, const EdgePrior& prior, Edge& edge) {
  Edge best = edge;
  Vector7 change = Vector7::Zero();
  double squares = 0, variance = 0;
  for (int i = 0; i < kSteps; ++i) {
    NormalEquations sums = equations_of(edge, samples);
    const bool worse = i > 0 && sums.squares + variance * prior.squares(edge) >
                                    squares + variance * prior.squares(best);
    if (worse) {
      change *= kShorter;
    } else {
      best = edge;
      squares = sums.squares;
      variance = std::max(kRounding, squares / static_cast<double>(samples.size() - 7));
      prior.add(edge, variance, sums);
      change = sums.information.ldlt().solve(sums.gradient);
      if (!change.allFinite()) return false;
      for (const int k : {0, 1, 5}) change[k] = std::clamp(change[k], -kMaxStep, kMaxStep);
    }
    edge = best;
    edge.fit += change;
    edge.fit[5] = std::max(edge.fit[5], std::log(kTagMinSpreadPx));
    if (!(std::abs(edge.fit[0]) < kTagMaxMovePx && edge.fit[5] < std::log(kTagMaxSpreadPx)))
      return false;
    const double moved = std::abs(change[0]) + std::abs(change[1]) + std::abs(change[2]);
    if (moved < kSettledPx && std::abs(change[5]) < kSettledLogBlur) break;
  }
  return true;
}

bool fit_edge(Edge& edge, const ImageView8& image, double cell, bool dark_inside) {
  for (int selection = 0; selection < kSelections; ++selection) {
    // Three rows of pixels or more, as far as the neighbouring cells allow.
    edge.reach = std::max(3 * kHalfPixel, std::min(cell / 2, edge.felt()));
    const std::vector<Sample> samples = samples_about(edge, image);
    if (samples.size() < kFewestSamples) return false;
    if (!start_levels(edge, samples)) return false;
    const Vector7 before = edge.fit;
    if (!fit_to(samples, EdgePrior(edge, image.size()), edge)) return false;
    const Vector7 change = (edge.fit - before).cwiseAbs();
    if (selection > 0 && change[0] + change[1] + change[2] < kSameStripPx) break;
  }
  return (dark_inside ? edge.fit[4] : -edge.fit[4]) >= kMinContrast;
}

// Intersection of two edges: that of their tangents near the corner, repeated.
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

// px of a cell: the distance from edge i to the opposite one over the number of cells between.
double cell_at(const Quad& quad, const Edge& edge, std::size_t i, int cells) {
  const Eigen::Vector2d opposite = (quad[(i + 2) % 4] + quad[(i + 3) % 4]) / 2;
  return std::abs((opposite - edge.middle).dot(edge.normal)) / cells;
}

}  // namespace

std::optional<Quad> refine_edges(const ImageView8& image, const Quad& start,
                                 const QuadShape& shape) {
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
    if (!(moved <= kTagMaxMovePx)) return std::nullopt;  // also if not a number
  }
  return quad;
}

}  // namespace tagcal::internal
