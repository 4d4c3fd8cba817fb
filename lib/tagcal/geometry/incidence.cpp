#include "tagcal/geometry/transform.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "tagcal/error.hpp"
#include "tagcal/internal/finite.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

// Sine below which directions count as dependent: far above rounding, far below any real angle.
constexpr double kDependent = 1e-12;

// The vector whose products with a, b and c are 0: the signed minors of the matrix of the three.
Vector4d orthogonal_to(const Vector4d& a, const Vector4d& b, const Vector4d& c, const char* what) {
  Matrix4d rows = Matrix4d::Zero();
  rows << a.normalized().transpose(), b.normalized().transpose(), c.normalized().transpose(),
      Eigen::RowVector4d::Zero();
  require_finite(rows, what);
  const Vector4d minors = cofactor_matrix(rows).row(3);
  if (!(minors.norm() > kDependent))
    throw Error(std::string(what) + ": the three do not determine one");
  return minors.normalized();
}

// The map that takes the four unit vectors and their sum to five points.
Matrix4d map_of_basis(const FivePoints& points) {
  Matrix4d basis;
  for (int i = 0; i < 4; ++i) basis.col(i) = points[static_cast<std::size_t>(i)].normalized();
  require_finite(basis, "projective map");
  const Eigen::FullPivLU<Matrix4d> lu(basis);
  const Vector4d weights = lu.solve(points[4].normalized());
  if (!(std::abs(lu.determinant()) > kDependent) ||
      !(weights.cwiseAbs().minCoeff() > kDependent * weights.cwiseAbs().maxCoeff()))
    throw Error("projective map: four of the points are in a plane");
  return basis * weights.asDiagonal();
}

Matrix3d checked_inverse(const Matrix3d& matrix) {
  require_finite(matrix, "projective map");
  const Eigen::FullPivLU<Matrix3d> lu(matrix);
  if (!lu.isInvertible()) throw Error("projective map: it has no inverse");
  return lu.inverse();
}

}  // namespace

Vector4d join(const Vector4d& a, const Vector4d& b, const Vector4d& c) {
  return orthogonal_to(a, b, c, "plane through three points");
}

Vector4d meet(const Vector4d& p, const Vector4d& q, const Vector4d& r) {
  return orthogonal_to(p, q, r, "point of three planes");
}

Line meet(const Vector4d& p, const Vector4d& q) {
  const Vector3d along = p.head<3>().normalized().cross(q.head<3>().normalized());
  require_finite(along, "line of two planes");
  if (!(along.norm() > kDependent)) throw Error("line of two planes: they are parallel");
  // The point of the line that is also in the plane across it through the origin.
  Vector4d across;
  across << along.normalized(), 0;
  const Vector3d nearest = meet(p, q, across).hnormalized();
  return {nearest, nearest + along.normalized()};
}

Vector4d join(const Line& line, const Vector4d& point) {
  return join(line.a.homogeneous(), line.b.homogeneous(), point);
}

Vector4d meet(const Line& line, const Vector4d& plane) {
  const Vector4d a = line.a.homogeneous(), b = line.b.homogeneous();
  const Vector4d point = plane.dot(b) * a - plane.dot(a) * b;
  require_finite(point, "point of a line and a plane");
  if (!(point.norm() > kDependent * plane.norm() * a.norm() * b.norm()))
    throw Error("point of a line and a plane: the line lies in the plane");
  return point.normalized();
}

std::optional<LineInPlane> meeting(const Line& line, const Vector3d& w, const Vector3d& u,
                                   const Vector3d& v) {
  Matrix3d columns;
  columns << line.a - line.b, u, v;
  require_finite(columns, "line and plane");
  const double size = columns.colwise().norm().prod();
  if (!(std::abs(columns.determinant()) > kDependent * size)) return std::nullopt;
  const Vector3d x = columns.inverse() * (line.a - w);
  return LineInPlane{x[0], x[1], x[2]};
}

Matrix4d projective_map(const FivePoints& source, const FivePoints& target) {
  const Matrix4d map = map_of_basis(target) * map_of_basis(source).inverse();
  return map / map.norm();
}

Matrix3d conic(double a, double b, double c, double d, double e, double f) {
  Matrix3d matrix;
  matrix << a, b / 2, d / 2, b / 2, c, e / 2, d / 2, e / 2, f;
  return matrix;
}

Vector3d transformed_line(const Matrix3d& target_from_source, const Vector3d& line_in_source) {
  return checked_inverse(target_from_source).transpose() * line_in_source;
}

Matrix3d transformed_conic(const Matrix3d& target_from_source, const Matrix3d& conic_in_source) {
  const Matrix3d inverse = checked_inverse(target_from_source);
  return inverse.transpose() * conic_in_source * inverse;
}

Vector4d plane_of_image_line(const Projection34& projection, const Vector3d& line) {
  return projection.transpose() * line;
}

Matrix4d cone_of_image_conic(const Projection34& projection, const Matrix3d& conic) {
  return projection.transpose() * conic * projection;
}

}  // namespace tagcal
