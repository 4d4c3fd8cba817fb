#include "tagcal/estimate/view_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <string>
#include <vector>

#include "batch_fixture.hpp"
#include "tagcal/estimate/small_cholesky.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A view with memory of its own, some pixels off.
struct Observed {
  Lens lens = centred_pinhole(900);
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<Matrix2> whitening;
  Pose pose;

  ViewPoints view() const { return {points, pixels, whitening}; }
};

Matrix2 random_whitening(Random& random) {
  Matrix2 w;
  w << random.normal(), random.normal(), random.normal(), random.normal();
  return w;
}

Observed observe(const Lens& lens, std::size_t n, bool whitened, Random& random) {
  Observed o{lens, {}, {}, {}, some_pose(random)};
  while (o.points.size() < n) {
    Vector3d x = std::visit([&](const auto& l) { return point_inside(l, random); }, lens);
    x.z() += 0.1 * x.norm();  // so that differences stay inside
    o.points.push_back(o.pose.inverse() * x);
    o.pixels.push_back(project(lens, x).value() + 3 * Vector2d(random.normal(), random.normal()));
    if (whitened) o.whitening.push_back(random_whitening(random));
  }
  return o;
}

Lens with_focal(const Lens& pinhole_lens, double focal_px) {
  const auto p = parameters(pinhole_lens);
  return pinhole(focal_px, focal_px, p[2], p[3]);
}

// Whitened residuals by the definition, one point after the other.
VectorXd residuals(const Observed& o, const Pose& pose, double focal_px) {
  const Lens lens = focal_px > 0 ? with_focal(o.lens, focal_px) : o.lens;
  VectorXd r(2 * o.points.size());
  for (std::size_t i = 0; i < o.points.size(); ++i) {
    Vector2d residual = project(lens, pose * o.points[i]).value() - o.pixels[i];
    if (!o.whitening.empty()) residual = o.whitening[i] * residual;
    r.segment<2>(2 * static_cast<Eigen::Index>(i)) = residual;
  }
  return r;
}

// Their Jacobian by (omega, tau, log f), by central differences.
MatrixXd differences(const Observed& o, const Pose& pose, double focal_px) {
  const Eigen::Index columns = focal_px > 0 ? 7 : 6;
  MatrixXd j(2 * o.points.size(), columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    constexpr double kStep = 1e-6;
    Vector6d step = Vector6d::Zero();
    double factor = 1;
    if (k < 6)
      step[k] = kStep;
    else
      factor = std::exp(kStep);
    j.col(k) = (residuals(o, retract(pose, step), focal_px * factor) -
                residuals(o, retract(pose, -step), focal_px / factor)) /
               (2 * kStep);
  }
  return j;
}

// The sums of any kernels, laid out as equations.
template <int N>
bool sums_by(const ProjectKernels& kernels, const Observed& o, double focal_px,
             NormalEquations<N>& equations) {
  SumJob job;
  const ProjectKernelKind kind = set_lens(o.lens, 0, job);
  double sums[36];
  job.num_points = o.points.size();
  job.points = o.points.data()->data();
  job.pixels = o.pixels.data()->data();
  job.whitening = o.whitening.empty() ? nullptr : o.whitening.data()->data();
  job.sums = sums;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(job.rotation) = o.pose.rotation_matrix();
  Eigen::Map<Vector3d>(job.translation) = o.pose.translation();
  if (N == 7) job.parameters[0] = job.parameters[1] = focal_px;
  if (!(N == 7 ? kernels.sums_pose_and_focal : kernels.sums_pose)[kind](job)) return false;
  const double* next = sums;
  equations.information.setZero();
  for (int i = 0; i < N; ++i) {
    for (int k = i; k < N; ++k) equations.information(i, k) = *next++;
    equations.gradient[i] = *next++;
  }
  equations.cost = *next;
  return true;
}

// Upper triangles, relative to the diagonal.
template <int N>
double difference(const NormalEquations<N>& a, const NormalEquations<N>& b) {
  double largest = std::abs(a.cost / b.cost - 1);
  for (int i = 0; i < N; ++i) {
    const double row = std::sqrt(b.information(i, i));
    largest = std::max(largest, std::abs(a.gradient[i] - b.gradient[i]) / row / std::sqrt(b.cost));
    for (int k = i; k < N; ++k)
      largest = std::max(largest, std::abs(a.information(i, k) - b.information(i, k)) / row /
                                      std::sqrt(b.information(k, k)));
  }
  return largest;
}

template <int N>
NormalEquations<N> by_differences(const Observed& o, double focal_px) {
  const MatrixXd j = differences(o, o.pose, focal_px);
  const VectorXd r = residuals(o, o.pose, focal_px);
  return {j.transpose() * j, j.transpose() * r, r.squaredNorm()};
}

std::vector<Lens> every_lens() {
  std::vector<Lens> all = lenses<Perspective>(1, 6);  // rational, Brown-Conrady and pinhole of each
  for (const Lens& lens : lenses<Fisheye>(2, 6)) all.push_back(lens);
  for (const Lens& lens : lenses<Parallel>(3, 6)) all.push_back(lens);
  return all;
}

TEST(ViewEquations, AreThoseOfDifferencesForEveryLens) {
  Random random(1);
  for (const Lens& lens : every_lens())
    for (std::size_t n = 1; n <= 9; ++n)
      for (const bool whitened : {false, true}) {
        const Observed o = observe(lens, n, whitened, random);
        NormalEquations<6> fast;
        ASSERT_TRUE(ViewSums(lens, o.view()).at(state_of(o.pose), fast));
        const auto slow = by_differences<6>(o, 0);
        if (std::holds_alternative<Parallel>(lens)) {  // its distance changes nothing
          EXPECT_EQ(fast.information(5, 5), 0);
          fast.information(5, 5) = 1;
          NormalEquations<6> known = slow;
          known.information(5, 5) = 1;
          EXPECT_LT(difference(fast, known), 1e-5) << lens.index() << " " << n << whitened;
          continue;
        }
        EXPECT_LT(difference(fast, slow), 1e-5) << lens.index() << " " << n << whitened;
      }
}

TEST(ViewEquations, TheFocalLengthIsTheSeventh) {
  Random random(2);
  for (int i = 0; i < 10; ++i)
    for (std::size_t n = 1; n <= 9; ++n) {
      const double focal = random.uniform(200, 3000);
      const Observed o = observe(centred_pinhole(focal), n, i % 2 == 0, random);
      // The lens of the sums has another one: the state's counts.
      NormalEquations<7> fast;
      ASSERT_TRUE(ViewSums(centred_pinhole(1), o.view()).at(state_of(o.pose, focal), fast));
      EXPECT_LT(difference(fast, by_differences<7>(o, focal)), 1e-5) << n;
      NormalEquations<6> pose_only;
      ASSERT_TRUE(ViewSums(o.lens, o.view()).at(state_of(o.pose), pose_only));
      EXPECT_LT((fast.gradient.head<6>() - pose_only.gradient).norm(),
                1e-9 * pose_only.gradient.norm());
    }
}

template <int N>
void expect_equal_kernels(const Observed& o, double focal_px, const char* what) {
  NormalEquations<N> portable, avx2;
  ASSERT_TRUE(sums_by<N>(kPortableKernels, o, focal_px, portable));
  if (!has_avx2()) return;
  ASSERT_TRUE(sums_by<N>(kAvx2Kernels, o, focal_px, avx2));
  for (NormalEquations<N>* e : {&portable, &avx2})
    if (e->information(5, 5) == 0) e->information(5, 5) = 1;
  // An ulp, times what a rational lens next to its pole makes of it.
  EXPECT_LT(difference(avx2, portable), 1e-10) << what << " " << o.points.size();
}

TEST(ViewEquations, AllKernelsAgree) {
  Random random(3);
  for (const Lens& lens : every_lens())
    for (std::size_t n = 1; n <= 9; ++n) {
      const Observed o = observe(lens, n, n % 2 == 0, random);
      expect_equal_kernels<6>(o, 0, "pose");
      if (lens.index() == 0)
        expect_equal_kernels<7>(observe(centred_pinhole(700), n, n % 2 == 0, random), 700, "focal");
    }
}

TEST(ViewEquations, OnePointOutsideIsEnoughForNone) {
  Random random(4);
  for (std::size_t n = 1; n <= 9; ++n)
    for (std::size_t bad = 0; bad < n; ++bad) {
      Observed o = observe(centred_pinhole(900), n, false, random);
      const Vector3d x = o.pose * o.points[bad];
      o.points[bad] = o.pose.inverse() * Vector3d(x.x(), x.y(), -x.z());
      NormalEquations<6> six;
      NormalEquations<7> seven;
      for (const ProjectKernels* kernels : all_kernels()) {
        EXPECT_FALSE(sums_by<6>(*kernels, o, 0, six)) << n << " " << bad;
        EXPECT_FALSE(sums_by<7>(*kernels, o, 900, seven)) << n << " " << bad;
      }
      ViewResiduals residual_lengths(o.lens, o.view());
      EXPECT_TRUE(std::isinf(residual_lengths.at(state_of(o.pose))[bad]));
    }
}

TEST(ViewEquations, ResidualsAddUpToTheCost) {
  Random random(5);
  for (const Lens& lens : every_lens()) {
    const Observed o = observe(lens, 7, true, random);
    ViewResiduals lengths(lens, o.view());
    const std::span<const double> squares = lengths.at(state_of(o.pose));
    const VectorXd r = residuals(o, o.pose, 0);
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_NEAR(squares[i], r.segment<2>(2 * static_cast<Eigen::Index>(i)).squaredNorm(),
                  1e-9 * r.squaredNorm());
  }
}

// Rows of units that differ by up to 1e12.
template <int N>
Eigen::Matrix<double, N, N> random_information(Random& random) {
  const MatrixXd rows = MatrixXd::NullaryExpr(3 * N, N, [&] { return random.normal(); });
  const VectorXd units =
      VectorXd::NullaryExpr(N, [&] { return std::pow(10.0, random.uniform(-6, 6)); });
  return units.asDiagonal() * rows.transpose() * rows * units.asDiagonal();
}

template <int N>
void expect_cholesky() {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    using Matrix = Eigen::Matrix<double, N, N>;
    const Matrix a = random_information<N>(random);
    SmallCholesky<N> cholesky;
    Matrix upper = a;
    upper.template triangularView<Eigen::StrictlyLower>().setConstant(
        std::numeric_limits<double>::quiet_NaN());
    ASSERT_TRUE(cholesky.compute(upper));
    const Eigen::Matrix<double, N, 1> x =
        Eigen::Matrix<double, N, 1>::NullaryExpr([&] { return random.normal(); });
    const Eigen::Matrix<double, N, 1> scale = a.diagonal().cwiseSqrt();
    const Eigen::Matrix<double, N, 1> b = a * x.cwiseQuotient(scale);
    EXPECT_LT((cholesky.solve(b).cwiseProduct(scale) - x).norm(), 1e-10 * x.norm());
    const Matrix inverse = cholesky.inverse();
    EXPECT_EQ(inverse, inverse.transpose());
    const Matrix one = scale.asDiagonal() * inverse * a * scale.cwiseInverse().asDiagonal();
    EXPECT_LT((one - Matrix::Identity()).norm(), 1e-9);
    const Matrix factor = cholesky.factor();
    const Matrix back = scale.cwiseInverse().asDiagonal() * (factor.transpose() * factor - a) *
                        scale.cwiseInverse().asDiagonal();
    EXPECT_LT(back.norm(), 1e-13);
    EXPECT_TRUE(factor.isUpperTriangular(0));

    Matrix negative = a;
    const auto k = static_cast<Eigen::Index>(random.index(N));
    negative(k, k) *= -1;
    EXPECT_FALSE(cholesky.compute(negative));
    Matrix singular = a;  // row and column k those of the next, in another unit
    const Eigen::Index next = (k + 1) % N;
    singular.row(k) = 3 * singular.row(next).eval();
    singular.col(k) = 3 * singular.col(next).eval();
    EXPECT_FALSE(cholesky.compute(singular));
    Matrix nan = a;
    nan(k, k) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(cholesky.compute(nan));
    EXPECT_FALSE(cholesky.compute(Matrix::Zero()));
  }
}

TEST(SmallCholesky, SolvesAndInvertsOrRefuses) {
  expect_cholesky<6>();
  expect_cholesky<7>();
  expect_cholesky<8>();
}

// Gauss-Newton on all rows, from next to the minimum: slow and plain.
struct Reference {
  Pose pose;
  double focal_px, cost;
};
Reference reference(const Observed& o, double focal_px) {
  Reference at{o.pose, focal_px, 0};
  for (int i = 0; i < 12; ++i) {
    const VectorXd step = differences(o, at.pose, at.focal_px)
                              .colPivHouseholderQr()
                              .solve(-residuals(o, at.pose, at.focal_px));
    at.pose = retract(at.pose, step.head<6>());
    if (focal_px > 0) at.focal_px *= std::exp(step[6]);
  }
  at.cost = residuals(o, at.pose, at.focal_px).squaredNorm();
  return at;
}

Observed world(const Lens& lens, const std::vector<Vector3d>& points, const Pose& pose,
               double sigma_px, Random& random) {
  Observed o{lens, {}, {}, {}, pose};
  for (const Correspondence& c : seen_by(lens, points, pose, sigma_px, random)) {
    o.points.push_back(c.point);
    o.pixels.push_back(c.pixel);
  }
  return o;
}

template <int N>
std::optional<ViewSolution<N>> solve_from(const Observed& o, const Pose& start, double focal_px,
                                          const ViewSolverOptions& options = {}) {
  ViewSums sums(o.lens, o.view());
  ViewStart<N> at{state_of(start, focal_px), {}};
  if (!sums.at(at.state, at.equations)) return std::nullopt;
  return solve_view<N>(sums, at, options);
}

// Up to so many radians and so much of the distance away.
Pose away(const Pose& pose, double angle, double share, Random& random) {
  Vector6d step;
  for (int k = 0; k < 6; ++k) step[k] = random.uniform(-1, 1);
  step.head<3>() *= angle;
  step.tail<3>() *= share * pose.translation().norm();
  return retract(pose, step);
}

TEST(SolveView, EndsAtTheMinimumOfADenseSolve) {
  Random random(7);
  const std::vector<Vector3d> space = points_in_box(10, 0.2, 1, random);
  for (const Lens& lens : {opencv5_lens(), fisheye_lens(), centred_pinhole(900)})
    for (const auto& points : {tag_points(0.3), board_points(), space})
      for (const double sigma : {0.0, 0.1, 1.0}) {
        const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.5, 0.9), 1, random);
        const Observed o = world(lens, points, pose, sigma, random);
        const Reference best = reference(o, 0);
        const auto found = solve_from<6>(o, away(pose, 0.05, 0.05, random), 0);
        ASSERT_TRUE(found && found->converged) << points.size() << " " << sigma;
        EXPECT_LT(angle_between_rad(pose_of(found->state), best.pose), 1e-4 * sigma + 1e-9);
        EXPECT_LT(distance_between_m(pose_of(found->state), best.pose), 1e-4 * sigma + 1e-9);
        EXPECT_NEAR(found->cost, best.cost, 1e-6 * best.cost + 1e-18);
        const MatrixXd j = differences(o, best.pose, 0);
        const Eigen::MatrixXd information = found->information.selfadjointView<Eigen::Upper>();
        EXPECT_LT((information - j.transpose() * j).norm(), 1e-3 * information.norm());
      }
}

TEST(SolveView, WithTheFocalLengthToo) {
  Random random(8);
  const std::vector<Vector3d> space = points_in_box(10, 0.3, 1, random);
  for (const auto& points : {tag_points(0.5), board_points(), space})
    for (const double sigma : {0.0, 0.1, 1.0}) {
      const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.6, 0.9), 1, random);
      const Observed o = world(centred_pinhole(900), points, pose, sigma, random);
      const Reference best = reference(o, 900);
      const auto found = solve_from<7>(o, away(pose, 0.03, 0.03, random), 870);
      ASSERT_TRUE(found && found->converged) << points.size() << " " << sigma;
      EXPECT_LT(angle_between_rad(pose_of(found->state), best.pose), 1e-4 * sigma + 1e-9);
      EXPECT_NEAR(found->state.focal_px / best.focal_px, 1, 1e-4 * sigma + 1e-9);
      EXPECT_NEAR(found->cost, best.cost, 1e-6 * best.cost + 1e-18);
    }
}

TEST(SolveView, ReachesTheMinimumFromFar) {
  Random random(9);
  int reached = 0, reached_with_focal = 0, started = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), random.uniform(0.3, 0.9), 1.2, random);
    const Observed o = world(centred_pinhole(900), board_points(), pose, 0.3, random);
    const Pose start = away(pose, 0.4, 0.2, random);
    const auto found = solve_from<6>(o, start, 0);
    if (!found) continue;
    ++started;
    reached += angle_between_rad(pose_of(found->state), pose) < 0.01 && found->converged;
    const auto focal = solve_from<7>(o, start, 900 * std::exp(random.uniform(-0.5, 0.5)));
    reached_with_focal +=
        focal && focal->converged && std::abs(std::log(focal->state.focal_px / 900)) < 0.2;
  }
  EXPECT_GT(started, 150);
  EXPECT_GE(reached, started * 98 / 100);
  EXPECT_GE(reached_with_focal, started * 95 / 100);
}

TEST(SolveView, SaysWhereItDidNotEnd) {
  Random random(10);
  const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1.2, random);
  const Observed o = world(centred_pinhole(900), board_points(), pose, 0.3, random);
  const Pose start = away(pose, 0.2, 0.1, random);
  for (const int iterations : {0, 1}) {
    const auto found = solve_from<6>(o, start, 0, {.max_iterations = iterations});
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->converged) << iterations;
    EXPECT_TRUE(found->state.rotation.allFinite());
  }
  EXPECT_TRUE(solve_from<6>(o, start, 0)->converged);
}

// A second hypothesis whose minimum lies above the limit is given up, one below it is not.
TEST(SolveView, RulesOutWhatLiesAboveTheLimit) {
  Random random(11);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1.2, random);
    const Observed o = world(centred_pinhole(900), board_points(), pose, 0.3, random);
    const double least = solve_from<6>(o, pose, 0)->cost;
    EXPECT_FALSE(solve_from<6>(o, pose, 0, {.ruled_out_cost = 0.8 * least}));
    EXPECT_TRUE(solve_from<6>(o, pose, 0, {.ruled_out_cost = 1.01 * least}));
  }
}

// Points that do not fix a pose leave a singular minimum, not NaN.
TEST(SolveView, SurvivesWhatFixesNothing) {
  Random random(12);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = looking_at_board(Vector3d::Zero(), 0.6, 1.2, random);
    const std::vector<Vector3d> points(i % 2 == 0 ? 1 : 5, Vector3d(0.1, 0.05, 0));
    const Observed o = world(centred_pinhole(900), points, pose, 0.3, random);
    const auto six = solve_from<6>(o, away(pose, 0.1, 0.1, random), 0);
    const auto seven = solve_from<7>(o, away(pose, 0.1, 0.1, random), 800);
    ASSERT_TRUE(six && seven);
    EXPECT_TRUE(six->state.rotation.allFinite() && six->state.translation.allFinite());
    EXPECT_TRUE(seven->state.rotation.allFinite() && seven->state.focal_px > 0);
    EXPECT_TRUE(std::isfinite(six->cost) && std::isfinite(seven->cost));
  }
}

}  // namespace
}  // namespace tagcal
