#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "tagcal/solvers/numeric/quadrics.hpp"
#include "tagcal/solvers/numeric/real_roots.hpp"
#include "tagcal/solvers/p4pf.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The four points about their centroid in units of their size, and the gradients of their
// barycentric coordinates: the affine function with value v_k at point k has gradient sum_k v_k
// n_k.
struct Tetrahedron {
  std::array<Vector3d, 4> p, n;
  Vector3d centre;
  double size = 0;
};

bool set_tetrahedron(std::span<const Vector3d, 4> points, Tetrahedron& t) {
  double scale = 0, largest_coordinate = 0;
  for (int k = 0; k < 4; ++k) {
    t.p[k] = points[k] - points[0];
    scale = std::max(scale, t.p[k].cwiseAbs().maxCoeff());
    largest_coordinate = std::max(largest_coordinate, points[k].cwiseAbs().maxCoeff());
  }
  if (!(scale > 0 && 1 / scale > 0 && 1 / scale <= std::numeric_limits<double>::max()))
    return false;
  for (Vector3d& p : t.p) p /= scale;
  const Vector3d n1 = t.p[2].cross(t.p[3]), n2 = t.p[3].cross(t.p[1]), n3 = t.p[1].cross(t.p[2]);
  const double determinant = t.p[1].dot(n1);
  // The heights are 1 / |n|: none may be lost in the rounding of the coordinates.
  const double rounding =
      std::max(1e-7, 64 * std::numeric_limits<double>::epsilon() * largest_coordinate / scale);
  const double largest_area = std::sqrt(std::max(
      {n1.squaredNorm(), n2.squaredNorm(), n3.squaredNorm(), (n1 + n2 + n3).squaredNorm()}));
  if (!(std::abs(determinant) > rounding * largest_area)) return false;
  t.n = {-(n1 + n2 + n3) / determinant, n1 / determinant, n2 / determinant, n3 / determinant};
  const Vector3d mean = (t.p[1] + t.p[2] + t.p[3]) / 4;
  for (Vector3d& p : t.p) p -= mean;
  t.centre = points[0] + scale * mean;
  t.size = scale;
  return true;
}

// A vector that is an affine function of the three unknowns.
struct AffineVector {
  Vector3d c;
  Matrix3d m;

  Vector3d operator()(const Vector3d& xi) const { return c + m * xi; }
};

// The rows of the rotation to scale, in target axes: r1 and r2 to one scale, r3 to another.
struct Rows {
  Vector3d r1, r2, r3;
};

// With depth w (1 + r3 . p_k) of point k, its image times (1 + r3 . p_k) is affine in p_k, and the
// gradients of the two coordinates are r1 = g + G r3 and r2 = h + H r3. The unknowns xi are r3
// about the minimum of |r1|^2 + |r2|^2 + |r3|^2, which is that minimum plus |xi|^2, so that no
// digits are lost where the tetrahedron is thin (G, H large), far away or off the axis.
struct Problem {
  Tetrahedron shape;
  std::array<Vector2d, 4> pixels;  // in units of pixel_scale, the RMS distance from their mean
  double pixel_scale = 0;
  AffineVector r1, r2, r3;
};

// S with S S' = B^-1, upper triangular, for a positive definite B.
Matrix3d inverse_root(const Matrix3d& b) {
  const double s00 = 1 / std::sqrt(b(0, 0)), l10 = b(0, 1) * s00, l20 = b(0, 2) * s00;
  const double s11 = 1 / std::sqrt(b(1, 1) - l10 * l10), l21 = (b(1, 2) - l20 * l10) * s11;
  const double s22 = 1 / std::sqrt(b(2, 2) - l20 * l20 - l21 * l21);
  const double s01 = -s00 * l10 * s11, s12 = -s11 * l21 * s22;
  const double s02 = -s00 * (l10 * s12 + l20 * s22);
  Matrix3d s;
  s << s00, s01, s02, 0, s11, s12, 0, 0, s22;
  return s;
}

bool set_pixels(std::span<const Vector2d, 4> pixels, Problem& problem) {
  const Vector2d mean = (pixels[0] + pixels[1] + pixels[2] + pixels[3]) / 4;
  double sum = 0;
  for (const Vector2d& pixel : pixels) sum += (pixel - mean).squaredNorm();
  const double scale = std::sqrt(sum / 4);
  // The pixels differ by more than their rounding, and are finite.
  if (!(scale > 1e-100 && scale < 1e100 && mean.squaredNorm() < 1e12 * scale * scale)) return false;
  for (std::size_t k = 0; k < 4; ++k) problem.pixels[k] = pixels[k] / scale;
  problem.pixel_scale = scale;
  return true;
}

void set_unknowns(Problem& problem) {
  const Tetrahedron& t = problem.shape;
  Vector3d g = Vector3d::Zero(), h = Vector3d::Zero();
  Matrix3d G = Matrix3d::Zero(), H = Matrix3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d x = problem.pixels[k].x() * t.n[k], y = problem.pixels[k].y() * t.n[k];
    g += x;
    h += y;
    G += x * t.p[k].transpose();
    H += y * t.p[k].transpose();
  }
  const Matrix3d s = inverse_root(Matrix3d::Identity() + G.transpose() * G + H.transpose() * H);
  const Vector3d centre = s * (s.transpose() * -(G.transpose() * g + H.transpose() * h));
  problem.r3 = {centre, s};
  problem.r1 = {g + G * centre, G * s};
  problem.r2 = {h + H * centre, H * s};
}

// a . b
QuadricRow product(const AffineVector& a, const AffineVector& b) {
  const Matrix3d q = a.m.transpose() * b.m;
  const Vector3d linear = a.m.transpose() * b.c + b.m.transpose() * a.c;
  QuadricRow row;
  row << q(0, 0), q(1, 1), q(0, 1) + q(1, 0), q(0, 2) + q(2, 0), q(1, 2) + q(2, 1), linear[0],
      linear[1], q(2, 2), linear[2], a.c.dot(b.c);
  return row;
}

// r3 . r1 = r3 . r2 = r1 . r2 = |r1|^2 - |r2|^2 = 0
Quadrics quadrics_of(const Problem& m) {
  const AffineVector sum{m.r1.c + m.r2.c, m.r1.m + m.r2.m},
      difference{m.r1.c - m.r2.c, m.r1.m - m.r2.m};
  Quadrics q;
  q << product(m.r3, m.r1), product(m.r3, m.r2), product(m.r1, m.r2), product(sum, difference);
  return q;
}

struct Candidate {
  Vector3d xi;
  Rows rows;
  double error = 0;  // sum of squares of the three angles and the share
};

// Weights that turn the quadrics into angles: of the first two, of the last two.
Eigen::Vector4d weights_of(const Rows& rows) {
  const double scale = 2 / (rows.r1.squaredNorm() + rows.r2.squaredNorm());
  const double tilt = std::sqrt(scale / rows.r3.squaredNorm());
  return {tilt, tilt, scale, scale / 2};
}

Candidate candidate_at(const Problem& problem, const Vector3d& xi) {
  const Rows rows = {problem.r1(xi), problem.r2(xi), problem.r3(xi)};
  const auto& [r1, r2, r3] = rows;
  const Eigen::Vector4d e(r3.dot(r1), r3.dot(r2), r1.dot(r2), (r1 + r2).dot(r1 - r2));
  return {xi, rows, e.cwiseProduct(weights_of(rows)).squaredNorm()};
}

// True if every point is in front of the camera, and the rows are a right-handed triple.
bool in_front(const Problem& problem, const Rows& rows) {
  return rows.r1.cross(rows.r2).dot(rows.r3) > 0 &&
         std::all_of(problem.shape.p.begin(), problem.shape.p.end(),
                     [&rows](const Vector3d& p) { return 1 + rows.r3.dot(p) > 0; });
}

// Gauss-Newton on the four quadrics in the three unknowns, weighted at the start. Returns false if
// it does not converge.
bool polish(const Problem& problem, const Quadrics& quadrics, Candidate& candidate) {
  constexpr int kMaxSteps = 8;
  const Quadrics weighted = weights_of(candidate.rows).asDiagonal() * quadrics;
  Vector3d xi = candidate.xi;
  for (int i = 0; i < kMaxSteps; ++i) {
    const auto [step, error_before] = step_at(weighted, xi);
    xi -= step;
    if (!(step.squaredNorm() < 1e-14 + 1e-5 * error_before)) continue;
    candidate = candidate_at(problem, xi);
    return true;
  }
  return false;
}

PoseAndFocal pose_of(const Problem& problem, const Rows& rows) {
  const double n1 = rows.r1.norm(), n2 = rows.r2.norm(), n = (n1 + n2) / 2;
  // The nearest orthogonal pair has the same bisectors.
  const Vector3d a = (rows.r1 / n1 + rows.r2 / n2).normalized(),
                 b = (rows.r1 / n1 - rows.r2 / n2).normalized();
  Matrix3d r;
  r.row(0) = (a + b) * std::numbers::sqrt2 / 2;
  r.row(1) = (a - b) * std::numbers::sqrt2 / 2;
  r.row(2) = b.cross(a);
  const double focal = n / r.row(2).dot(rows.r3), depth = focal / n;
  Vector2d shift = Vector2d::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    shift += (1 + rows.r3.dot(problem.shape.p[k])) * problem.pixels[k];
  const Vector3d t(shift.x() / (4 * n), shift.y() / (4 * n), depth);
  const Eigen::Quaterniond rotation(r);
  const Pose turned(rotation, Vector3d::Zero());
  return {{rotation, problem.shape.size * t - turned * problem.shape.centre},
          focal * problem.pixel_scale};
}

// The range of the unknown z over all r3 that have every point in front: a tetrahedron with the
// corners 4 n_k.
std::pair<double, double> range_of_z(const Problem& problem) {
  const Matrix3d& m = problem.r3.m;
  Vector3d z_of_r3 = m.col(0).cross(m.col(1));
  z_of_r3 /= z_of_r3.dot(m.col(2));
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector3d& n : problem.shape.n) {
    const double z = z_of_r3.dot(4 * n - problem.r3.c);
    low = std::min(low, z);
    high = std::max(high, z);
  }
  return {low, high};
}

// Turns the unknowns by a rotation without symmetry.
void turn_unknowns(Problem& problem) {
  const Matrix3d turn = Eigen::Quaterniond(0.79, 0.23, -0.31, 0.47).normalized().matrix();
  for (AffineVector* r : {&problem.r1, &problem.r2, &problem.r3}) r->m *= turn;
}

// Condition of the elimination to a polynomial in z; poor in symmetric views.
enum class Reduction { failed, poor, good };

Reduction reduce(const Quadrics& quadrics, Resultant& resultant) {
  Quadrics reduced = quadrics;
  const double pivot = eliminate(reduced);
  if (!(pivot > 0)) return Reduction::failed;
  resultant = resultant_of(reduced);
  return pivot < 1e-3 || resultant.is_degenerate() ? Reduction::poor : Reduction::good;
}

// Adds a candidate in front of the camera; of two that are equal to 1 % the better one stays.
void add(const Problem& problem, const Candidate& candidate, Solutions<Candidate, 6>& found) {
  const auto better = [](const Candidate& a, const Candidate& b) { return a.error < b.error; };
  if (!(candidate.error < 1 && in_front(problem, candidate.rows))) return;
  Candidate* const same = std::find_if(found.begin(), found.end(), [&](const Candidate& other) {
    return (other.xi - candidate.xi).squaredNorm() < 1e-4 * (1 + candidate.xi.squaredNorm());
  });
  if (same == found.end())
    found.insert(candidate, better);
  else if (better(candidate, *same))
    *same = candidate;
}

}  // namespace

Solutions<PoseAndFocal, 6> p4pf(std::span<const Vector3d, 4> points,
                                std::span<const Vector2d, 4> pixels_from_centre) {
  Solutions<PoseAndFocal, 6> poses;
  Problem problem;
  if (!set_tetrahedron(points, problem.shape) || !set_pixels(pixels_from_centre, problem))
    return poses;
  set_unknowns(problem);
  Quadrics quadrics = quadrics_of(problem);
  Resultant resultant;
  if (reduce(quadrics, resultant) != Reduction::good) {
    turn_unknowns(problem);
    quadrics = quadrics_of(problem);
    if (reduce(quadrics, resultant) == Reduction::failed) return poses;
  }
  const auto [low, high] = range_of_z(problem);
  Solutions<Candidate, 6> found;
  for (const double z : real_roots(resultant.determinant, low, high, true)) {
    Vector3d xi;
    if (!unknowns_at(resultant, z, xi)) continue;
    Candidate candidate = candidate_at(problem, xi);
    add(problem, candidate, found);
    if (polish(problem, quadrics, candidate)) add(problem, candidate, found);
  }
  for (const Candidate& candidate : found) {
    const PoseAndFocal solution = pose_of(problem, candidate.rows);
    // Targets of enormous size overflow.
    const bool is_finite =
        solution.camera_from_target.translation().allFinite() && std::isfinite(solution.focal_px);
    if (is_finite && std::all_of(points.begin(), points.end(), [&solution](const Vector3d& p) {
          return (solution.camera_from_target * p).z() > 0;
        }))
      poses.push_back(solution);
  }
  return poses;
}

}  // namespace tagcal
