#include <fmt/format.h>

#include <algorithm>

#include "draw/svg_panel.hpp"
#include "draw/view_panels.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

constexpr double kMarginX = 10, kMarginY = 20;  // px, for the names of the corners

std::string pixel_text(const Vector2d& pixel) {
  return fmt::format("({:.6g}, {:.6g})", pixel.x(), pixel.y());
}

class ImagePanel {
 public:
  ImagePanel(const ViewReport& report, const PanelSize& size)
      : report_(report),
        size_(size),
        camera_(resized(report.pipeline.camera, drawn_size())),
        labels_({0, size.width, 0, size.height}) {}

  std::string svg() {
    const SvgPanel panel(camera_, report_.pipeline.camera_from_world);
    const ImageSize& drawn = camera_.image_size;
    const Vector2d corner = origin();
    std::string svg = fmt::format(
        "<svg id=\"image-drawing\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" viewBox=\"-0.5 "
        "-0.5 {} {}\">\n<rect x=\"-0.5\" y=\"-0.5\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n",
        corner.x(), corner.y(), drawn.width, drawn.height, drawn.width, drawn.height, drawn.width,
        drawn.height, grey(report_.scene.background_level));
    svg += panel.things(report_.scene) + "</svg>\n";
    svg += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{}\"/>\n",
        corner.x(), corner.y(), drawn.width, drawn.height, kInk);
    svg += marks();
    name_corners();
    return svg + "<g id=\"image-labels\">\n" + labels_.svg() + "</g>\n";
  }

 private:
  ImageSize drawn_size() const {
    const ImageSize& size = report_.pipeline.camera.image_size;
    const double scale = std::min((size_.width - 2 * kMarginX) / size.width,
                                  (size_.height - 2 * kMarginY) / size.height);
    return {std::max(1, static_cast<int>(size.width * scale)),
            std::max(1, static_cast<int>(size.height * scale))};
  }

  // The upper left corner of the image in the panel.
  Vector2d origin() const { return {kMarginX, kMarginY}; }

  // The place of a pixel of the whole image in the panel; no value outside of the image.
  std::optional<Vector2d> in_panel(const std::optional<Vector2d>& pixel) const {
    const ImageSize &whole = report_.pipeline.camera.image_size, &drawn = camera_.image_size;
    if (!pixel || !contains(whole, *pixel)) return std::nullopt;
    const Vector2d scale(1.0 * drawn.width / whole.width, 1.0 * drawn.height / whole.height);
    return origin() + scale.cwiseProduct(*pixel + Vector2d::Constant(0.5));
  }

  std::string marks() {
    const FollowedPoint& f = report_.followed;
    const auto p = parameters(report_.pipeline.camera.lens);
    const Vector2d principal(p[2], p[3]);
    std::string svg;
    if (const auto at = in_panel(principal)) {
      svg += fmt::format("<path d=\"M{:.2f} {:.2f}m-6 0h12m-6 -6v12\" stroke=\"{}\"/>\n", at->x(),
                         at->y(), kVolumeColour);
      labels_.keep_free(*at);
      labels_.add("principal point " + pixel_text(principal), *at, kVolumeColour);
    }
    if (const auto at = in_panel(f.in_raster_px))
      svg += svg_circle("raster", *at, 6, fmt::format("fill=\"none\" stroke=\"{}\"", kPointColour));
    const auto at = in_panel(f.pixel);
    if (!at) return svg;
    labels_.keep_free(*at);
    labels_.add("pixel " + pixel_text(*f.pixel), *at, kPointColour);
    const std::string_view fill = f.sight == Sight::seen ? kPointColour : "none";
    return svg + svg_circle("pixel", *at, 3,
                            fmt::format("fill=\"{}\" stroke=\"{}\"", fill, kPointColour));
  }

  void name_corners() {
    const ImageSize &whole = report_.pipeline.camera.image_size, &drawn = camera_.image_size;
    for (const int x : {0, 1})
      for (const int y : {0, 1})
        labels_.add(pixel_text({x * whole.width - 0.5, y * whole.height - 0.5}),
                    origin() + Vector2d(x * drawn.width, y * drawn.height), kInk);
  }

  const ViewReport& report_;
  PanelSize size_;
  Camera camera_;
  SvgLabels labels_;
};

}  // namespace

std::string image_panel(const ViewReport& report, const PanelSize& size) {
  return ImagePanel(report, size).svg();
}

}  // namespace tagcal::tools
