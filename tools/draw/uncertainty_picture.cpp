#include "draw/uncertainty_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "report/shown_parameters.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr int kWidth = 640;
constexpr int kTitleHeight = 30;
constexpr double kLowestPx = 0.001;
constexpr double kHighestPx = 10;

// 0 at the lowest value, 1 at the highest and without a value.
double level(double sigma_px) {
  if (!std::isfinite(sigma_px)) return 1;
  return std::clamp(
      std::log(std::max(sigma_px, 1e-300) / kLowestPx) / std::log(kHighestPx / kLowestPx), 0.0,
      1.0);
}

// Colour from blue by green and yellow to red.
std::string colour(double share) {
  static constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{49, 90, 170}, {66, 160, 160}, {150, 200, 110}, {245, 205, 90}, {200, 60, 45}}};
  const double at = share * (kStops.size() - 1);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(i);
  std::array<long, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = std::lround((1 - rest) * kStops[i][c] + rest * kStops[i + 1][c]);
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

// Bilinear interpolation of the levels; column and row in nodes.
double level_at(const Eigen::MatrixXd& sigma, double column, double row) {
  const auto c = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(column), 0, sigma.cols() - 2);
  const auto r = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(row), 0, sigma.rows() - 2);
  const double x = column - static_cast<double>(c), y = row - static_cast<double>(r);
  return (1 - y) * ((1 - x) * level(sigma(r, c)) + x * level(sigma(r, c + 1))) +
         y * ((1 - x) * level(sigma(r + 1, c)) + x * level(sigma(r + 1, c + 1)));
}

int panel_height(const Camera& camera) {
  const double ratio = static_cast<double>(camera.image_size.height) / camera.image_size.width;
  return static_cast<int>(std::clamp(std::lround(kWidth * ratio), 16L, 4L * kWidth));
}

struct PanelFrame {
  const Calibration& calibration;
  double top = 0;
  int height = 0;

  Vector2d at(const Vector2d& pixel) const {
    const ImageSize& size = calibration.camera->image_size;
    return {(pixel.x() + 0.5) * kWidth / size.width,
            top + (pixel.y() + 0.5) * height / size.height};
  }
};

std::string cells_svg(const ProjectionUncertainty& p, const PanelFrame& frame) {
  constexpr int kFiner = 4;  // cells to a node
  std::string svg;
  const int columns = kFiner * (p.grid.columns - 1), rows = kFiner * (p.grid.rows - 1);
  const double w = static_cast<double>(kWidth) / columns;
  const double h = static_cast<double>(frame.height) / rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double share = level_at(p.sigma_px, (column + 0.5) / kFiner, (row + 0.5) / kFiner);
      svg += fmt::format(
          "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
          "fill=\"{}\"/>\n",
          column * w, frame.top + row * h, w + 0.3, h + 0.3, colour(share));
    }
  }
  return svg;
}

std::string numbers_svg(const ProjectionUncertainty& p, const PanelFrame& frame) {
  std::string svg;
  for (int row = 1; row < p.grid.rows; row += 3) {
    for (int column = 2; column < p.grid.columns; column += 4) {
      const double sigma = p.sigma_px(row, column);
      const Vector2d at = frame.at(p.grid.pixel(column, row));
      const std::string text = std::isnan(sigma)               ? "no ray"
                               : has_bound(sigma, p.grid.size) ? fmt::format("{:.2g}", sigma)
                                                               : "no bound";
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                         at.x(), at.y() + 4, text);
    }
  }
  return svg;
}

std::string hull_svg(const PanelFrame& frame) {
  std::string points;
  for (const Vector2d& pixel : frame.calibration.seen.hull()) {
    const Vector2d at = frame.at(pixel);
    points += fmt::format("{:.1f},{:.1f} ", at.x(), at.y());
  }
  return fmt::format(
      "<polygon points=\"{}\" fill=\"none\" stroke=\"#fff\" stroke-width=\"2\" "
      "stroke-dasharray=\"6 4\"/>\n",
      points);
}

}  // namespace

std::string distance_text(double distance_m) {
  return std::isfinite(distance_m) ? fmt::format("{:.3g} m", distance_m) : "infinity";
}

std::string uncertainty_svg(const Calibration& calibration) {
  const int height = panel_height(*calibration.camera);
  const int panel = height + kTitleHeight;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
      kWidth, panel * static_cast<int>(calibration.projection.size()));
  for (std::size_t i = 0; i < calibration.projection.size(); ++i) {
    const ProjectionUncertainty& p = calibration.projection[i];
    const double top = static_cast<double>(panel) * static_cast<double>(i);
    const PanelFrame frame{calibration, top + kTitleHeight, height};
    svg += fmt::format(
        "<text x=\"8\" y=\"{:.0f}\">sd of the projection at {}, pixels per coordinate; dashed: "
        "where corners were</text>\n",
        top + 20, distance_text(p.distance_m));
    svg += cells_svg(p, frame) + hull_svg(frame) + numbers_svg(p, frame);
  }
  return svg + "</svg>\n";
}

Image8 uncertainty_image(const Calibration& calibration) {
  const int height = panel_height(*calibration.camera);
  Image8 image({kWidth, height * static_cast<int>(calibration.projection.size())});
  for (int y = 0; y < image.height(); ++y) {
    const ProjectionUncertainty& p = calibration.projection[static_cast<std::size_t>(y / height)];
    const double row = (y % height + 0.5) * (p.grid.rows - 1) / height;
    for (int x = 0; x < kWidth; ++x) {
      const double column = (x + 0.5) * (p.grid.columns - 1) / kWidth;
      image(x, y) = static_cast<std::uint8_t>(std::lround(255 * level_at(p.sigma_px, column, row)));
    }
  }
  return image;
}

}  // namespace tagcal::tools
