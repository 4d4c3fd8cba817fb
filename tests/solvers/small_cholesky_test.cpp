#include "tagcal/solvers/numeric/small_cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "tagcal/random.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows whose units differ by up to 1e12.
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

    Matrix negative = a;
    const auto k = static_cast<Eigen::Index>(random.index(N));
    negative(k, k) *= -1;
    EXPECT_FALSE(cholesky.compute(negative));
    Matrix singular = a;  // row and column k are multiples of the next
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
  expect_cholesky<3>();
  expect_cholesky<6>();
  expect_cholesky<7>();
  expect_cholesky<8>();
}

}  // namespace
}  // namespace tagcal
