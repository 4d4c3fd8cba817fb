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

// Seven segments, in the order top, upper right, lower right, bottom, lower left, upper left,
// middle; a digit is 1 high and half as wide, y down.
constexpr std::array<std::array<double, 4>, 7> kSegments = {{{0, 0, 0.5, 0},
                                                             {0.5, 0, 0.5, 0.5},
                                                             {0.5, 0.5, 0.5, 1},
                                                             {0, 1, 0.5, 1},
                                                             {0, 0.5, 0, 1},
                                                             {0, 0, 0, 0.5},
                                                             {0, 0.5, 0.5, 0.5}}};
constexpr std::array<std::string_view, 10> kDigits = {"1111110", "0110000", "1101101", "1111001",
                                                      "0110011", "1011011", "1011111", "1110000",
                                                      "1111111", "1111011"};

// Strokes of a whole number around a place.
std::vector<Polyline> number(int value, const Vector2d& middle, double height) {
  const std::string text = std::to_string(value);
  const double advance = 0.8 * height;
  Vector2d at = middle - Vector2d(0.5 * (advance * static_cast<double>(text.size()) - 0.3 * height),
                                  0.5 * height);
  std::vector<Polyline> lines;
  for (const char c : text) {
    const std::string_view lit = kDigits.at(static_cast<std::size_t>(c - '0'));
    for (std::size_t i = 0; i < kSegments.size(); ++i) {
      const auto& s = kSegments[i];
      if (lit[i] == '1')
        lines.push_back({at + height * Vector2d(s[0], s[1]), at + height * Vector2d(s[2], s[3])});
    }
    at.x() += advance;
  }
  return lines;
}

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

struct Lines {
  std::vector<Polyline> outlines, dashed, firsts, crosses, ellipses, numbers;
};

void add_tag(int id, const Corners& corners, Lines& lines) {
  const double size = std::clamp(0.06 * shortest_side(corners), 2.0, 8.0);
  Polyline outline;
  Vector2d sum = Vector2d::Zero();
  for (const auto& [i, seen] : corners) {
    const Vector2d& at = seen->pixel;
    outline.push_back(at);
    sum += at;
    lines.crosses.push_back({at - Vector2d(size, 0), at + Vector2d(size, 0)});
    lines.crosses.push_back({at - Vector2d(0, size), at + Vector2d(0, size)});
    if (i == 0) lines.firsts.push_back({at});
    if (seen->covariance_px2) lines.ellipses.push_back(ellipse(at, *seen->covariance_px2));
  }
  if (corners.size() == 4) outline.push_back(outline.front());
  lines.outlines.push_back(outline);
  const double height = std::max(6.0, kDigitHeight * shortest_side(corners));
  Vector2d middle = sum / static_cast<double>(corners.size());
  if (corners.size() == 1) middle += Vector2d(1.2 * height, -height);  // beside a single point
  for (const Polyline& line : number(id, middle, height)) lines.numbers.push_back(line);
}

void add_unfitted(const UnfittedTag& tag, Lines& lines) {
  Polyline outline(tag.corners.begin(), tag.corners.end());
  outline.push_back(outline.front());
  lines.dashed.push_back(outline);
  const Vector2d middle = (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]) / 4;
  const double side = (tag.corners[1] - tag.corners[0]).norm();
  for (const Polyline& line : number(tag.id, middle, std::max(6.0, kDigitHeight * side)))
    lines.numbers.push_back(line);
}

// The width grows with the picture, and is a pixel at least.
ImageRgb drawn(const Image8& picture, const Lines& lines) {
  const double width = std::max(1.0, std::max(picture.width(), picture.height()) / 1200.0);
  Canvas canvas(picture);
  canvas.draw(lines.outlines, {kTagColour, width, 0.8});
  canvas.draw(lines.dashed, {kUnfittedColour, width, 0.9, 4 * width});
  canvas.draw(lines.firsts, {kTagColour, 6 * width, 0.8});
  canvas.draw(lines.numbers, {{255, 255, 255}, 4 * width, 0.8});
  canvas.draw(lines.numbers, {kIdColour, 2 * width, 1});
  canvas.draw(lines.ellipses, {kEllipseColour, width, 0.9});
  canvas.draw(lines.crosses, {kCornerColour, std::max(1.0, 0.6 * width), 1});
  return canvas.image();
}

}  // namespace

ImageRgb draw_tags(const Image8& picture, const View& view,
                   const std::vector<UnfittedTag>& unfitted) {
  std::map<int, Corners> tags;
  for (const Observation& seen : view.observations) tags[seen.id.tag_id][seen.id.corner] = &seen;
  Lines lines;
  for (const auto& [id, corners] : tags) add_tag(id, corners, lines);
  for (const UnfittedTag& tag : unfitted) add_unfitted(tag, lines);
  return drawn(picture, lines);
}

ImageRgb draw_tags(const Image8& picture, const std::vector<DetectedTag>& tags) {
  Lines lines;
  for (const DetectedTag& tag : tags) {
    std::array<Observation, 4> seen;
    Corners corners;
    for (int i = 0; i < 4; ++i) {
      Observation& corner = seen[static_cast<std::size_t>(i)];
      corner = {{tag.id, i}, tag.corners[static_cast<std::size_t>(i)], {}};
      if (tag.covariance_px2) corner.covariance_px2 = tag.covariance_px2->block<2, 2>(2 * i, 2 * i);
      corners[i] = &corner;
    }
    add_tag(tag.id, corners, lines);
  }
  return drawn(picture, lines);
}

}  // namespace tagcal::tools
