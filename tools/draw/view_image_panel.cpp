#include <fmt/format.h>

#include <algorithm>

#include "draw/labels.hpp"
#include "draw/scene_drawing.hpp"
#include "draw/view_panels.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using study::Drawing;

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

  Drawing drawing() {
    const ImageSize& drawn = camera_.image_size;
    const Vector2d from = origin(), to = from + Vector2d(drawn.width, drawn.height);
    Drawing drawing;
    drawing.area(from.x(), from.y(), to.x(), to.y(), grey_colour(report_.scene.background_level));
    Drawing things;
    ScenePen(camera_, report_.pipeline.camera_from_world).draw(report_.scene, things);
    drawing.add(things, from + Vector2d::Constant(0.5));
    add_outline({from, {to.x(), from.y()}, to, {from.x(), to.y()}}, kInk, 1, drawing);
    add_marks(drawing);
    name_corners();
    labels_.draw(drawing);
    return drawing;
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

  void add_marks(Drawing& drawing) {
    const FollowedPoint& f = report_.followed;
    const auto p = parameters(report_.pipeline.camera.lens);
    const Vector2d principal(p[2], p[3]);
    if (const auto at = in_panel(principal)) {
      for (const Vector2d& arm : {Vector2d(6, 0), Vector2d(0, 6)})
        drawing.line(*at - arm, *at + arm, kVolumeColour, 1);
      labels_.keep_free(*at);
      labels_.add("principal point " + pixel_text(principal), *at, kVolumeColour);
    }
    if (const auto at = in_panel(f.in_raster_px)) add_ring(*at, 6, kPointColour, drawing);
    const auto at = in_panel(f.pixel);
    if (!at) return;
    labels_.keep_free(*at);
    labels_.add("pixel " + pixel_text(*f.pixel), *at, kPointColour);
    (f.sight == Sight::seen ? add_disc : add_ring)(*at, 3, kPointColour, drawing);
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
  Labels labels_;
};

}  // namespace

Drawing image_panel(const ViewReport& report, const PanelSize& size) {
  return ImagePanel(report, size).drawing();
}

}  // namespace tagcal::tools
