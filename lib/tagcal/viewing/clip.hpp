#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tagcal/camera/lens.hpp"
#include "tagcal/viewing/canonical.hpp"

// Clips segments and convex polygons in space to planes, to a view volume or to the domain of a
// lens, and segments in the plane to a window with y up.

namespace tagcal {

// The kept side of a plane: normal . x >= offset.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset = 0;

  // Positive on the kept side; the distance from the plane where the normal has length 1.
  double height(const Eigen::Vector3d& x) const { return normal.dot(x) - offset; }
};

// The view volume's six planes in the frame that a matrix takes to OpenGL's clip coordinates, in
// the order left, right, bottom, top, near, far; normals of length 1, pointing inside (Gribb &
// Hartmann 2001: sums and differences of the matrix' rows). An infinite far plane is omitted. The
// matrix may be any chain: clip_from_eye, or clip_from_eye * eye_from_camera * camera_from_world.
std::vector<HalfSpace> clip_planes(const Eigen::Matrix4d& clip_from_source);

// Returns true if the point is inside all half-spaces, their surfaces included.
bool contains(std::span<const HalfSpace> planes, const Eigen::Vector3d& x);

// Returns true if the point is inside the canonical volume, before the division by w:
// -w <= x, y, z <= w (and so w >= 0).
bool in_clip_volume(const Eigen::Vector4d& x_in_clip);

// The intersection of the segment from a to b with the plane of a half-space. No value if the
// segment does not reach the plane, is parallel to it or lies in it.
std::optional<Eigen::Vector3d> segment_plane_intersection(const Eigen::Vector3d& a,
                                                          const Eigen::Vector3d& b,
                                                          const HalfSpace& plane);

// The part of the segment from a to b inside all planes, by its parameters: a + t (b - a) for
// from <= t <= to, within [0, 1] (Cyrus & Beck 1978). No value if nothing is inside or a coordinate
// is not finite.
struct SegmentPart {
  double from = 0;
  double to = 1;
};
std::optional<SegmentPart> clip_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        std::span<const HalfSpace> planes);

// The part of a convex polygon on the kept side (Sutherland & Hodgman, CACM 1974); fewer than three
// corners if nothing is kept. An edge is cut at the same point in either direction.
std::vector<Eigen::Vector3d> clip_polygon(const std::vector<Eigen::Vector3d>& polygon,
                                          const HalfSpace& kept);

// The part of a convex polygon inside all planes, for example the six of a frustum.
std::vector<Eigen::Vector3d> clip_polygon(const std::vector<Eigen::Vector3d>& polygon,
                                          std::span<const HalfSpace> planes);

// The part of a convex polygon in clip coordinates inside the canonical volume. The polygon may
// reach behind the eye: it is clipped before the division by w, so that every remaining corner has
// w > 0 unless the polygon touches the eye itself.
std::vector<Eigen::Vector4d> clip_polygon_to_volume(const std::vector<Eigen::Vector4d>& polygon);

// Returns true if the eye sees the back of a face: its corners run clockwise in the view, or the
// face is seen edge-on. Uses the first three corners, which must not be on a line.
bool is_back_face(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& eye);

// The parts of a convex polygon, in the camera frame, that a lens can project: beyond `near_m` for
// a perspective, and inside 256 planes inscribed in the cone of the lens' domain. A fisheye beyond
// 90 degrees cannot see a cone behind it. The rest of the polygon around that cone is returned as
// several parts, none of which surrounds the backward axis, so that the image of each part is the
// inside of the image of its outline.
std::vector<std::vector<Eigen::Vector3d>> clip_to_domain(
    const std::vector<Eigen::Vector3d>& polygon, const Lens& lens, double near_m);

// Region code of a point in Cohen and Sutherland's bits: top, bottom, right, left, from the
// highest. The nine regions, row by row from the top: 1001 1000 1010, 0001 0000 0010, 0101 0100
// 0110.
enum OutcodeBit : std::uint8_t { kLeft = 1, kRight = 2, kBottom = 4, kTop = 8 };
std::uint8_t outcode(const Window& window, const Eigen::Vector2d& point);

struct Segment2 {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

// The part of a segment inside the window; a single point if the segment only touches it. No value
// if nothing is inside or a coordinate is not finite. Both algorithms give the same answer: one
// cuts at one border at a time by the region codes (Cohen & Sutherland 1967), the other finds the
// range of the line's parameter for all borders at once (Liang & Barsky, ACM TOG 1984).
std::optional<Segment2> clip_line_cohen_sutherland(const Window& window, const Segment2& segment);
std::optional<Segment2> clip_line_liang_barsky(const Window& window, const Segment2& segment);

}  // namespace tagcal
