#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/lens.hpp"
#include "tagcal/viewing/canonical.hpp"

// Clipping in space: what of a segment or a convex polygon lies within planes, within a view
// volume, within the domain of a lens; and of a segment in the plane, to a window with y up.

namespace tagcal {

// The side of a plane that is kept: normal . x >= offset.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset = 0;

  // Positive on the kept side; the distance from the plane where the normal has length 1.
  double height(const Eigen::Vector3d& x) const { return normal.dot(x) - offset; }
};

// The view volume's six planes in the frame that a matrix takes to OpenGL's clip coordinates, in
// the order left, right, bottom, top, near, far; normals of length 1, pointing inside (Gribb &
// Hartmann 2001: sums and differences of the matrix' rows). Far is left out where it is infinite.
// For any chain: clip_from_eye, or clip_from_eye * eye_from_camera * camera_from_world.
std::vector<HalfSpace> clip_planes(const Eigen::Matrix4d& clip_from_source);

// Whether a point is inside all of them, their surfaces included.
bool contains(std::span<const HalfSpace> planes, const Eigen::Vector3d& x);

// Inside the canonical volume, before the divide: -w <= x, y, z <= w (and so w >= 0).
bool in_clip_volume(const Eigen::Vector4d& x_in_clip);

// Where the segment from a to b meets the plane of a half-space. No value where it does not reach
// the plane, is parallel to it or lies in it.
std::optional<Eigen::Vector3d> segment_plane_intersection(const Eigen::Vector3d& a,
                                                          const Eigen::Vector3d& b,
                                                          const HalfSpace& plane);

// The part of the segment from a to b inside all planes, by its parameters: a + t (b - a) for
// from <= t <= to, within [0, 1] (Cyrus & Beck 1978). No value where there is none, or a coordinate
// is not finite.
struct SegmentPart {
  double from = 0;
  double to = 1;
};
std::optional<SegmentPart> clip_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        std::span<const HalfSpace> planes);

// The part of a convex polygon on the kept side (Sutherland & Hodgman, CACM 1974); fewer than three
// corners where there is none. An edge is cut at the same point whichever way it runs.
std::vector<Eigen::Vector3d> clip_polygon(const std::vector<Eigen::Vector3d>& polygon,
                                          const HalfSpace& kept);

// The part inside all planes, such as the six of a frustum, or near alone.
std::vector<Eigen::Vector3d> clip_polygon(const std::vector<Eigen::Vector3d>& polygon,
                                          std::span<const HalfSpace> planes);

// The part of a convex polygon in clip coordinates inside the canonical volume. It may reach behind
// the eye: it is cut before the divide, so that everything left has w > 0, unless it only touches
// the eye itself.
std::vector<Eigen::Vector4d> clip_polygon_to_volume(const std::vector<Eigen::Vector4d>& polygon);

// Whether a face turns its back to the eye: its corners run clockwise as seen. On edge counts as
// back. Only the first three corners count; they must not be on a line.
bool is_back_face(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& eye);

// The parts of a convex polygon, in the camera frame, that a lens can project: in front of `near_m`
// for a perspective, and off the border of the domain by flat cuts, 256 planes inscribed in the
// lens' cone. What a fisheye beyond 90 degrees cannot see is a cone behind it: around that the rest
// of the polygon falls into several parts, none of which surrounds the backward axis, so that the
// image of each is the inside of the image of its outline.
std::vector<std::vector<Eigen::Vector3d>> clip_to_domain(
    const std::vector<Eigen::Vector3d>& polygon, const Lens& lens, double near_m);

// Where a point lies, in Cohen and Sutherland's bits: top, bottom, right, left, from the highest.
// The nine regions, row by row from the top: 1001 1000 1010, 0001 0000 0010, 0101 0100 0110.
enum OutcodeBit : std::uint8_t { kLeft = 1, kRight = 2, kBottom = 4, kTop = 8 };
std::uint8_t outcode(const Window& window, const Eigen::Vector2d& point);

struct Segment2 {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

// The part of a segment inside the window; one point where it only touches. No value where there is
// none, or a coordinate is not finite. Two ways, the same answer: by the codes of the ends, one
// border at a time (Cohen & Sutherland 1967), and by the parameter along the line, all borders at
// once (Liang & Barsky, ACM TOG 1984).
std::optional<Segment2> clip_line_cohen_sutherland(const Window& window, const Segment2& segment);
std::optional<Segment2> clip_line_liang_barsky(const Window& window, const Segment2& segment);

}  // namespace tagcal
