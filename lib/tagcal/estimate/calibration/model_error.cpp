#include "tagcal/estimate/calibration/model_error.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/pose_problem.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;

// Adds to `sum` in the order of the residuals, whatever parts they come in.
void add_chi_square(std::span<const Vector2d> residuals, std::span<const Matrix2> covariances,
                    double variance, double& sum) {
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Matrix2d all = covariances[i] + variance * Eigen::Matrix2d::Identity();
    sum += residuals[i].dot(all.inverse() * residuals[i]);
  }
}

// Residuals and covariances of the corners, part by part.
using Corners = std::function<void(
    const std::function<void(std::span<const Vector2d>, std::span<const Matrix2>)>& part)>;

double excess_px(const Corners& corners, double degrees_of_freedom) {
  const auto chi_square = [&](double variance) {
    double sum = 0;
    corners([&](auto residuals, auto covariances) {
      add_chi_square(residuals, covariances, variance, sum);
    });
    return sum;
  };
  if (!(degrees_of_freedom > 0)) return 0;
  const double at_zero = chi_square(0);
  if (at_zero < (1 + policy::kNoiseChange) * degrees_of_freedom ||
      at_zero < chi_square_quantile(degrees_of_freedom, policy::kSignificant))
    return 0;
  double high = 0;  // upper bound: the model error makes all of the residuals
  corners([&](auto residuals, auto) {
    for (const Vector2d& r : residuals) high += r.squaredNorm() / degrees_of_freedom;
  });
  double low = 0;
  while (high - low > 1e-6 * high) {  // numeric: precision of the bisection
    const double middle = (low + high) / 2;
    const bool is_too_low = chi_square(middle) > degrees_of_freedom;
    (is_too_low ? low : high) = middle;
  }
  return std::sqrt(high);
}

}  // namespace

Matrix2 covariance_of(const Matrix2& whitening) {
  const Eigen::Matrix2d information = whitening.transpose() * whitening;
  return information.inverse();
}

double excess_px(std::span<const Vector2d> residuals_px, std::span<const Matrix2> covariance_px2,
                 double degrees_of_freedom) {
  return excess_px([&](const auto& part) { part(residuals_px, covariance_px2); },
                   degrees_of_freedom);
}

bool update_model_error(CalibrationInput& input, const CalibrationFit& fit) {
  const double freedom = degrees_of_freedom(fit.bundle);
  if (!input.whitened || !(freedom > 0)) return false;
  const double before = input.model_error_px * input.model_error_px;
  const Lens lens = fit.bundle.lens();
  // View by view, because the arrays of all views would be much of the memory.
  const auto corners = [&](const auto& part) {
    std::vector<Matrix2> covariances;
    ViewProblem buffer;
    for (std::size_t v = 0; v < fit.bundle.views.size(); ++v) {
      const ViewProblem& view = fit.bundle.corrected(v, buffer);
      covariances.clear();
      for (const Matrix2& whitening : view.whitening)
        covariances.push_back(covariance_of(whitening) - before * Matrix2::Identity());
      part(residuals_px(view.correspondences, lens, fit.bundle.camera_from_target[v]), covariances);
    }
  };
  const double excess = excess_px(corners, freedom);
  if (std::abs(excess - input.model_error_px) <= policy::kNoiseChange * excess) return false;
  for (CalibrationView& view : input.views)
    for (Matrix2& whitening : view.problem.whitening.own())
      whitening =
          whitening_of(covariance_of(whitening) + (excess * excess - before) * Matrix2::Identity());
  input.model_error_px = excess;
  return true;
}

}  // namespace tagcal::internal
