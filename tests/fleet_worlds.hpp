#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "tagcal/estimate/fleet.hpp"
#include "tagcal/random.hpp"

// Random fleets, whose quantities have different units and are correlated.

namespace tagcal {

inline Eigen::MatrixXd random_covariance(Random& random, Eigen::Index p) {
  Eigen::MatrixXd half(p, p + 2);
  for (double& value : half.reshaped()) value = random.normal();
  return half * half.transpose() / static_cast<double>(p + 2);
}

inline Eigen::VectorXd normal_of(Random& random, const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd z(covariance.rows());
  for (double& value : z) value = random.normal();
  return Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL() * z;
}

// Units of a normal population, each with an own covariance of its own size.
struct FleetWorld {
  Eigen::VectorXd unit;  // of each quantity, from 10 to 1e-5
  Eigen::VectorXd centre;
  Eigen::MatrixXd scatter;  // T
  std::vector<UnitValues> units;

  // `own`: the usual variance of a unit over that of the population.
  FleetWorld(Random& random, Eigen::Index p, std::size_t n, double own) : unit(p), centre(p) {
    for (Eigen::Index j = 0; j < p; ++j)
      unit(j) = std::pow(10.0, 1.0 - 1.5 * static_cast<double>(j % 5));
    centre = 50 * unit;
    scatter = unit.asDiagonal() * random_covariance(random, p) * unit.asDiagonal();
    for (std::size_t i = 0; i < n; ++i) {
      const double size = own * std::exp(0.7 * random.normal());
      const Eigen::MatrixXd covariance =
          size * (unit.asDiagonal() * random_covariance(random, p) * unit.asDiagonal());
      const Eigen::VectorXd values =
          centre + normal_of(random, scatter) + normal_of(random, covariance);
      units.push_back({{values.begin(), values.end()}, covariance});
    }
  }

  // Standard deviation of a quantity of a unit.
  double sigma(std::size_t i, std::size_t j) const {
    const auto at = static_cast<Eigen::Index>(j);
    return std::sqrt(scatter(at, at) + units[i].covariance(at, at));
  }
};

// One unit in eight is of another lot, which is far away.
inline std::vector<UnitValues> two_lots() {
  Random random(5);
  std::vector<UnitValues> units = FleetWorld(random, 2, 300, 0.1).units;
  for (std::size_t i = 0; i < units.size(); i += 8) units[i].values[0] += 200;
  return units;
}

// Units that are all the same, but for the errors of their calibrations.
inline std::vector<UnitValues> equal_units(std::uint64_t seed, std::size_t n = 400) {
  Random random(seed);
  std::vector<UnitValues> units = FleetWorld(random, 3, n, 1).units;
  for (UnitValues& unit : units) {
    const Eigen::VectorXd values = normal_of(random, unit.covariance);
    unit.values.assign(values.begin(), values.end());
  }
  return units;
}

}  // namespace tagcal
