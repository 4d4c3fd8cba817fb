#pragma once

#include <string>
#include <vector>

#include "tagcal/reproject/types.hpp"

// Cameras and panoramas that show what a camera sees, without its distortion. Pictures are meant
// with their outer border: [-0.5, width - 0.5] x [-0.5, height - 0.5].

namespace tagcal {

// Pinholes with the axes of the camera and its ratio fy / fx (of an image of square pixels: square
// pixels). The border of the camera's picture is followed pixel by pixel; the part of it that has
// no ray (beyond the fold of the distortion) is replaced by the last rays towards it.
//
// All pixels: the longest focal length with which the new picture contains every pixel of the old
// one; they touch two sides of the new picture at least, and are centred between the others.
// Valid pixels: the shortest focal length with which the new picture contains nothing else: the
// largest rectangle of the new picture's shape, wherever it fits.
// cv::getOptimalNewCameraMatrix with alpha 1 and 0 means the same, for a grid of 9 x 9 points, and
// scales both axes apart. The throwing cases: a parallel lens; rays more than 80 degrees from the
// axis would have to be shown (the message names panorama and several pinholes).
Camera pinhole_of_all_pixels(const Camera& camera, const ImageSize& size);
Camera pinhole_of_valid_pixels(const Camera& camera, const ImageSize& size);

// The focal length fx as given, and the axis of the camera at the same place of the picture,
// relative to its size.
Camera pinhole_of_focal_length(const Camera& camera, double focal_px, const ImageSize& size);

// A target at the place of the camera, turned.
struct TurnedCamera {
  std::string name;  // "front", "left", .. of a cube; "1" .. "n" of a fan, from the left
  Camera camera;
  Pose camera_from_turned;  // a rotation: from its frame to that of the original camera
};

// Several pinholes that show the field of view together: 6 are the faces of a cube (front, left,
// right, up, down, back; 90 degrees each), and 5 the same without the back, which is not shown
// then; other numbers from 2 on are a fan about the vertical axis, which divides the horizontal
// field of view evenly (each up to 120 degrees wide and 100 high). Focal length: the camera's fx.
// Throws Error for other numbers, a parallel lens, and a fan of too few pinholes.
std::vector<TurnedCamera> several_pinholes(const Camera& camera, int count);

// A panorama of what the camera sees, with px_per_rad of its middle (0: the camera's fx). A
// cylindrical one shows latitudes up to 60 degrees. Throws Error for a parallel lens, and a
// transverse panorama.
Panorama panorama_of(const Camera& camera, PanoramaKind kind, double px_per_rad = 0);

// The angles of the rays of the picture: longitudes and latitudes as in Panorama, and the largest
// angle from the optical axis.
struct AngularRange {
  double left_rad = 0, right_rad = 0;  // longitudes
  double top_rad = 0, bottom_rad = 0;  // latitudes
  double from_axis_rad = 0;
};
AngularRange angular_range(const Camera& camera);

}  // namespace tagcal
