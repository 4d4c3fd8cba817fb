#include <gtest/gtest.h>

#include "batch_fixture.hpp"
#include "tagcal/estimate/pose/view_equations.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A view of n points in the domain of the lens, with noise and optional whitening.
struct SeenView {
  SeenView(const Lens& lens, std::size_t n, bool whitened, Random& random)
      : pose(exp_rotation({0.1, -0.2, 0.3}), {0.02, -0.05, 0.3}) {
    while (points.size() < n) {
      const Vector3d x(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3),
                       random.uniform(0.9, 1.2));
      const auto pixel = project(lens, pose * x);
      if (!pixel) continue;
      points.push_back(x);
      pixels.push_back(*pixel + Vector2d(random.normal(), random.normal()));
      Matrix2 w;
      w << random.uniform(0.5, 2), 0, random.uniform(-1, 1), random.uniform(0.5, 2);
      if (whitened) whitening.push_back(w);
    }
  }
  ViewPoints view() const { return {points, pixels, whitening}; }

  Pose pose;
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<Matrix2> whitening;
};

// [J | r]'[J | r] from the rows of the batch projection.
MatrixXd gram_of_rows(const Lens& lens, const SeenView& seen, std::span<const FreeParameter> free) {
  const Result batch = run(kPortableKernels, lens, seen.pose, seen.points, free, true);
  const auto k = static_cast<Eigen::Index>(free.size());
  MatrixXd gram = MatrixXd::Zero(7 + k, 7 + k);
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    MatrixXd rows(2, 7 + k);
    rows << batch.pose_rows(i), batch.parameter_rows(i), batch.pixels[i] - seen.pixels[i];
    if (!seen.whitening.empty()) rows = (seen.whitening[i] * rows).eval();
    gram += rows.transpose() * rows;
  }
  return gram;
}

MatrixXd gram_by(const ProjectKernels& kernels, const Lens& lens, const SeenView& seen,
                 std::span<const FreeParameter> free) {
  SumJob job;
  job.num_points = seen.points.size();
  job.points = seen.points.data()->data();
  job.pixels = seen.pixels.data()->data();
  job.whitening = seen.whitening.empty() ? nullptr : seen.whitening.data()->data();
  job.num_columns = static_cast<int>(free.size());
  const auto kind = set_lens(lens, set_columns(free, parameters(lens).size(), job.columns), job);
  Eigen::Map<RowMajor>(job.rotation, 3, 3) = seen.pose.rotation_matrix();
  Eigen::Map<Vector3d>(job.translation) = seen.pose.translation();
  std::vector<double> sums(19 * 20 / 2);
  job.sums = sums.data();
  EXPECT_TRUE(kernels.sums_with_parameters[kind](job));
  const Eigen::Index n = 7 + job.num_columns;
  MatrixXd gram(n, n);
  const double* sum = sums.data();
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) gram(i, j) = gram(j, i) = *sum++;
  return gram;
}

// Largest difference, relative to the lengths of the columns.
double difference(const MatrixXd& a, const MatrixXd& b) {
  const Eigen::VectorXd scale = b.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  return (scale.asDiagonal() * (a - b) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

TEST(ParameterSums, AreThoseOfTheRowsForEveryLensAndKernel) {
  Random random(1);
  const std::vector<Lens> lenses = {
      pinhole(800, 810, 640, 400),      random_lens<Perspective>(random),
      random_lens<Perspective>(random), random_lens<Perspective>(random),
      random_lens<Fisheye>(random),     random_lens<Parallel>(random)};
  for (const Lens& lens : lenses)
    for (const std::size_t n : {1, 2, 3, 4, 5, 7, 8, 9, 144})
      for (const bool whitened : {false, true}) {
        const SeenView seen(lens, n, whitened, random);
        const auto free = every_parameter(lens);
        const MatrixXd expected = gram_of_rows(lens, seen, free);
        for (const ProjectKernels* kernels : all_kernels())
          EXPECT_LT(difference(gram_by(*kernels, lens, seen, free), expected), 1e-11)
              << lens.index() << " " << n << " " << whitened;
        MatrixXd gram;
        ASSERT_TRUE(ParameterSums(seen.view(), free).at(lens, seen.pose, gram));
        EXPECT_LT(difference(gram.selfadjointView<Eigen::Upper>(), expected), 1e-11);
      }
}

TEST(ParameterSums, TiedParametersAreSummed) {
  Random random(2);
  const Lens lens = random_lens<Perspective>(random);
  const SeenView seen(lens, 30, false, random);
  for (const char* model :
       {"f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5", "opencv8"}) {
    const Model m = Model::named(model);
    EXPECT_LT(difference(gram_by(kPortableKernels, lens, seen, m.free()),
                         gram_of_rows(lens, seen, m.free())),
              1e-11)
        << model;
  }
}

// A target of another shape has its points displaced along its normal, and along its y axis.
TEST(ParameterSums, ShapesMovePoints) {
  Random random(4);
  for (const std::size_t n : {1, 4, 6, 11}) {
    for (const bool whitened : {false, true}) {
      const Lens lens = random_lens<Perspective>(random);
      SeenView seen(lens, n, whitened, random);
      const auto free = Model::named("radial1").free();
      std::vector<Eigen::Vector4d> shapes(n);
      for (Eigen::Vector4d& shape : shapes)
        for (double& s : shape) s = random.uniform(-1, 1);
      const Vector3d normal = Vector3d(0.3, -0.5, 0.7).normalized();
      const Vector3d across = Vector3d(0.5, 0.3, 0).normalized();
      MatrixXd gram, expected;
      ASSERT_TRUE(
          ParameterSums(seen.view(), free, {shapes, normal, across}).at(lens, seen.pose, gram));
      const SeenView flat = seen;
      const Eigen::Index k = 6 + static_cast<Eigen::Index>(free.size());
      ASSERT_EQ(gram.cols(), k + 5);
      // The last column is the gradient of half the cost, here by differences.
      for (int shape = 0; shape < 4; ++shape) {
        constexpr double kStep = 1e-6;
        double cost[2];
        for (const int side : {0, 1}) {
          for (std::size_t i = 0; i < n; ++i)
            seen.points[i] = flat.points[i] + (2 * side - 1) * kStep * shapes[i][shape] *
                                                  (shape == 3 ? across : normal);
          ASSERT_TRUE(ParameterSums(seen.view(), free).at(lens, seen.pose, expected));
          cost[side] = expected(k, k);
        }
        EXPECT_NEAR(gram(k + shape, k + 4), (cost[1] - cost[0]) / (4 * kStep),
                    1e-6 * std::sqrt(gram(k + shape, k + shape) * gram(k + 4, k + 4)));
      }
      ASSERT_TRUE(ParameterSums(flat.view(), free).at(lens, seen.pose, expected));
      EXPECT_LT(difference(MatrixXd(gram.topLeftCorner(k, k).selfadjointView<Eigen::Upper>()),
                           MatrixXd(expected.topLeftCorner(k, k).selfadjointView<Eigen::Upper>())),
                1e-11);
    }
  }
}

// The rows of a view: by its pose, by the parameters, and the residuals.
MatrixXd rows_of(const SeenView& seen, const Lens& lens, std::span<const FreeParameter> free) {
  const Result batch = run(kPortableKernels, lens, seen.pose, seen.points, free, true);
  MatrixXd rows(2 * std::ssize(seen.points), 7 + std::ssize(free));
  for (std::size_t i = 0; i < seen.points.size(); ++i)
    rows.middleRows(static_cast<Eigen::Index>(2 * i), 2) << batch.pose_rows(i),
        batch.parameter_rows(i), batch.pixels[i] - seen.pixels[i];
  return rows;
}

// The displacements of the pixels by the velocities of their rows.
MatrixXd displacements_by(const ViewRowTerms& terms, const SeenView& seen, const MatrixXd& rows) {
  MatrixXd by_rows = rows.leftCols<6>() * *terms.velocities;
  for (Eigen::Index at = 0; at < by_rows.rows(); ++at)
    by_rows.row(at) *= seen.pixels[static_cast<std::size_t>(at / 2)].y() - terms.middle_row;
  return by_rows;
}

// Row terms are correlated noise: the products are those with the inverse of its covariance.
TEST(ParameterSums, RowTermsAreCorrelatedNoise) {
  Random random(6);
  const ViewRowTerms rows{400, 0.003};
  for (const std::size_t n : {3, 4, 9, 30}) {
    const Lens lens = random_lens<Perspective>(random);
    const SeenView seen(lens, n, false, random);
    const auto free = Model::named("radial1").free();
    MatrixXd gram;
    ParameterSums sums(seen.view(), free, {}, rows);
    ASSERT_TRUE(sums.at(lens, seen.pose, gram));
    const MatrixXd all = rows_of(seen, lens, free);
    const Eigen::Index m = all.rows(), k = all.cols() - 1;
    MatrixXd shear = MatrixXd::Zero(m, 2);
    for (Eigen::Index at = 0; at < m; at += 2)
      shear(at, 0) = shear(at + 1, 1) =
          seen.pixels[static_cast<std::size_t>(at / 2)].y() - rows.middle_row;
    const MatrixXd covariance =
        MatrixXd::Identity(m, m) + rows.sigma * rows.sigma * shear * shear.transpose();
    const MatrixXd expected = all.transpose() * covariance.ldlt().solve(all);
    EXPECT_LT(difference(MatrixXd(gram.selfadjointView<Eigen::Upper>()), expected), 1e-9);
    // The best row terms are the posterior mean of the shear.
    const Eigen::Vector2d best =
        -rows.sigma * rows.sigma * shear.transpose() * covariance.ldlt().solve(all.col(k));
    EXPECT_LT((sums.row_terms().head<2>() - best).norm(), 1e-9 * (1 + best.norm()));
  }
}

// Velocities of the rows are, too: those by the pose times the row, about their start.
TEST(ParameterSums, VelocitiesOfTheRowsAreCorrelatedNoise) {
  Random random(7);
  ViewRowTerms rows{400, 0.003, Matrix6::Zero(), {}};
  for (double& velocity : rows.velocities->reshaped()) velocity = 0.001 * random.normal();
  for (double& start : rows.start) start = 0.002 * random.normal();
  for (const std::size_t n : {9, 30}) {
    const Lens lens = random_lens<Perspective>(random);
    const SeenView seen(lens, n, false, random);
    const auto free = Model::named("radial1").free();
    MatrixXd gram;
    ParameterSums sums(seen.view(), free, {}, rows);
    ASSERT_TRUE(sums.at(lens, seen.pose, gram));
    const MatrixXd all = rows_of(seen, lens, free);
    const Eigen::Index m = all.rows(), k = all.cols() - 1;
    const MatrixXd by_rows = displacements_by(rows, seen, all);
    // The residuals are those at the start; the prior is about zero.
    MatrixXd about_zero = all;
    about_zero.col(k) -= by_rows * rows.start;
    const MatrixXd covariance =
        MatrixXd::Identity(m, m) + rows.sigma * rows.sigma * by_rows * by_rows.transpose();
    const MatrixXd expected = about_zero.transpose() * covariance.ldlt().solve(about_zero);
    EXPECT_LT(difference(MatrixXd(gram.selfadjointView<Eigen::Upper>()), expected), 1e-9);
    const Vector6d best =
        -rows.sigma * rows.sigma * by_rows.transpose() * covariance.ldlt().solve(about_zero.col(k));
    EXPECT_LT((sums.row_terms() - best).norm(), 1e-9 * (1 + best.norm()));
  }
}

// With a weak prior, the velocities become one column, and the residuals those of none.
TEST(ParameterSums, AVelocityIsAColumn) {
  Random random(9);
  ViewRowTerms rows{400, 1e6, Matrix6::Zero(), {}};
  for (double& velocity : rows.velocities->reshaped()) velocity = 0.001 * random.normal();
  Vector6d terms;
  for (double& term : terms) term = random.normal();
  for (double& start : rows.start) start = 0.002 * random.normal();
  const Lens lens = random_lens<Perspective>(random);
  const SeenView seen(lens, 30, false, random);
  const auto free = Model::named("radial1").free();
  MatrixXd gram;
  ParameterSums sums(seen.view(), free, {}, rows);
  ASSERT_TRUE(sums.at(lens, seen.pose, gram));
  const MatrixXd still = rows_of(seen, lens, free), by_rows = displacements_by(rows, seen, still);
  const Eigen::Index k = still.cols() - 1;
  MatrixXd all(still.rows(), k + 2);
  all << still.leftCols(k), by_rows * terms, still.col(k) - by_rows * rows.start;
  EXPECT_LT(difference(sums.with_velocity(terms), MatrixXd(all.transpose() * all)), 1e-9);
}

// Fewer rows with the same products. A column that depends on others gives no row.
TEST(CompressedRows, HaveTheProductsOfTheRows) {
  Random random(5);
  MatrixXd rows(40, 6), r;
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows(i) = random.normal();
  rows.col(3) = 2 * rows.col(0) - rows.col(1);
  const MatrixXd gram = rows.transpose() * rows;
  compressed_rows(gram.triangularView<Eigen::Upper>(), 2, r);
  EXPECT_TRUE(r.bottomLeftCorner(4, 2).isZero(0));
  EXPECT_EQ((r.rowwise().squaredNorm().array() > 0).count(), 5);
  EXPECT_LT((r.transpose() * r - gram).norm(), 1e-12 * gram.norm());
}

// Columns that are nearly the same up to a millionth, as those of a rational lens are: the products
// with the residuals survive.
TEST(CompressedRows, KeepTheGradientOfNearlyDependentColumns) {
  Random random(6);
  for (int seed = 0; seed < 50; ++seed) {
    MatrixXd rows(200, 10), r;
    for (Eigen::Index i = 0; i < rows.size(); ++i) rows(i) = random.normal();
    rows.col(4) = rows.col(3) + 1e-5 * rows.col(4);
    rows.col(5) = rows.col(3) - rows.col(2) + 1e-6 * rows.col(5);
    rows.col(6) = rows.col(4) + rows.col(5) + 1e-9 * rows.col(6);
    const MatrixXd gram = rows.transpose() * rows;
    compressed_rows(gram, 2, r);
    EXPECT_LT((r.transpose() * r - gram).cwiseAbs().maxCoeff(), 1e-9 * gram.diagonal().maxCoeff())
        << seed;
  }
}

TEST(ParameterSums, NoneOutsideOfTheDomain) {
  Random random(3);
  const Lens lens = pinhole(800, 810, 640, 400);
  SeenView seen(lens, 9, false, random);
  seen.points[8].z() = -2;
  MatrixXd gram;
  EXPECT_FALSE(ParameterSums(seen.view(), Model::named("f").free()).at(lens, seen.pose, gram));
}

}  // namespace
}  // namespace tagcal
