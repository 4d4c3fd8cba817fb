#include "tagcal/detect/board_search/straight_tag.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// numeric: pixels a cell; half of those in the picture leave the start of a fit exact enough
constexpr double kLeastCellPx = 4, kMostCellPx = 8;

// The level between four pixels, and beyond the edge that of the edge.
std::uint8_t level_at(const ImageView8& image, const Vector2d& at) {
  const double x = std::clamp(at.x(), 0.0, std::nextafter(image.width() - 1.0, 0.0));
  const double y = std::clamp(at.y(), 0.0, std::nextafter(image.height() - 1.0, 0.0));
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const std::uint8_t* const here = image.row(row) + column;
  const std::uint8_t* const below = here + image.stride();
  const double u = x - column, v = y - row;
  return static_cast<std::uint8_t>((1 - v) * ((1 - u) * here[0] + u * here[1]) +
                                   v * ((1 - u) * below[0] + u * below[1]) + 1.0 / 2);
}

}  // namespace

std::optional<StraightTag> StraightTag::of(const ImageView8& image, const PlacedTag& tag,
                                           const PlaneView& view, int width_at_border,
                                           double margin_cells) {
  const auto predicted = mapped(tag.corners, [&](const Vector2d& x) { return view.pixel(x); });
  if (!predicted || !is_face(*predicted)) return std::nullopt;
  StraightTag result(view);
  result.predicted_ = *predicted;
  double side_px = 0;
  for (std::size_t i = 0; i < 4; ++i)
    side_px = std::max(side_px, (result.predicted_[(i + 1) % 4] - result.predicted_[i]).norm());
  const double cell = std::clamp(side_px / width_at_border / 2, kLeastCellPx, kMostCellPx);
  const double margin = margin_cells * cell, side = width_at_border * cell;
  result.right_ = (tag.corners[1] - tag.corners[0]) / side;
  result.down_ = (tag.corners[0] - tag.corners[3]) / side;
  result.upper_left_ = tag.corners[3] - margin * (result.right_ + result.down_);
  const double least = margin, most = margin + side;
  result.expected_ = {{{least, most}, {most, most}, {most, least}, {least, least}}};
  const int width = static_cast<int>(std::ceil(most + margin)) + 1;
  result.image_ = Image8({width, width});
  for (int y = 0; y < width; ++y)
    for (int x = 0; x < width; ++x)
      if (const auto pixel = view.pixel(result.on_plane(Vector2d(x, y))))
        result.image_(x, y) = level_at(image, *pixel);
  return result;
}

Vector2d StraightTag::on_plane(const Vector2d& pixel) const {
  return upper_left_ + pixel.x() * right_ + pixel.y() * down_;
}

std::optional<Quad> StraightTag::in_picture(const Quad& corners) const {
  return mapped(corners, [&](const Vector2d& x) { return view_.pixel(on_plane(x)); });
}

std::optional<Quad> StraightTag::straightened(const Quad& corners) const {
  return mapped(corners, [&](const Vector2d& pixel) -> std::optional<Vector2d> {
    const auto place = view_.on_plane(pixel);
    if (!place) return std::nullopt;
    const Vector2d from = *place - upper_left_;
    return Vector2d(from.dot(right_) / right_.squaredNorm(), from.dot(down_) / down_.squaredNorm());
  });
}

}  // namespace tagcal::internal
