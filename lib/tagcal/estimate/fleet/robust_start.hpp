#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "tagcal/estimate/fleet.hpp"

namespace tagcal::internal {

using Eigen::MatrixXd;
using Eigen::VectorXd;

inline VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// Its name, or "quantity 3".
std::string quantity_name(std::size_t quantity, std::span<const std::string> names);

// The units that take part, in units of the robust scale of each quantity about its median.
struct ScaledUnits {
  VectorXd middle, unit;
  MatrixXd values;  // a column each
  std::vector<MatrixXd> covariances;

  Eigen::Index size() const { return values.cols(); }
  Eigen::Index num_quantities() const { return values.rows(); }
};

struct Normal {
  VectorXd mean;
  MatrixXd scatter;
};

// At most kMostUsedUnits of the units. The scale of a quantity is the spread of the values or,
// where that is less, the usual own standard deviation. Throws Error if both are zero.
ScaledUnits scaled(std::span<const UnitValues> units, std::span<const std::string> names);

// The squared distance within which units take part: chi-square of p quantities at p = 0.001.
double used_bound(Eigen::Index p);

// The factor by which that truncation lessens a covariance.
double truncation_factor(Eigen::Index p);

// The moments of the units within the ellipsoid of the robust start, the own covariances removed.
Normal start_of(const ScaledUnits& units);

}  // namespace tagcal::internal
