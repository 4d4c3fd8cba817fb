#include "tagcal/detect/circle_search/circle_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/solvers/numeric/minimise.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kReach = 1.0 / 2;  // distances of centres: the middle of the white between discs
constexpr int kMaxSteps = 20;       // a limit of work
constexpr double kQuantisation = 1.0 / 12;  // variance of rounding to whole levels

struct Pixel {
  Vector2d at;
  double level;
};

// Parameters: shift (2 px), logarithms of radius and spread, level of the ink, of the paper less
// that of the ink, and the latter's change over the reach in x and y of the picture.
constexpr int kCount = 8;
using Step = Eigen::Matrix<double, kCount, 1>;
using System = Eigen::Matrix<double, kCount, kCount>;
enum Parameter { kLogRadius = 2, kLogSpread, kInk, kContrast };

double normal_share(double z) { return std::erfc(-z / std::numbers::sqrt2) / 2; }
double normal_density(double z) { return std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi); }

// A pixel's signed distance from the border of the disc, outside positive, and its derivatives.
struct Border {
  double distance = 0;
  Vector2d outwards = Vector2d::Zero();  // unit normal
  double per_radius = 0;                 // px of the border's motion
  double curvature = 0;                  // 1/px
  double across = 0;                     // px through the disc to its other border
};

// By the foot of the perpendicular on the border, from the direction of the pixel.
Border border_at(const LocalMap& map, const Matrix2d& place_by_pixel, const Vector2d& pixel,
                 double radius) {
  constexpr int kFootSteps = 2;      // numeric: Newton's, of the foot's angle
  constexpr double kMostTurn = 0.5;  // numeric: radians a step
  Vector2d outwards = place_by_pixel * (pixel - map.centre);
  if (outwards.isZero()) outwards = Vector2d::UnitX();  // at the centre all are as good
  outwards.normalize();
  Border border;
  for (int i = 0;; ++i) {
    const Vector2d across(-outwards.y(), outwards.x());
    const Vector2d place = radius * outwards;
    const Matrix2d derivative = map.derivative(place);
    const Vector2d along = radius * (derivative * across);  // by the angle
    const Vector2d bend =
        2 * radius * radius * map.of_second_order(across) - radius * (derivative * outwards);
    const double length = along.norm();
    const Vector2d tangent = along / length;
    border.outwards = Vector2d(tangent.y(), -tangent.x());
    if (border.outwards.dot(derivative * outwards) < 0) border.outwards = -border.outwards;
    border.per_radius = border.outwards.dot(derivative * outwards);
    border.curvature = -border.outwards.dot(bend) / (length * length);
    const Vector2d off = pixel - map.pixel(place);
    border.distance = border.outwards.dot(off);
    if (i == kFootSteps) {
      const Vector2d inwards = derivative.inverse() * border.outwards;  // per px, reversed
      border.across = 2 * radius * outwards.dot(inwards) / inwards.squaredNorm();
      return border;
    }
    constexpr double kLeastTurn = 0.5;  // numeric: no division by zero at a centre of curvature
    const double circle = std::max(kLeastTurn, 1 + border.curvature * border.distance);
    const double turn = tangent.dot(off) / (length * circle);
    outwards = (outwards + std::clamp(turn, -kMostTurn, kMostTurn) * across).normalized();
  }
}

struct CircleEquations {
  double cost = 0;  // sum of squared residuals
  System information = System::Zero();
  Step right = Step::Zero();

  // By Marquardt's damping, a share of the diagonal.
  std::optional<DampedStep<Step>> step(double damping) const {
    System damped = information;
    damped.diagonal() *= 1 + damping;
    const Step step = damped.ldlt().solve(right);
    if (!step.allFinite()) return std::nullopt;
    return DampedStep<Step>{step, step.dot(2 * right - information * step)};
  }
};

// The grey levels of a disc, for `minimise`.
class CircleModel {
 public:
  using State = Step;

  CircleModel(const LocalMap& map, std::vector<Pixel> pixels)
      : map_(map),
        place_by_pixel_(map.first.inverse()),
        least_px_per_unit_(1 / place_by_pixel_.norm()),
        pixels_(std::move(pixels)) {
    for (const Pixel& pixel : pixels_) side_ = std::max(side_, (pixel.at - map.centre).norm());
  }

  std::size_t num_pixels() const { return pixels_.size(); }

  // The share of paper in a pixel, beyond the next border and beyond the other one, and its
  // derivatives by shift, log radius and log spread. Along a border the blur takes the mean over
  // a parabola, by Gauss and Hermite's rule of three nodes.
  struct Share {
    double paper = 0;
    Eigen::Vector4d by = Eigen::Vector4d::Zero();
  };
  Share share(const Step& p, const Pixel& pixel) const {
    const double radius = std::exp(p[kLogRadius]), spread = std::exp(p[kLogSpread]);
    constexpr double kFar = 6;  // numeric: spreads, beyond which a share is 0 or 1 within 1e-9
    const Vector2d place = place_by_pixel_ * (pixel.at - map_.centre - p.head<2>());
    const double rough_px = (place.norm() - radius) * least_px_per_unit_;
    if (std::abs(rough_px) > kFar * spread) return {rough_px > 0 ? 1.0 : 0.0};
    const Border border = border_at(map_, place_by_pixel_, pixel.at - p.head<2>(), radius);
    const double next = border.distance / spread, other = -next - border.across / spread;
    Share result;
    for (const auto& [weight, square] : {std::pair(2.0 / 3, 0.0), std::pair(1.0 / 3, 3.0)}) {
      const double bend = border.curvature * spread * square / 2;
      const double at_next = weight * normal_density(next + bend);
      const double at_other = weight * normal_density(other + bend);
      result.paper += weight * (normal_share(next + bend) + normal_share(other + bend));
      result.by.head<2>() += (at_other - at_next) / spread * border.outwards;
      result.by[2] -= (at_next + at_other) / spread * radius * border.per_radius;
      result.by[3] += at_next * (bend - next) + at_other * (bend - other);
    }
    return result;
  }

  // The normal equations; always in the domain.
  std::optional<CircleEquations> at(const State& p) const {
    CircleEquations result;
    for (const Pixel& pixel : pixels_) {
      const Share s = share(p, pixel);
      const Vector2d off = (pixel.at - map_.centre) / side_;
      const double gain = p[kContrast] + p.tail<2>().dot(off);
      const double residual = pixel.level - p[kInk] - gain * s.paper;
      result.cost += residual * residual;
      Step by;
      by << gain * s.by, 1, s.paper, s.paper * off;
      result.information.selfadjointView<Eigen::Lower>().rankUpdate(by);
      result.right += residual * by;
    }
    result.information = result.information.selfadjointView<Eigen::Lower>();
    return result;
  }

  // Radius and blur remain in their ranges.
  static State stepped(const State& p, const Step& step) {
    State next = p + step;
    next[kLogRadius] = std::min(next[kLogRadius], std::log(kReach));
    next[kLogSpread] = std::clamp(next[kLogSpread], std::log(policy::kTagMinSpreadPx),
                                  std::log(policy::kTagMaxSpreadPx));
    return next;
  }

  // Ink and paper by the darkest and the brightest tenths, the radius by the area of ink.
  Step start() const {
    std::vector<double> levels;
    for (const Pixel& pixel : pixels_) levels.push_back(pixel.level);
    std::ranges::sort(levels);
    const std::size_t tenth = levels.size() / 10;
    const double ink = levels[tenth], paper = levels[levels.size() - 1 - tenth];
    double area = 0;
    for (const double level : levels)
      area += std::clamp((paper - level) / std::max(1.0, paper - ink), 0.0, 1.0);
    const double per_unit = std::abs(map_.first.determinant());  // px^2
    Step p = Step::Zero();
    p[kLogRadius] = std::log(std::sqrt(std::max(1.0, area) / (std::numbers::pi * per_unit)));
    p[kLogSpread] = std::log(policy::kUsualSpreadPx);
    p[kInk] = ink;
    p[kContrast] = paper - ink;
    return p;
  }

 private:
  const LocalMap& map_;
  Matrix2d place_by_pixel_;
  double least_px_per_unit_;
  std::vector<Pixel> pixels_;
  double side_ = 1;  // px, of the pixels' part of the picture
};

constexpr int kSides = 16;  // numeric: of a polygon for a circle
Vector2d side_of_circle(int i) {
  const double angle = 2 * std::numbers::pi * i / kSides;
  return {std::cos(angle), std::sin(angle)};
}

// The pixels of the picture up to `reach` from the centre and 16 px outside of a radius.
std::vector<Pixel> pixels_about(const ImageView8& image, const LocalMap& map, double radius) {
  Eigen::AlignedBox2d box;
  constexpr double kOuter = 1.1 * kReach;  // numeric: of corners, whose sides are outside then
  for (int i = 0; i < kSides; ++i) box.extend(map.pixel(kOuter * side_of_circle(i)));
  std::vector<Pixel> pixels;
  const Matrix2d place_by_pixel = map.first.inverse();
  const auto bound = [](double at, int size) {
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size)));
  };
  const int left = bound(std::floor(box.min().x()), image.width());
  const int right = bound(std::ceil(box.max().x()) + 1, image.width());
  const int bottom = bound(std::ceil(box.max().y()) + 1, image.height());
  for (int y = bound(std::floor(box.min().y()), image.height()); y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const Vector2d at(x, y);
      if (map.place(at).norm() > kReach) continue;
      if (radius > 0 &&
          std::abs(border_at(map, place_by_pixel, at, radius).distance) > policy::kTagOutsidePx)
        continue;
      pixels.push_back({at, static_cast<double>(image(x, y))});
    }
  }
  return pixels;
}

bool is_wholly_inside(const LocalMap& map, double radius, const Vector2d& shift,
                      const ImageSize& size) {
  for (int i = 0; i < kSides; ++i) {
    const Vector2d at = map.pixel(radius * side_of_circle(i)) + shift;
    if (!(at.x() > 0 && at.y() > 0 && at.x() < size.width - 1 && at.y() < size.height - 1))
      return false;
  }
  return true;
}

}  // namespace

Vector2d LocalMap::pixel(const Vector2d& x) const {
  return centre + first * x + of_second_order(x);
}

Vector2d LocalMap::of_second_order(const Vector2d& x) const {
  return second * Eigen::Vector3d(x.x() * x.x(), x.x() * x.y(), x.y() * x.y());
}

Matrix2d LocalMap::derivative(const Vector2d& x) const {
  Matrix2d result = first;
  result.col(0) += 2 * x.x() * second.col(0) + x.y() * second.col(1);
  result.col(1) += x.x() * second.col(1) + 2 * x.y() * second.col(2);
  return result;
}

Vector2d LocalMap::place(const Vector2d& at) const {
  Vector2d x = first.inverse() * (at - centre);
  constexpr int kNewtonSteps = 3;  // numeric: the terms of second order are small
  for (int i = 0; i < kNewtonSteps; ++i) x += derivative(x).inverse() * (at - pixel(x));
  return x;
}

std::optional<CircleFit> fit_circle(const ImageView8& image, const LocalMap& map) {
  std::vector<Pixel> pixels = pixels_about(image, map, 0);
  if (pixels.size() <= 2 * kCount) return std::nullopt;
  Step p = CircleModel(map, std::move(pixels)).start();
  const CircleModel model(map, pixels_about(image, map, std::exp(p[kLogRadius])));
  if (model.num_pixels() <= 2 * kCount) return std::nullopt;
  const auto num_pixels = static_cast<double>(model.num_pixels());
  // numeric: the step that is left out is a tenth of one that would be taken as converged.
  const double converged = policy::kConvergedSds * policy::kConvergedSds / 100;
  const auto best = minimise(model, p,
                             {.flat = converged / num_pixels,
                              .least_decrease = converged * kQuantisation,
                              .max_steps = kMaxSteps});
  if (!best) return std::nullopt;
  p = best->state;
  const double variance = std::max(best->at.cost / (num_pixels - kCount), kQuantisation);
  const Vector2d shift = p.head<2>();
  const double radius = std::exp(p[kLogRadius]);
  const double distance_px = map.first.colwise().norm().minCoeff();  // to the next centre
  if (!p.allFinite() || p[kContrast] < policy::kMinContrast ||
      std::sqrt(variance) > policy::kTagMaxNoiseShare * p[kContrast] ||
      shift.norm() > policy::kMaxMoveShare * distance_px || radius >= kReach ||
      !is_wholly_inside(map, radius, shift, image.size()))
    return std::nullopt;
  const System covariance = variance * best->at.information.ldlt().solve(System::Identity());
  CircleFit fit{map.centre + shift, covariance.topLeftCorner<2, 2>(), radius};
  fit.covariance_px2 = ((fit.covariance_px2 + fit.covariance_px2.transpose()) / 2).eval();
  if (!fit.covariance_px2.allFinite()) return std::nullopt;
  return fit;
}

}  // namespace tagcal::internal
