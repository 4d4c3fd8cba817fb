#include "tagcal/reproject/rows/footprints.hpp"

#include <algorithm>
#include <cmath>

#include "tagcal/reproject/policy/policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Half-lengths of the ellipse J (unit circle), and the direction of the longer one.
struct Axes {
  double longer = 0;
  double shorter = 0;
  Vector2d direction = Vector2d::UnitX();
};

Axes axes_of(const Matrix2d& jacobian) {
  const Matrix2d square = jacobian * jacobian.transpose();
  const double mean = square.trace() / 2, difference = (square(0, 0) - square(1, 1)) / 2;
  const double radius = std::sqrt(difference * difference + square(0, 1) * square(0, 1));
  Axes axes{std::sqrt(mean + radius), std::sqrt(std::max(0.0, mean - radius)), Vector2d::UnitX()};
  // The eigenvector (b, l - a) of [a b; b c], by the larger of the two differences.
  const Vector2d longer = difference >= 0 ? Vector2d(difference + radius, square(0, 1))
                                          : Vector2d(square(0, 1), radius - difference);
  if (longer.squaredNorm() > 0) axes.direction = longer.normalized();
  return axes;
}

// The width of the kernel for so many source pixels per target pixel.
double kernel_width(double scale) {
  using namespace policy;
  if (scale <= kPlainScale) return 1;
  if (scale >= kFullScale) return scale;
  return 1 + (scale - kPlainScale) / (kFullScale - kPlainScale) * (kFullScale - 1);
}

Footprint footprint_of(const Matrix2d& jacobian, double largest) {
  const Axes axes = axes_of(jacobian);
  const double length = std::min(kernel_width(axes.longer), largest);
  Footprint footprint;
  footprint.width = std::min(policy::kRoundRatio * kernel_width(axes.shorter), length);
  // The variance of a tent of half-length h is h^2 / 6: those of the kernel and of the line add up
  // to that of a kernel as wide as the longer axis.
  const double rest = length * length - footprint.width * footprint.width;
  if (rest > 0) footprint.along = std::sqrt(rest) * axes.direction;
  return footprint;
}

}  // namespace

Footprints::Node Footprints::node_at(const MapRows& rows, double u, double v) const {
  const auto left = rows.at({u - 0.5, v}), right = rows.at({u + 0.5, v});
  const auto above = rows.at({u, v - 0.5}), below = rows.at({u, v + 0.5});
  Node node;
  node.valid = left && right && above && below;
  if (!node.valid) return node;
  node.jacobian << *right - *left, *below - *above;
  node.footprint = footprint_of(node.jacobian, largest_);
  return node;
}

Footprints::Footprints(const MapRows& rows, int block_row, double largest)
    : first_row_(block_row * policy::kBlock), largest_(largest) {
  const int blocks = (rows.size.width + policy::kBlock - 1) / policy::kBlock;
  for (int i = 0; i <= blocks; ++i) {
    const double u = i * policy::kBlock;
    upper_.push_back(node_at(rows, u, first_row_));
    lower_.push_back(node_at(rows, u, first_row_ + policy::kBlock));
  }
  const auto is_plain = [](const Node& n) {
    return !n.valid || axes_of(n.jacobian).longer <= policy::kPlainScale;
  };
  const auto is_round = [](const Node& n) { return n.valid && n.footprint.along.isZero(0); };
  for (std::size_t i = 0; i + 1 < upper_.size(); ++i) {
    const auto all = [&](const auto& is) {
      return is(upper_[i]) && is(upper_[i + 1]) && is(lower_[i]) && is(lower_[i + 1]);
    };
    plain_.push_back(all(is_plain));
    round_.push_back(all(is_round));
  }
}

Footprint Footprints::at(int u, int v) const {
  const std::size_t block = static_cast<std::size_t>(u / policy::kBlock);
  const double fu = static_cast<double>(u % policy::kBlock) / policy::kBlock;
  const double fv = static_cast<double>(v - first_row_) / policy::kBlock;
  Matrix2d sum = Matrix2d::Zero();
  double weights = 0;
  const auto add = [&](const Node& node, double weight) {
    if (!node.valid) return;
    sum += weight * node.jacobian;
    weights += weight;
  };
  add(upper_[block], (1 - fu) * (1 - fv));
  add(upper_[block + 1], fu * (1 - fv));
  add(lower_[block], (1 - fu) * fv);
  add(lower_[block + 1], fu * fv);
  if (weights <= 0) return {};
  return footprint_of(sum / weights, largest_);
}

double Footprints::round_width(int u, int v) const {
  const std::size_t block = static_cast<std::size_t>(u / policy::kBlock);
  const double fu = static_cast<double>(u % policy::kBlock) / policy::kBlock;
  const double fv = static_cast<double>(v - first_row_) / policy::kBlock;
  const auto row = [&](const std::vector<Node>& nodes) {
    return (1 - fu) * nodes[block].footprint.width + fu * nodes[block + 1].footprint.width;
  };
  return (1 - fv) * row(upper_) + fv * row(lower_);
}

}  // namespace tagcal::internal
