#include "tagcal/detect/checker_search/junction_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "tagcal/detect/board_search/point_bins.hpp"
#include "tagcal/detect/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// px. Distances in which the next junction is looked for, as limits of work: halved pictures have
// larger squares.
constexpr double kFirstReachPx = 16;
constexpr double kLastReachPx = 300;

const double kLeastCos = std::cos(policy::kMaxTurn), kMaxTangent = std::tan(policy::kMaxTurn);

// Angle between two lines.
double between(double a, double b) { return std::abs(std::remainder(a - b, std::numbers::pi)); }

Vector2d along(double angle) { return {std::cos(angle), std::sin(angle)}; }

GridCell operator+(const GridCell& a, const GridCell& b) {
  return {a.first + b.first, a.second + b.second};
}
GridCell operator-(const GridCell& a) { return {-a.first, -a.second}; }

constexpr GridCell kSteps[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

std::vector<Vector2d> places_of(const std::vector<Junction>& junctions) {
  std::vector<Vector2d> places;
  for (const Junction& junction : junctions) places.push_back(junction.at);
  return places;
}

class Grower {
 public:
  Grower(const std::vector<Junction>& junctions, bool follows_lines)
      : junctions_(junctions),
        follows_lines_(follows_lines),
        bins_(places_of(junctions)),
        is_taken_(junctions.size(), false),
        is_in_grid_(junctions.size(), false) {}

  std::optional<JunctionGrid> grown_from(std::size_t seed) {
    if (follows_lines_)
      for (const auto& [cell, i] : cells_) is_taken_[i] = false;
    cells_.clear();
    newest_.clear();
    if (is_in_grid_[seed] || !start(seed)) return std::nullopt;
    while (grow()) {
    }
    JunctionGrid grid;
    for (const auto& [cell, i] : cells_) {
      grid[cell] = junctions_[i].at;
      is_in_grid_[i] = true;
    }
    return grid;
  }

 private:
  static bool has_like_contrast(const Junction& one, const Junction& other) {
    return 2 * std::min(one.contrast, other.contrast) > std::max(one.contrast, other.contrast);
  }

  // True if the lines of `other` are those of `one` with the colours exchanged.
  bool is_opposite(const Junction& one, const Junction& other) const {
    return has_like_contrast(one, other) && between(one.first, other.second) < policy::kMaxTurn &&
           between(one.second, other.first) < policy::kMaxTurn;
  }
  void add(const GridCell& cell, std::size_t i) {
    cells_[cell] = i;
    newest_.push_back(cell);
    is_taken_[i] = true;
  }

  // The nearest junction along one of the lines, that of this direction. Its own line, of exchanged
  // colours, continues it as an arc does: the chord has the mean of the directions at its ends.
  std::optional<std::size_t> next(std::size_t from, const Vector2d& direction) const {
    const Junction& one = junctions_[from];
    const Vector2d first = along(one.first), second = along(one.second);
    const bool is_first = std::abs(direction.dot(first)) > std::abs(direction.dot(second));
    const Vector2d line = is_first ? first : second;
    const Vector2d forward = direction.dot(line) < 0 ? Vector2d(-line) : line;
    const Vector2d aside = kMaxTangent * Vector2d(-forward.y(), forward.x());
    for (double radius = kFirstReachPx; radius < kLastReachPx; radius *= 2) {
      std::optional<std::size_t> best;
      double least = radius * radius;
      Eigen::AlignedBox2d box(one.at);  // about the sector of the directions that are allowed
      box.extend(one.at + radius * (forward + aside)).extend(one.at + radius * (forward - aside));
      bins_.in_box(box, [&](std::size_t i) {
        const Junction& other = junctions_[i];
        const Vector2d chord = other.at - one.at;
        const double distance = chord.squaredNorm(), ahead = chord.dot(forward);
        if (distance >= least || ahead <= 0 || ahead * ahead < kLeastCos * kLeastCos * distance ||
            !has_like_contrast(one, other))
          return;
        const double angle =
            2 * std::atan2(chord.y(), chord.x()) - (is_first ? one.first : one.second);
        if (between(angle, is_first ? other.second : other.first) > policy::kMaxTurn) return;
        least = distance;
        best = i;
      });
      if (best) return is_taken_[*best] ? std::nullopt : best;
    }
    return std::nullopt;
  }
  Vector2d chord(std::size_t from, std::size_t to) const {
    return junctions_[to].at - junctions_[from].at;
  }

  bool start(std::size_t seed) {
    const Junction& one = junctions_[seed];
    for (const double sign : {1.0, -1.0}) {
      const auto right = next(seed, sign * along(one.first));
      if (!right) continue;
      const auto below = next(seed, sign * along(one.second));
      if (!below || *right == *below) continue;
      const auto last = next(*right, chord(seed, *below));
      if (!last || last != next(*below, chord(seed, *right))) continue;
      add({0, 0}, seed);
      add({1, 0}, *right);
      add({0, 1}, *below);
      add({1, 1}, *last);
      return true;
    }
    return false;
  }

  // The junction that the line of the one before a cell leads to; no value if that has no neighbour
  // before it.
  std::optional<std::size_t> next_to(const GridCell& cell, const GridCell& step) const {
    const auto one = cells_.find(cell + -step), two = cells_.find(cell + -step + -step);
    if (one == cells_.end() || two == cells_.end()) return std::nullopt;
    return next(one->second, chord(two->second, one->second));
  }

  // True if the lines of the neighbours lead to nearer junctions: steps that shrink fast predict
  // the third one.
  bool is_beyond_next(const GridCell& cell, std::size_t found) const {
    return std::ranges::any_of(kSteps, [&](const GridCell& step) {
      const auto next = next_to(cell, step);
      if (!next || *next == found) return false;
      const std::size_t from = cells_.at(cell + -step);
      return chord(from, *next).norm() < chord(from, found).norm();
    });
  }

  // The junction of a cell where steps change too much to be predicted: lines of two neighbours
  // lead to it, or that of one does, and a line joins it to the cell beside it.
  std::optional<std::size_t> where_lines_meet(const GridCell& cell) const {
    for (const GridCell& step : kSteps) {
      const auto one = next_to(cell, step);
      if (!one) continue;
      for (const GridCell& side : kSteps) {
        if (side == step || side == -step) continue;
        if (next_to(cell, side) == one) return one;
        const auto beside = next_to(cell + side, step);
        if (beside && *beside != *one && next(*one, chord(*one, *beside)) == beside) return one;
      }
    }
    return std::nullopt;
  }

  template <typename Test>
  std::optional<std::size_t> nearest(const Vector2d& at, double reach, const Test& test) const {
    std::optional<std::size_t> best;
    double least = reach;
    const Vector2d around = Vector2d::Constant(reach);
    bins_.in_box({at - around, at + around}, [&](std::size_t i) {
      const double distance = (junctions_[i].at - at).norm();
      if (distance > least || is_taken_[i] || !test(junctions_[i])) return;
      least = distance;
      best = i;
    });
    return best;
  }

  std::optional<Vector2d> place(const GridCell& cell) const {
    const auto it = cells_.find(cell);
    if (it == cells_.end()) return std::nullopt;
    return junctions_[it->second].at;
  }

  struct Prediction {
    Vector2d at = Vector2d::Zero();
    double step = 0;  // least distance to the next one
    int count = 0;
  };

  // The mean of linear continuations of the lines, and of parallelograms.
  Prediction predict(const GridCell& cell) const {
    Prediction lines, parallels;
    const auto add = [](Prediction& to, const Vector2d& at, double step) {
      to.at += at;
      to.step = to.count == 0 ? step : std::min(to.step, step);
      ++to.count;
    };
    for (const GridCell& step : kSteps) {
      const auto one = place(cell + -step);
      if (!one) continue;
      if (const auto two = place(cell + -step + -step))
        add(lines, 2 * *one - *two, (*one - *two).norm());
      for (const GridCell& side : kSteps) {
        if (side == step || side == -step) continue;
        const auto beside = place(cell + side), before = place(cell + -step + side);
        if (beside && before)
          add(parallels, *one + *beside - *before,
              std::min((*beside - *before).norm(), (*one - *before).norm()));
      }
    }
    Prediction& best = lines.count > 0 ? lines : parallels;
    if (best.count > 0) best.at /= best.count;
    return best;
  }

  // The free cells beside the grid whose prediction the newest cells may have changed: those within
  // two steps. The other cells had no junction in the last round, and since then fewer are free.
  std::vector<GridCell> border() const {
    std::vector<GridCell> cells;
    for (const GridCell& cell : newest_)
      for (const GridCell& step : kSteps) {
        cells.push_back(cell + step);
        for (const GridCell& second : kSteps) cells.push_back(cell + step + second);
      }
    std::ranges::sort(cells);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    std::erase_if(cells, [this](const GridCell& cell) {
      return cells_.contains(cell) || std::ranges::none_of(kSteps, [&](const GridCell& step) {
               return cells_.contains(cell + step);
             });
    });
    return cells;
  }

  bool grow() {
    const std::vector<GridCell> cells = border();
    newest_.clear();
    for (const GridCell& cell : cells) {
      const Prediction expected = predict(cell);
      if (expected.count == 0) continue;
      const Junction& like = junctions_[neighbour(cell)];
      auto found = nearest(expected.at, policy::kMaxMoveShare * expected.step,
                           [&](const Junction& other) { return is_opposite(like, other); });
      if (follows_lines_ && (!found || is_beyond_next(cell, *found)))
        found = where_lines_meet(cell);
      if (!found) continue;
      add(cell, *found);
    }
    return !newest_.empty();
  }

  std::size_t neighbour(const GridCell& cell) const {
    for (const GridCell& step : kSteps)
      if (const auto it = cells_.find(cell + step); it != cells_.end()) return it->second;
    return cells_.begin()->second;
  }

  const std::vector<Junction>& junctions_;
  const bool follows_lines_;
  PointBins bins_;
  std::vector<bool> is_taken_;    // by the grid that grows; if lines are not followed, by any
  std::vector<bool> is_in_grid_;  // that has grown
  std::map<GridCell, std::size_t> cells_;
  std::vector<GridCell> newest_;  // what the last round has found
};

}  // namespace

std::vector<JunctionGrid> junction_grids(const std::vector<Junction>& junctions,
                                         bool follows_lines) {
  Grower grower(junctions, follows_lines);
  std::vector<JunctionGrid> grids;
  for (std::size_t i = 0; i < junctions.size(); ++i)
    if (auto grid = grower.grown_from(i)) grids.push_back(std::move(*grid));
  return grids;
}

}  // namespace tagcal::internal
