#pragma once

#include <Eigen/Core>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/viewing/canonical.hpp"

// The transform to the raster, and the camera of a picture that is cropped, binned or resized.
// Pixel (0, 0) is the centre of the top-left pixel, y down.

namespace tagcal {

// Maps points (x, y, 1) of the window to the same relative position in the viewport. Throws Error
// for a window without an area.
Eigen::Matrix3d viewport_from_window(const Window& viewport, const Window& window);

// The position of a raster's first pixel on its device, and the direction of its rows.
struct Raster {
  ImageSize size;
  Eigen::Vector2i offset_px = Eigen::Vector2i::Zero();  // device coordinates of the first pixel
  bool y_down = true;  // false: the first row is the lowest, as in OpenGL's window
  int num_depths = 0;  // levels of a depth buffer; 0: z is kept
};

// Maps normalised device coordinates to pixels: [-1, 1] becomes [-1/2, n - 1/2], that is
// u = n/2 x + (n - 1)/2, and z likewise to the levels of depth, if there are any. (OpenGL's own
// window coordinates are larger by 1/2: there the centre of the first pixel is 0.5.)
Eigen::Matrix4d raster_from_ndc(const Raster& raster);

// A rectangle of whole pixels; (x, y) is its top-left pixel.
struct PixelRectangle {
  int x = 0;
  int y = 0;
  ImageSize size;
};

// Divides an image into a grid of parts, row by row from the top, for example the displays of a
// wall. Their sizes differ by at most one pixel. Throws Error for more parts than pixels.
std::vector<PixelRectangle> sectors(const ImageSize& size, int columns, int rows);

// The camera of this part of the picture; its frustum is off-centre. The part may extend beyond the
// image.
Camera cropped(const Camera& camera, const PixelRectangle& part);

// The camera whose pixels are sums of columns x rows pixels; a remainder at the right and lower
// border is lost.
Camera binned(const Camera& camera, int columns, int rows);

// The camera of the picture scaled to another size: c' = s (c + 1/2) - 1/2, so that the outer
// border of the old image is the outer border of the new one.
Camera resized(const Camera& camera, const ImageSize& size);

// The camera without distortion, with the same fx, fy, cx, cy. A fisheye becomes the pinhole that
// agrees with it on the axis, an oblique projection the orthographic one.
Camera undistorted(const Camera& camera);

// A rectangle in the world, for example a display, through which an eye looks: three of its corners
// as seen by the eye.
struct WindowInWorld {
  Eigen::Vector3d lower_left;
  Eigen::Vector3d lower_right;
  Eigen::Vector3d upper_left;
};

// The camera whose image fills the window, seen from the eye: its axis is the window's normal, its
// frustum is off-centre unless the eye is before the middle (head tracking: Kooima, Generalized
// Perspective Projection, 2008). Throws Error if the window is no rectangle (sides perpendicular to
// within 1e-9 rad) or the eye is not before it.
struct CameraBehindWindow {
  Camera camera;
  Pose camera_from_world;
};
CameraBehindWindow camera_behind(const WindowInWorld& window, const Eigen::Vector3d& eye,
                                 const ImageSize& size);

}  // namespace tagcal
