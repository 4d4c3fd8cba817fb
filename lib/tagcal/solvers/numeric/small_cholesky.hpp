#pragma once

#include <Eigen/Core>

namespace tagcal::internal {

// Cholesky decomposition without square roots of a small symmetric matrix, A = U' D U with a unit
// upper triangular U. Unrolled, a few times faster than one of variable size.
template <int N>
class SmallCholesky {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  // Reads the upper triangle. False unless A is positive definite beyond rounding, independent of
  // the units of its rows.
  bool compute(const Matrix& a) {
    constexpr double kRounding = 1e-15;
    bool positive = true;
    double scaled[N][N];  // D U
#pragma GCC unroll 8
    for (int i = 0; i < N; ++i) {
      double pivot = a(i, i);
#pragma GCC unroll 8
      for (int k = 0; k < i; ++k) pivot -= u_[k][i] * scaled[k][i];
      positive &= pivot > kRounding * a(i, i);
      inverse_pivot_[i] = 1 / pivot;
#pragma GCC unroll 8
      for (int j = i + 1; j < N; ++j) {
        double sum = a(i, j);
#pragma GCC unroll 8
        for (int k = 0; k < i; ++k) sum -= u_[k][i] * scaled[k][j];
        scaled[i][j] = sum;
        u_[i][j] = sum * inverse_pivot_[i];
      }
    }
    return positive;
  }

  Vector solve(Vector b) const {
#pragma GCC unroll 8
    for (int i = 1; i < N; ++i)
#pragma GCC unroll 8
      for (int k = 0; k < i; ++k) b[i] -= u_[k][i] * b[k];
    b.array() *= Eigen::Map<const Vector>(inverse_pivot_).array();
#pragma GCC unroll 8
    for (int i = N - 2; i >= 0; --i)
#pragma GCC unroll 8
      for (int k = i + 1; k < N; ++k) b[i] -= u_[i][k] * b[k];
    return b;
  }

  // A^-1 = U^-1 D^-1 U'^-1
  Matrix inverse() const {
    double v[N][N];  // U^-1
#pragma GCC unroll 8
    for (int j = 1; j < N; ++j)
#pragma GCC unroll 8
      for (int i = j - 1; i >= 0; --i) {
        double sum = u_[i][j];
#pragma GCC unroll 8
        for (int k = i + 1; k < j; ++k) sum += u_[i][k] * v[k][j];
        v[i][j] = -sum;
      }
    Matrix result;
#pragma GCC unroll 8
    for (int j = 0; j < N; ++j)
#pragma GCC unroll 8
      for (int i = 0; i <= j; ++i) {
        double sum = i == j ? inverse_pivot_[j] : v[i][j] * inverse_pivot_[j];
#pragma GCC unroll 8
        for (int k = j + 1; k < N; ++k) sum += v[i][k] * v[j][k] * inverse_pivot_[k];
        result(i, j) = result(j, i) = sum;
      }
    return result;
  }

 private:
  double u_[N][N];  // above the diagonal
  double inverse_pivot_[N];
};

}  // namespace tagcal::internal
