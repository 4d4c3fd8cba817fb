#include "tagcal/scene/visibility/sheet_groups.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

namespace tagcal::internal {
namespace {

using Eigen::Vector3d;
using Polygon = Shadows::Polygon;

constexpr double kSamePlace = 1e-9;  // share of an edge's length

// Returns true if a part of an edge is also one of the other polygon.
bool share_edge(const Polygon& first, const Polygon& second) {
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Vector3d edge = first[(i + 1) % first.size()] - first[i];
    const double length = edge.norm(), tolerance_m = kSamePlace * length;
    const auto along = [&](const Vector3d& x) { return edge.dot(x - first[i]) / length; };
    const auto is_off = [&](const Vector3d& x) {
      return edge.cross(x - first[i]).norm() > tolerance_m * length;
    };
    for (std::size_t k = 0; k < second.size(); ++k) {
      const Vector3d &c = second[k], &d = second[(k + 1) % second.size()];
      if (is_off(c) || is_off(d)) continue;
      const auto [from, to] = std::minmax({along(c), along(d)});
      if (std::min(to, length) - std::max(from, 0.0) > tolerance_m) return true;
    }
  }
  return false;
}

class Groups {
 public:
  explicit Groups(const Shadows& shadows)
      : shadows_(shadows), places_(shadows.sheets().size()), lows_(places_.size()) {}

  std::vector<SheetGroup> from_near() {
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (places_[i] == 0) visit(i);
    return std::move(groups_);
  }

 private:
  static constexpr std::size_t kDone = std::numeric_limits<std::size_t>::max();

  bool hides(std::size_t other, std::size_t sheet) const {
    if (other == sheet || shadows_.shadow(other, sheet).empty()) return false;
    const Polygon& corners = shadows_.sheets()[sheet].corners;
    const auto parts = shadows_.visible_parts(corners, sheet, std::span(&other, 1));
    return parts.size() != 1 || parts[0] != corners;
  }

  bool touches(std::size_t other, std::size_t sheet) const {
    return share_edge(shadows_.sheets()[sheet].corners, shadows_.sheets()[other].corners);
  }

  void visit(std::size_t sheet) {
    places_[sheet] = lows_[sheet] = ++num_visited_;
    path_.push_back(sheet);
    for (std::size_t other = 0; other < places_.size(); ++other) {
      if (places_[other] == kDone) continue;
      if (!hides(other, sheet) && !touches(other, sheet)) continue;
      if (places_[other] == 0) {
        visit(other);
        lows_[sheet] = std::min(lows_[sheet], lows_[other]);
      } else {
        lows_[sheet] = std::min(lows_[sheet], places_[other]);
      }
    }
    if (lows_[sheet] != places_[sheet]) return;
    const auto first = std::ranges::find(path_, sheet);
    groups_.emplace_back(first, path_.end());
    path_.erase(first, path_.end());
    for (const std::size_t member : groups_.back()) places_[member] = kDone;
  }

  const Shadows& shadows_;
  std::vector<std::size_t> places_;  // in the order of the visits, from 1
  std::vector<std::size_t> lows_;
  std::vector<std::size_t> path_;
  std::size_t num_visited_ = 0;
  std::vector<SheetGroup> groups_;
};

}  // namespace

std::vector<SheetGroup> groups_from_near(const Shadows& shadows) {
  return Groups(shadows).from_near();
}

}  // namespace tagcal::internal
