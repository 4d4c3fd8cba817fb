#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/viewing/canonical.hpp"

// The last step, to the raster, and what becomes of a camera when its picture is cut, binned or
// resized. Pixels as everywhere: (0, 0) is the centre of the top-left pixel, y down.

namespace tagcal {

// Takes points (x, y, 1) of one rectangle to the same place in another: window to viewport.
// Throws Error for a window without an area.
Eigen::Matrix3d viewport_from_window(const Window& viewport, const Window& window);

// Where a raster's first pixel lies on its device, and which way its rows run.
struct Raster {
  ImageSize size;
  Eigen::Vector2i offset_px = Eigen::Vector2i::Zero();  // device coordinates of the first pixel
  bool y_down = true;  // false: the first row is the lowest, as in OpenGL's window
};

// Normalised device coordinates to pixels, z kept: [-1, 1] becomes [-1/2, n - 1/2], that is
// u = n/2 x + (n - 1)/2. (OpenGL's own window coordinates are larger by 1/2: there the centre of
// the first pixel is 0.5.)
Eigen::Matrix4d raster_from_ndc(const Raster& raster);

// A rectangle of whole pixels, by its first pixel.
struct PixelRectangle {
  int x = 0;
  int y = 0;
  ImageSize size;
};

// An image in a grid of parts, row by row from the top, whose sizes differ by one pixel at most:
// what each display of a wall shows. Throws Error for more parts than pixels.
std::vector<PixelRectangle> sectors(const ImageSize& size, int columns, int rows);

// The camera that takes just this part of the picture; its frustum is off-centre. The part may
// reach over the border of the image.
Camera cropped(const Camera& camera, const PixelRectangle& part);

// The camera whose pixels are sums of columns x rows pixels; a remainder at the right and lower
// border is lost.
Camera binned(const Camera& camera, int columns, int rows);

// The camera of the picture scaled to another size: the outer border stays where it is,
// c' = s (c + 1/2) - 1/2.
Camera resized(const Camera& camera, const ImageSize& size);

// The camera without its lens' distortion: the same fx, fy, cx, cy. A fisheye becomes the pinhole
// that agrees with it on the axis.
Camera undistorted(const Camera& camera);

}  // namespace tagcal
