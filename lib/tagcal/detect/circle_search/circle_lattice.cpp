#include "tagcal/detect/circle_search/circle_lattice.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "tagcal/detect/board_search/point_bins.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/geometry/pose.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Cell = std::pair<int, int>;
using Eigen::Matrix2i;
using Eigen::Vector2d;
using Eigen::Vector2i;

Cell operator+(const Cell& a, const Cell& b) { return {a.first + b.first, a.second + b.second}; }
Cell operator-(const Cell& a) { return {-a.first, -a.second}; }

constexpr Cell kSteps[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
constexpr double kFirstReachPx = 32;      // numeric: within which neighbours are looked for first
constexpr std::size_t kMostDiscs = 1000;  // of a grid of unknown size, as a limit of work
constexpr double kIndependent = 0.3;  // numeric: sine of the angle between two vectors of a basis

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Blobs that form a lattice in the picture, by the coefficients of two of its shortest vectors.
using CircleLattice = std::map<Cell, Vector2d>;

// The lattice that grows from a blob and its nearest neighbours: each further blob lies where its
// neighbours in the lattice predict it, and is about as large as they are, which letters beside the
// discs are not. One of more than `most` blobs is not completed.
class Growth {
 public:
  Growth(const std::vector<CircleBlob>& blobs, const PointBins& bins, std::size_t seed,
         std::size_t most)
      : blobs_(blobs), bins_(bins), most_(most), is_used_(blobs.size(), false) {
    add({0, 0}, seed);
    has_basis_ = find_basis(seed);
    if (has_basis_) grow();
  }

  // Empty if the blob has no two independent neighbours.
  CircleLattice lattice() const {
    if (!has_basis_) return {};
    CircleLattice result;
    for (const auto& [cell, blob] : cells_) result[cell] = blobs_[blob].at;
    return result;
  }
  void mark_used(std::vector<bool>& blobs) const {
    for (const auto& [cell, blob] : cells_) blobs[blob] = true;
  }

 private:
  void add(const Cell& cell, std::size_t blob) {
    cells_[cell] = blob;
    is_used_[blob] = true;
    edge_.push_back(cell);
  }

  bool is_alike(std::size_t a, std::size_t b) const {
    const auto [small, large] = std::minmax(blobs_[a].diameter_px, blobs_[b].diameter_px);
    return large <= policy::kBlobMostRatio * small;
  }

  // The shortest vector to another blob, and the shortest one that is independent of it.
  bool find_basis(std::size_t seed) {
    const Vector2d& from = blobs_[seed].at;
    for (double reach = kFirstReachPx;; reach *= 2) {
      std::vector<Vector2d> around;
      std::size_t num_within = 0;
      const Vector2d half = Vector2d::Constant(reach);
      bins_.in_box({from - half, from + half}, [&](std::size_t i) {
        const Vector2d v = blobs_[i].at - from;
        if (v.norm() > reach) return;
        ++num_within;
        if (i != seed && is_alike(i, seed)) around.push_back(v);
      });
      std::ranges::sort(around, {}, [](const Vector2d& v) { return v.squaredNorm(); });
      const auto second = std::ranges::find_if(around, [&](const Vector2d& v) {
        return std::abs(cross(around[0], v)) > kIndependent * around[0].norm() * v.norm();
      });
      if (second != around.end()) {
        first_ = around[0];
        second_ = *second;
        return true;
      }
      if (num_within == blobs_.size()) return false;
    }
  }

  std::optional<Vector2d> at(const Cell& cell) const {
    const auto found = cells_.find(cell);
    if (found == cells_.end()) return std::nullopt;
    return blobs_[found->second].at;
  }

  // The step from a cell to its next one: as the step before it, or as that of a cell beside it.
  Vector2d step_from(const Cell& cell, const Cell& step) const {
    const Vector2d here = *at(cell);
    if (const auto before = at(cell + -step)) return here - *before;
    const Cell beside{step.second, step.first};
    for (const Cell& side : {beside, -beside}) {
      const auto from = at(cell + side), to = at(cell + side + step);
      if (from && to) return *to - *from;
    }
    return step.first * first_ + step.second * second_;
  }

  void grow() {
    // The edge grows on the way.
    for (std::size_t i = 0; i < edge_.size() && cells_.size() <= most_; ++i) {
      const Cell cell = edge_[i];
      for (const Cell& step : kSteps) {
        if (cells_.contains(cell + step)) continue;
        const Vector2d length = step_from(cell, step);
        const Vector2d expected = *at(cell) + length;
        std::size_t nearest = blobs_.size();
        double least = policy::kMaxMoveShare * length.norm();
        const Vector2d around = Vector2d::Constant(least);
        bins_.in_box({expected - around, expected + around}, [&](std::size_t k) {
          const double distance = (blobs_[k].at - expected).norm();
          if (distance >= least || is_used_[k] || !is_alike(k, cells_.at(cell))) return;
          least = distance;
          nearest = k;
        });
        if (nearest < blobs_.size()) add(cell + step, nearest);
      }
    }
  }

  const std::vector<CircleBlob>& blobs_;
  const PointBins& bins_;
  const std::size_t most_;
  std::vector<bool> is_used_;
  bool has_basis_ = false;
  Vector2d first_, second_;  // the basis
  std::map<Cell, std::size_t> cells_;
  std::vector<Cell> edge_;  // cells in the order in which they were found
};

// The bases of a lattice whose coefficients are small: a basis of short vectors is among them.
std::vector<Matrix2i> small_bases() {
  constexpr int kLargest = 2;
  std::vector<Matrix2i> result;
  Matrix2i m;
  for (m(0, 0) = -kLargest; m(0, 0) <= kLargest; ++m(0, 0))
    for (m(0, 1) = -kLargest; m(0, 1) <= kLargest; ++m(0, 1))
      for (m(1, 0) = -kLargest; m(1, 0) <= kLargest; ++m(1, 0))
        for (m(1, 1) = -kLargest; m(1, 1) <= kLargest; ++m(1, 1))
          if (std::abs(m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0)) == 1) result.push_back(m);
  return result;
}

// The discs of a grid in units of its spacing, x to the right and y down, both from 0.
std::map<Cell, int> discs_from_above(const CircleGrid& grid) {
  std::map<Cell, int> ids;
  for (const TargetPoint& point : target_points({grid, {}})) {
    const Vector2d place = point.position.head<2>() / grid.spacing;
    ids[{static_cast<int>(std::lround(place.x())),
         grid.rows - 1 - static_cast<int>(std::lround(place.y()))}] = point.id.tag_id;
  }
  return ids;
}

// The lattice's blobs as discs of the grid, under a basis and moved to 0; empty if one is no disc.
CirclePlaces places_under(const Matrix2i& basis, const CircleGrid& grid,
                          const std::map<Cell, int>& discs, const CircleLattice& lattice) {
  Matrix2i to_grid = basis;
  if (grid.asymmetric) to_grid = (Matrix2i() << 1, 1, 1, -1).finished() * basis;
  Vector2i low = Vector2i::Constant(std::numeric_limits<int>::max());
  std::vector<std::pair<Vector2i, Vector2d>> moved;
  for (const auto& [cell, at] : lattice) {
    moved.emplace_back(to_grid * Vector2i(cell.first, cell.second), at);
    low = low.cwiseMin(moved.back().first);
  }
  CirclePlaces places;
  for (const auto& [cell, at] : moved) {
    const auto disc = discs.find({cell.x() - low.x(), cell.y() - low.y()});
    if (disc == discs.end()) return {};
    places[disc->second] = at;
  }
  return places;
}

bool is_seen_enough(const CirclePlaces& places, const CircleGrid& grid) {
  const auto share = [&](auto is_in, int of) {
    return static_cast<double>(std::ranges::count_if(places, [&](const auto& place) {
             return is_in(place.first - grid.first_id);
           })) >= policy::kMinLineShare * of;
  };
  return 2 * static_cast<int>(places.size()) > grid.columns * grid.rows &&
         share([&](int i) { return i % grid.columns == 0; }, grid.rows) &&
         share([&](int i) { return i % grid.columns == grid.columns - 1; }, grid.rows) &&
         share([&](int i) { return i / grid.columns == 0; }, grid.columns) &&
         share([&](int i) { return i / grid.columns == grid.rows - 1; }, grid.columns);
}

// The positions of these discs on the board, in its spacings, in the order of their places.
std::vector<Vector2d> on_board(const CirclePlaces& places, const CircleGrid& grid) {
  std::map<int, Vector2d> all;
  for (const TargetPoint& point : target_points({grid, {}}))
    all[point.id.tag_id] = point.position.head<2>() / grid.spacing;
  std::vector<Vector2d> result;
  for (const auto& [id, at] : places) result.push_back(all.at(id));
  return result;
}

// The affine map from the board to the picture: columns of the board's x and y.
Eigen::Matrix2d axes_in_picture(const CirclePlaces& places, const CircleGrid& grid) {
  const std::vector<Vector2d> points = on_board(places, grid);
  const auto n = static_cast<Eigen::Index>(places.size());
  MatrixX a(n, 3), b(n, 2);
  Eigen::Index i = 0;
  for (const auto& [id, at] : places) {
    a.row(i) = points[static_cast<std::size_t>(i)].homogeneous();
    b.row(i++) = at;
  }
  const MatrixX map = (a.transpose() * a).inverse() * (a.transpose() * b);
  return map.topRows<2>().transpose();
}

// How far the discs are from a perspective image of the grid, in its spacings: the standard
// deviation of a coordinate. Infinite if they are too few to tell.
double strain_of(const CirclePlaces& places, const CircleGrid& grid) {
  constexpr int kParameters = 8;  // of a homography
  constexpr int kFewestOver = 6;  // coordinates beyond them: fewer may agree with any homography
  const int over = 2 * static_cast<int>(places.size()) - kParameters;
  if (over < kFewestOver) return std::numeric_limits<double>::infinity();
  // Pixels are seen as by a camera of a narrow view: homography() takes them for rays.
  const Vector2d origin = places.begin()->second;
  double size = 0;
  for (const auto& [id, at] : places) size = std::max(size, (at - origin).norm());
  std::vector<Eigen::Vector3d> rays;
  for (const auto& [id, at] : places) rays.emplace_back(((at - origin) / size).homogeneous());
  const std::vector<Vector2d> points = on_board(places, grid);
  const auto rays_from_board = homography(points, rays);
  if (!rays_from_board) return std::numeric_limits<double>::infinity();
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d expected = (*rays_from_board * points[i].homogeneous()).hnormalized();
    squares += (expected - rays[i].head<2>()).squaredNorm();
  }
  return size * std::sqrt(squares / over / std::abs(axes_in_picture(places, grid).determinant()));
}

// The grid's discs in a lattice. Of several ways, the one whose y axis points up most in the
// picture. Empty if the lattice is not this grid.
CirclePlaces places_in_lattice(const CircleGrid& grid, const CircleLattice& lattice) {
  if (2 * lattice.size() <= static_cast<std::size_t>(grid.columns * grid.rows)) return {};
  const std::map<Cell, int> discs = discs_from_above(grid);
  if (lattice.size() > discs.size()) return {};
  CirclePlaces best;
  double highest = -std::numeric_limits<double>::infinity();
  static const std::vector<Matrix2i> kBases = small_bases();
  for (const Matrix2i& basis : kBases) {
    CirclePlaces places = places_under(basis, grid, discs, lattice);
    if (places.empty() || !is_seen_enough(places, grid)) continue;
    const Eigen::Matrix2d axes = axes_in_picture(places, grid);
    // The picture's y points down.
    const double up = -axes.col(1).normalized().y();
    if (axes.determinant() >= 0 || up <= highest) continue;
    highest = up;
    best = std::move(places);
  }
  const bool is_sure =
      best.size() >= policy::kManyDiscs || strain_of(best, grid) < policy::kMaxDiscStrain;
  return is_sure ? best : CirclePlaces();
}

PointBins bins_of(const std::vector<CircleBlob>& blobs) {
  std::vector<Vector2d> centres;
  for (const CircleBlob& blob : blobs) centres.push_back(blob.at);
  return PointBins(centres);
}

}  // namespace

CirclePlaces places_among(const std::vector<CircleBlob>& blobs, const CircleGrid& grid) {
  const PointBins bins = bins_of(blobs);
  const auto num_discs = static_cast<std::size_t>(grid.columns * grid.rows);
  for (std::size_t seed = 0; seed < blobs.size(); ++seed) {
    const Growth growth(blobs, bins, seed, num_discs);
    CirclePlaces places = places_in_lattice(grid, growth.lattice());
    if (!places.empty()) return places;
  }
  return {};
}

std::optional<CircleGrid> whole_grid_among(const std::vector<CircleBlob>& blobs) {
  const PointBins bins = bins_of(blobs);
  CircleLattice lattice;
  std::vector<bool> is_used(blobs.size(), false);
  for (std::size_t seed = 0; seed < blobs.size() && lattice.size() <= kMostDiscs; ++seed) {
    if (is_used[seed]) continue;
    const Growth growth(blobs, bins, seed, kMostDiscs);
    growth.mark_used(is_used);
    if (CircleLattice grown = growth.lattice(); grown.size() > lattice.size())
      lattice = std::move(grown);
  }
  if (lattice.size() > kMostDiscs) return std::nullopt;
  const int num_discs = static_cast<int>(lattice.size());
  for (int columns = num_discs / policy::kGridOfOtherTarget; columns >= policy::kGridOfOtherTarget;
       --columns)
    for (const bool asymmetric : {false, true}) {
      const CircleGrid grid{columns, num_discs / columns, 1, 0, asymmetric};
      if (num_discs % columns == 0 && places_in_lattice(grid, lattice).size() == lattice.size())
        return grid;
    }
  return std::nullopt;
}

}  // namespace tagcal::internal
