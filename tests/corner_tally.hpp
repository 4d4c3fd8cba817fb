#pragma once

// The errors of fitted corners over many tags.

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "tagcal/detect/refine.hpp"
#include "tagcal/random.hpp"

namespace tagcal {

using Corners = std::array<Eigen::Vector2d, 4>;

inline Corners moved(Corners corners, double px, Random& random) {
  for (Eigen::Vector2d& corner : corners)
    corner += Eigen::Vector2d(random.uniform(-px, px), random.uniform(-px, px));
  return corners;
}

// Fits to many tags, started up to 0.2 px off.
struct Trials {
  int failed = 0;
  double rms = 0;
  double predicted = 0;  // rms of the standard deviations
  double nees = 0;       // squared error in its covariance, over its dimension
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double outwards = 0;
};

class Tally {
 public:
  void add(const TagFit& fit, const Corners& truth) {
    if (fit.status != TagFitStatus::converged) {
      ++sums_.failed;
      return;
    }
    const Eigen::Vector2d centre = 0.25 * (truth[0] + truth[1] + truth[2] + truth[3]);
    Eigen::Matrix<double, 8, 1> error;
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d e = fit.corners[k] - truth[k];
      error.segment<2>(2 * static_cast<Eigen::Index>(k)) = e;
      sums_.mean += e / 4;
      sums_.outwards += e.dot((truth[k] - centre).normalized()) / 4;
    }
    sums_.rms += error.squaredNorm() / 8;
    sums_.predicted += fit.covariance_px2.trace() / 8;
    sums_.nees += error.dot(fit.covariance_px2.ldlt().solve(error)) / 8;
    ++num_;
  }

  Trials result() const {
    Trials result = sums_;
    result.rms = std::sqrt(result.rms / num_);
    result.predicted = std::sqrt(result.predicted / num_);
    result.nees /= num_;
    result.mean /= num_;
    result.outwards /= num_;
    return result;
  }

 private:
  Trials sums_;
  int num_ = 0;
};

}  // namespace tagcal
