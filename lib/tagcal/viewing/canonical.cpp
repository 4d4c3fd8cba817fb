#include "tagcal/viewing/canonical.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tagcal/error.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

void check(const ViewVolume& volume) {
  const Window& w = volume.window;
  const bool perspective = volume.projection == Projection::perspective;
  const bool finite = std::isfinite(w.left) && std::isfinite(w.right) && std::isfinite(w.bottom) &&
                      std::isfinite(w.top) && std::isfinite(volume.near_m);
  if (!finite || !(w.left < w.right) || !(w.bottom < w.top))
    throw Error("view volume: left < right and bottom < top must hold");
  if (perspective && !(volume.near_m > 0)) throw Error("view volume: near must be > 0");
  if (!(volume.near_m < volume.far_m)) throw Error("view volume: near < far must hold");
  if (!perspective && std::isinf(volume.far_m))
    throw Error("view volume: far must be finite for a parallel projection");
}

std::vector<NormalisingStep> perspective_steps(const ViewVolume& v) {
  const Window& w = v.window;
  const double k = v.near_m / v.far_m;
  const Affine shear = shearing(Axis::x, Axis::z, (w.left + w.right) / (2 * v.near_m)) *
                       shearing(Axis::y, Axis::z, (w.bottom + w.top) / (2 * v.near_m));
  const Affine scale =
      scaling({2 * k / (w.right - w.left), 2 * k / (w.top - w.bottom), 1 / v.far_m});
  Matrix4d box_from_pyramid = Matrix4d::Identity();
  box_from_pyramid.bottomRows<2>() << 0, 0, 1 / (1 - k), k / (1 - k), 0, 0, -1, 0;
  return {{"shear the centre of the window onto the axis", shear.matrix()},
          {"scale the sides to 45 degrees and far to z = -1", scale.matrix()},
          {"make the pyramid a box", box_from_pyramid}};
}

std::vector<NormalisingStep> parallel_steps(const ViewVolume& v) {
  const Window& w = v.window;
  const Pose move = translation({-(w.left + w.right) / 2, -(w.bottom + w.top) / 2, v.near_m});
  const Affine scale =
      scaling({2 / (w.right - w.left), 2 / (w.top - w.bottom), 1 / (v.far_m - v.near_m)});
  return {{"move the centre of the window to the origin", move.matrix()},
          {"scale the box to 2 x 2 x 1", scale.matrix()}};
}

// Throws Error unless an entry is what it must be, relative to the largest of the matrix.
void check_entry(const Matrix4d& m, int row, int column, double value) {
  if (std::abs(m(row, column) - value) <= 1e-12 * m.cwiseAbs().maxCoeff()) return;
  throw Error("OpenGL matrix: entry (" + std::to_string(row) + ", " + std::to_string(column) +
              ") must be " + internal::short_number(value) + ", got " +
              internal::short_number(m(row, column)));
}

void check_form(const Matrix4d& m, bool perspective) {
  const int centre = perspective ? 2 : 3;  // the column of the off-centre terms
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      if (row != column && column != centre && !(row == 2 && column > 1))
        check_entry(m, row, column, 0);
  for (int column = 0; column < 4; ++column)
    check_entry(m, 3, column, column != centre ? 0 : perspective ? -1 : 1);
  if (!(m(0, 0) > 0) || !(m(1, 1) > 0))
    throw Error("OpenGL matrix: entries (0, 0) and (1, 1) must be > 0");
  if (!(m(2, 3) < 0 || !perspective) || !(m(2, 2) < 0))
    throw Error("OpenGL matrix: near must be < far, depth growing from near to far");
}

// From the PHIGS depth, 0 to -1, to another one, before the division by w.
Matrix4d depth_from_phigs(CanonicalVolume canonical) {
  Matrix4d depth = Matrix4d::Identity();
  if (canonical == CanonicalVolume::opengl) depth.row(2) << 0, 0, -2, -1;
  if (canonical == CanonicalVolume::zero_to_one) depth.row(2) << 0, 0, -1, 0;
  if (canonical == CanonicalVolume::one_to_zero) depth.row(2) << 0, 0, 1, 1;
  return depth;
}

}  // namespace

ViewVolume symmetric_frustum(double vertical_field_of_view_rad, double aspect, double near_m,
                             double far_m) {
  if (!(vertical_field_of_view_rad > 0 && vertical_field_of_view_rad < std::numbers::pi))
    throw Error("frustum: the field of view must be between 0 and pi");
  const double top = near_m * std::tan(vertical_field_of_view_rad / 2);
  const ViewVolume volume{
      Projection::perspective, {-top * aspect, top * aspect, -top, top}, near_m, far_m};
  check(volume);
  return volume;
}

std::vector<Vector3d> corners(const ViewVolume& volume) {
  const Window& w = volume.window;
  std::vector<Vector3d> result;
  for (const double distance : {volume.near_m, volume.far_m}) {
    const double spread =
        volume.projection == Projection::perspective ? distance / volume.near_m : 1;
    for (const auto& [x, y] : {std::pair(w.left, w.bottom), std::pair(w.right, w.bottom),
                               std::pair(w.right, w.top), std::pair(w.left, w.top)})
      result.emplace_back(spread * x, spread * y, -distance);
  }
  return result;
}

std::vector<NormalisingStep> normalising_steps(const ViewVolume& volume,
                                               CanonicalVolume canonical) {
  check(volume);
  if (std::isinf(volume.far_m)) throw Error("view volume: the steps need a finite far");
  auto steps = volume.projection == Projection::perspective ? perspective_steps(volume)
                                                            : parallel_steps(volume);
  constexpr std::string_view kDepthNames[] = {"depth from [0, -1] to [-1, 1]", "",
                                              "depth from [0, -1] to [0, 1]",
                                              "depth from [0, -1] to [1, 0]"};
  if (canonical != CanonicalVolume::phigs)
    steps.push_back({kDepthNames[static_cast<int>(canonical)], depth_from_phigs(canonical)});
  return steps;
}

Matrix4d clip_from_eye(const ViewVolume& volume, CanonicalVolume canonical) {
  check(volume);
  const Window& w = volume.window;
  const bool perspective = volume.projection == Projection::perspective;
  const double n = volume.near_m;
  const double k = n / volume.far_m;  // 0 for far at infinity
  const double width = w.right - w.left, height = w.top - w.bottom;
  Matrix4d m = Matrix4d::Zero();
  if (perspective) {
    m(0, 0) = 2 * n / width;
    m(1, 1) = 2 * n / height;
    m(0, 2) = (w.right + w.left) / width;
    m(1, 2) = (w.top + w.bottom) / height;
    m.row(2) << 0, 0, 1 / (1 - k), n / (1 - k);
    m(3, 2) = -1;
  } else {
    const double depth = volume.far_m - n;
    m(0, 0) = 2 / width;
    m(1, 1) = 2 / height;
    m(0, 3) = -(w.right + w.left) / width;
    m(1, 3) = -(w.top + w.bottom) / height;
    m.row(2) << 0, 0, 1 / depth, n / depth;
    m(3, 3) = 1;
  }
  return depth_from_phigs(canonical) * m;
}

double phigs_depth(double z, double k) { return -(1 + k / z) / (1 - k); }

double z_from_phigs_depth(double depth, double k) { return -k / (1 + (1 - k) * depth); }

double opengl_depth(double z_in_eye_m, double near_m, double far_m) {
  const double k = near_m / far_m;
  return ((1 + k) + 2 * near_m / z_in_eye_m) / (1 - k);
}

double z_from_opengl_depth(double depth, double near_m, double far_m) {
  const double k = near_m / far_m;
  return -2 * near_m / ((1 + k) - depth * (1 - k));
}

double depth_resolution_m(double z_in_eye_m, double near_m, double far_m, int bits) {
  const double steps = std::exp2(bits) - 1;
  return z_in_eye_m * z_in_eye_m * (1 / near_m - 1 / far_m) / steps;
}

ViewVolume view_volume(const Camera& camera, double near_m, double far_m) {
  const LensKind& kind = kind_of(camera.lens);
  if (kind.reaches_behind)
    throw Error("view volume: a " + std::string(kind.name) + " lens has no frustum");
  const auto p = parameters(camera.lens);
  for (std::size_t i = 4; i < p.size(); ++i)
    if (p[i] != 0) throw Error("view volume: a lens with distortion has no frustum");
  const bool parallel = !kind.is_central;
  const double across = (parallel ? 1 : near_m) / p[0], down = (parallel ? 1 : near_m) / p[1];
  const ImageSize& size = camera.image_size;
  const ViewVolume volume{parallel ? Projection::parallel : Projection::perspective,
                          {-(p[2] + 0.5) * across, (size.width - 0.5 - p[2]) * across,
                           -(size.height - 0.5 - p[3]) * down, (p[3] + 0.5) * down},
                          near_m,
                          far_m};
  check(volume);
  return volume;
}

CameraFromMatrix camera_from_opengl(const Matrix4d& clip_from_eye, const ImageSize& size) {
  if (!clip_from_eye.allFinite()) throw Error("OpenGL matrix: all entries must be finite");
  const bool perspective = clip_from_eye(3, 2) != 0;
  const double scale = perspective ? -clip_from_eye(3, 2) : clip_from_eye(3, 3);
  if (!(scale > 0)) throw Error("OpenGL matrix: w must grow in front of the camera");
  const Matrix4d m = clip_from_eye / scale;
  check_form(m, perspective);
  const double sx = m(0, 0) * size.width / 2, sy = m(1, 1) * size.height / 2;
  const double right = perspective ? -m(0, 2) : m(0, 3);  // where the axis is, in NDC
  const double up = perspective ? -m(1, 2) : m(1, 3);
  const double cx = (1 + right) * size.width / 2 - 0.5, cy = (1 - up) * size.height / 2 - 0.5;
  const double c = m(2, 2), d = m(2, 3);
  if (!perspective) return {{Parallel({sx, sy, cx, cy}), size}, (d + 1) / c, (d - 1) / c};
  const double far = c < -1 ? d / (c + 1) : std::numeric_limits<double>::infinity();
  return {{pinhole(sx, sy, cx, cy), size}, d / (c - 1), far};
}

}  // namespace tagcal
