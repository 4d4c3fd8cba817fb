#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "draw/cairo.hpp"
#include "study/plot/drawing.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {

using Polyline = std::vector<Eigen::Vector2d>;  // pixels, open; one point is a dot

// The parts of a line inside the window.
std::vector<Polyline> clipped(const Polyline& line, const Window& window);

struct Pen {
  Rgb colour = {0, 0, 0};
  double width_px = 1;
  double opacity = 1;
  double dash_px = 0;  // length of a dash and of the gap after it; 0: solid
};

// A text and the place of its middle.
struct Label {
  std::string text;
  Eigen::Vector2d middle;  // pixels
  double height_px = 10;   // of a capital letter
};

// A colour picture with antialiased lines with round ends, and texts, drawn by cairo.
class Canvas {
 public:
  explicit Canvas(const Image8& picture);
  Canvas(const ImageSize& size, const Rgb& colour);

  // Draws the lines as one shape: crossings are not painted twice.
  void draw(const std::vector<Polyline>& lines, const Pen& pen);

  // Bold letters in a white outline, which makes them visible on any picture.
  void write(const Label& label, const Rgb& colour);

  ImageRgb image() const { return image_of(surface_.get()); }

 private:
  CairoSurface surface_;
};

// A full circle.
Polyline circle(const Eigen::Vector2d& centre, double radius_px);

// The width of a text of a drawing.
double text_width(const study::Text& text);

// A drawing on white, by cairo.
std::string drawing_svg(const study::Drawing& drawing);
ImageRgb drawing_image(const study::Drawing& drawing, double pixels_per_unit);
// A file ending in .png, of a pixel per unit, or else .svg.
void write_drawing(const std::filesystem::path& file, const study::Drawing& drawing);

}  // namespace tagcal::tools
