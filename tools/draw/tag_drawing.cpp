#include "draw/tag_drawing.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <string>

#include "draw/canvas.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr Rgb kTagColour = {0, 170, 60};
constexpr Rgb kUnfittedColour = {200, 60, 200};
constexpr Rgb kCornerColour = {230, 40, 30};
constexpr Rgb kEllipseColour = {40, 90, 255};
constexpr Rgb kIdColour = {255, 140, 0};
constexpr double kDigitHeight = 0.3;  // of a tag's shortest side
constexpr int kEllipsePoints = 48;

Polyline ellipse(const Vector2d& centre, const Matrix2& covariance) {
  // Any square root of the covariance maps the circle to the ellipse.
  const Eigen::Matrix2d shape = Eigen::Matrix2d(covariance).llt().matrixL();
  Polyline line;
  for (int i = 0; i <= kEllipsePoints; ++i) {
    const double turn = 2 * std::numbers::pi * i / kEllipsePoints;
    line.emplace_back(centre + kEllipseScale * (shape * Vector2d(std::cos(turn), std::sin(turn))));
  }
  return line;
}

// The observed corners of a tag, by number.
using Corners = std::map<int, const Observation*>;

double shortest_side(const Corners& corners) {
  double shortest = 1e9;
  for (const auto& [i, a] : corners)
    for (const auto& [j, b] : corners)
      if (i < j) shortest = std::min(shortest, (a->pixel - b->pixel).norm());
  return corners.size() > 1 ? shortest : 20;
}

struct Shapes {
  std::vector<Polyline> outlines, dashed, firsts, crosses, ellipses;
  std::vector<Label> numbers;
};

void add_tag(int id, const Corners& corners, Shapes& shapes) {
  const double size = std::clamp(0.06 * shortest_side(corners), 2.0, 8.0);
  Polyline outline;
  Vector2d sum = Vector2d::Zero();
  for (const auto& [i, seen] : corners) {
    const Vector2d& at = seen->pixel;
    outline.push_back(at);
    sum += at;
    shapes.crosses.push_back({at - Vector2d(size, 0), at + Vector2d(size, 0)});
    shapes.crosses.push_back({at - Vector2d(0, size), at + Vector2d(0, size)});
    if (i == 0) shapes.firsts.push_back({at});
    if (seen->covariance_px2) shapes.ellipses.push_back(ellipse(at, *seen->covariance_px2));
  }
  if (corners.size() == 4) outline.push_back(outline.front());
  shapes.outlines.push_back(outline);
  const double height = std::max(6.0, kDigitHeight * shortest_side(corners));
  Vector2d middle = sum / static_cast<double>(corners.size());
  if (corners.size() == 1) middle += Vector2d(1.2 * height, -height);  // beside a single point
  shapes.numbers.push_back({std::to_string(id), middle, height});
}

void add_unfitted(const UnfittedTag& tag, Shapes& shapes) {
  Polyline outline(tag.corners.begin(), tag.corners.end());
  outline.push_back(outline.front());
  shapes.dashed.push_back(outline);
  const Vector2d middle = (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]) / 4;
  const double side = (tag.corners[1] - tag.corners[0]).norm();
  shapes.numbers.push_back({std::to_string(tag.id), middle, std::max(6.0, kDigitHeight * side)});
}

// The width grows with the picture, and is a pixel at least.
ImageRgb drawn(const Image8& picture, const Shapes& shapes) {
  const double width = std::max(1.0, std::max(picture.width(), picture.height()) / 1200.0);
  Canvas canvas(picture);
  canvas.draw(shapes.outlines, {kTagColour, width, 0.8});
  canvas.draw(shapes.dashed, {kUnfittedColour, width, 0.9, 4 * width});
  canvas.draw(shapes.firsts, {kTagColour, 6 * width, 0.8});
  for (const Label& number : shapes.numbers) canvas.write(number, kIdColour);
  canvas.draw(shapes.ellipses, {kEllipseColour, width, 0.9});
  canvas.draw(shapes.crosses, {kCornerColour, std::max(1.0, 0.6 * width), 1});
  return canvas.image();
}

}  // namespace

ImageRgb draw_tags(const Image8& picture, const View& view,
                   const std::vector<UnfittedTag>& unfitted) {
  std::map<int, Corners> tags;
  for (const Observation& seen : view.observations) tags[seen.id.tag_id][seen.id.corner] = &seen;
  Shapes shapes;
  for (const auto& [id, corners] : tags) add_tag(id, corners, shapes);
  for (const UnfittedTag& tag : unfitted) add_unfitted(tag, shapes);
  return drawn(picture, shapes);
}

ImageRgb draw_tags(const Image8& picture, const std::vector<DetectedTag>& tags) {
  Shapes shapes;
  for (const DetectedTag& tag : tags) {
    std::array<Observation, 4> seen;
    Corners corners;
    for (int i = 0; i < 4; ++i) {
      Observation& corner = seen[static_cast<std::size_t>(i)];
      corner = {{tag.id, i}, tag.corners[static_cast<std::size_t>(i)], {}};
      if (tag.covariance_px2) corner.covariance_px2 = tag.covariance_px2->block<2, 2>(2 * i, 2 * i);
      corners[i] = &corner;
    }
    add_tag(tag.id, corners, shapes);
  }
  return drawn(picture, shapes);
}

}  // namespace tagcal::tools
