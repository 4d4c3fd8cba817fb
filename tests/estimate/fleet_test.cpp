#include "tagcal/estimate/fleet.hpp"

#include <gtest/gtest.h>

#include <set>

#include "finding_cases.hpp"
#include "fleet_worlds.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

std::set<std::string> codes(const Population& population) { return codes_of(population.findings); }

struct Counts {
  int num_units = 0, num_false = 0;  // beyond p = 0.001
  int num_far = 0, num_found = 0;    // 8 standard deviations off in one quantity

  double per_mille() const { return 1000.0 * num_false / num_units; }
  double found() const { return 100.0 * num_found / num_far; }
};

// Of populations of 1 to 8 quantities with own variances from a twentieth to ten times the scatter;
// one unit in fifty, or one, is far. `size`: the number of units for so many quantities.
Counts counted(std::uint64_t num_worlds, const std::function<std::size_t(std::size_t)>& size) {
  Counts counts;
  for (const double own : {0.05, 1.0, 10.0}) {
    for (std::uint64_t seed = 0; seed < num_worlds; ++seed) {
      Random random(71, seed);
      const std::size_t p = 1 + seed % 8;
      FleetWorld world(random, static_cast<Eigen::Index>(p), size(p), own);
      for (std::size_t i = 0; i < world.units.size(); i += 50)
        world.units[i].values[i % p] += (i % 4 == 0 ? 8 : -8) * world.sigma(i, i % p);
      const Population population = estimate_population(world.units);
      EXPECT_EQ(population.status, Status::ok);
      for (std::size_t i = 0; i < world.units.size(); ++i) {
        const bool is_outlying = unit_distance(population, world.units[i]).p_value < 1e-3;
        ++(i % 50 == 0 ? counts.num_far : counts.num_units);
        if (is_outlying) ++(i % 50 == 0 ? counts.num_found : counts.num_false);
      }
    }
  }
  std::printf("%.2f per mille of %d are false, %.1f %% of %d found\n", counts.per_mille(),
              counts.num_units, counts.found(), counts.num_far);
  return counts;
}

TEST(Fleet, OneUnitInAThousandIsFalselyOutlying) {
  const Counts counts = counted(16, [](std::size_t) { return 1000; });
  EXPECT_GT(counts.per_mille(), 0.5);
  EXPECT_LT(counts.per_mille(), 1.5);
  EXPECT_GE(counts.found(), 99);
}

// Of the smallest fleets that are judged.
TEST(Fleet, FewUnitsAreNoMoreOftenFalse) {
  const Counts counts = counted(200, [](std::size_t p) { return 20 + 5 * p; });
  EXPECT_LT(counts.per_mille(), 2);
  EXPECT_GE(counts.found(), 90);
}

TEST(Fleet, CentreAndSpreadHaveTheirStandardDeviations) {
  double centre = 0, spread = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(72, seed);
    const FleetWorld world(random, 4, 300, seed % 2 == 0 ? 0.2 : 2);
    const Population population = estimate_population(world.units);
    for (std::size_t j = 0; j < 4; ++j, ++count) {
      const auto at = static_cast<Eigen::Index>(j);
      centre += std::pow(population.centre[j] - world.centre(at), 2) /
                population.centre_covariance(at, at);
      spread += std::pow(
          (population.spread[j] - std::sqrt(world.scatter(at, at))) / population.sigma_spread[j],
          2);
    }
  }
  EXPECT_NEAR(std::sqrt(centre / count), 1, 0.2);
  EXPECT_NEAR(std::sqrt(spread / count), 1, 0.25);
}

// The median and the spread without robustness are off by more than 100 %.
TEST(Fleet, AQuarterOfOtherUnitsDoesNotChangeIt) {
  Random random(73);
  FleetWorld world(random, 4, 800, 0.3);
  for (std::size_t i = 0; i < world.units.size(); i += 4)
    for (std::size_t j = 0; j < 4; ++j) world.units[i].values[j] += 40 * world.sigma(i, j);
  const Population population = estimate_population(world.units);
  for (std::size_t j = 0; j < 4; ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    EXPECT_NEAR(population.spread[j] / std::sqrt(world.scatter(at, at)), 1, 0.15);
  }
  EXPECT_EQ(codes(population), std::set<std::string>{"population_mixed"});
}

TEST(Fleet, TheOwnUncertaintyIsNoSpread) {
  int num_false = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const std::vector<UnitValues> units = equal_units(seed);
    const Population population = estimate_population(units);
    EXPECT_TRUE(codes(population).contains("spread_unresolved"));
    for (std::size_t j = 0; j < 3; ++j) {
      std::vector<double> own;
      for (const UnitValues& unit : units) {
        const auto at = static_cast<Eigen::Index>(j);
        own.push_back(std::sqrt(unit.covariance(at, at)));
      }
      std::ranges::nth_element(own, own.begin() + 200);
      EXPECT_LT(population.spread[j], 0.5 * own[200]);
    }
    for (const UnitValues& unit : units)
      num_false += unit_distance(population, unit).p_value < 1e-3;
  }
  EXPECT_LE(num_false, 12);  // of 4000
}

TEST(Fleet, SaysWhichQuantityDeviates) {
  Random random(74);
  FleetWorld world(random, 3, 200, 0.5);
  world.units[7].values[2] -= 12 * world.sigma(7, 2);
  const UnitDistance distance = unit_distance(estimate_population(world.units), world.units[7]);
  EXPECT_EQ(distance.quantity, 2u);
  EXPECT_NEAR(distance.in_sigmas, -12, 3.5);
  EXPECT_LT(distance.p_value, 1e-9);
}

TEST(Fleet, RefusesFewUnitsAndNamesQuantities) {
  Random random(75);
  const FleetWorld world(random, 2, 29, 1);
  const Population few = estimate_population(world.units);
  EXPECT_EQ(few.status, Status::not_observable);
  EXPECT_EQ(codes(few), std::set<std::string>{"few_units"});
  EXPECT_TRUE(few.centre.empty());
  const std::vector<std::string> names = {"fx", "k1", "k2"};
  const Population equal = estimate_population(equal_units(3), names);
  EXPECT_NE(equal.findings.back().sentence.find("k1"), std::string::npos);
}

TEST(Fleet, RefusesUnitsThatCannotBeCompared) {
  const std::vector<UnitValues> good = equal_units(1, 40);
  const auto expect_error = [&](const std::function<void(std::vector<UnitValues>&)>& spoil,
                                const std::string& part) {
    std::vector<UnitValues> units = good;
    spoil(units);
    try {
      estimate_population(units);
      ADD_FAILURE() << part;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  expect_error([](auto& units) { units[3].values.pop_back(); }, "unit 3: must have 3 values");
  expect_error([](auto& units) { units[3].covariance.resize(2, 2); }, "unit 3");
  expect_error([](auto& units) { units[9].values[1] = std::nan(""); }, "unit 9: must have finite");
  expect_error([](auto& units) { units[2].covariance(1, 1) = -1; }, "variances from 0");
  expect_error(
      [](auto& units) {
        for (UnitValues& unit : units) {
          unit.values[1] = 4;
          unit.covariance.row(1).setZero();
          unit.covariance.col(1).setZero();
        }
      },
      "quantity 1: the units neither differ");
}

// Calibrations of one unit at some days and temperatures.
std::vector<UnitValues> repeated(Random& random, const MatrixX& covariates,
                                 const Eigen::MatrixXd& slopes, double excess = 1) {
  std::vector<UnitValues> calibrations;
  for (Eigen::Index k = 0; k < covariates.rows(); ++k) {
    const Eigen::MatrixXd covariance = random_covariance(random, slopes.rows());
    const Eigen::VectorXd values =
        slopes * covariates.row(k).transpose() + std::sqrt(excess) * normal_of(random, covariance);
    calibrations.push_back({{values.begin(), values.end()}, covariance});
  }
  return calibrations;
}

MatrixX days_and_degrees(Random& random, Eigen::Index count) {
  MatrixX covariates(count, 2);
  for (Eigen::Index k = 0; k < count; ++k)
    covariates.row(k) << 20000 + 30.0 * static_cast<double>(k), random.uniform(-10, 50);
  return covariates;
}

TEST(FleetTrend, SlopesHaveTheirStandardDeviationsAndProbabilities) {
  double z = 0;
  int count = 0, false_days = 0, false_scatter = 0, num_missed = 0;
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(3, 2);
  slopes.col(1) << 0.5, -0.2, 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Random random(81, seed);
    const MatrixX covariates = days_and_degrees(random, 6);
    const auto trend = estimate_trend(repeated(random, covariates, slopes), covariates);
    ASSERT_TRUE(trend);
    EXPECT_EQ(trend->scatter_freedom, 9);
    for (Eigen::Index j = 0; j < 3; ++j, ++count)
      z += std::pow((trend->slopes(j, 1) - slopes(j, 1)) / trend->sigmas(j, 1), 2);
    false_days += *trend_p_value(*trend, 0) < 0.01;
    false_scatter += *trend_p_value(*trend, std::nullopt) < 0.01;
    num_missed += *trend_p_value(*trend, 1) > 1e-4;  // where the temperatures hardly differ
  }
  EXPECT_NEAR(std::sqrt(z / count), 1, 0.06);
  EXPECT_LE(false_days, 20);
  EXPECT_GE(false_days, 3);
  EXPECT_LE(false_scatter, 20);
  EXPECT_GE(false_scatter, 3);
  EXPECT_LE(num_missed, 10);
}

TEST(FleetTrend, TwoCalibrationsHaveASlopeAndNoScatter) {
  Random random(82);
  const MatrixX days = days_and_degrees(random, 2).leftCols(1);
  const auto trend =
      estimate_trend(repeated(random, days, Eigen::MatrixXd::Constant(2, 1, 1)), days);
  ASSERT_TRUE(trend);
  EXPECT_EQ(trend->scatter_freedom, 0);
  EXPECT_FALSE(trend_p_value(*trend, std::nullopt));
  EXPECT_LT(*trend_p_value(*trend, 0), 1e-9);
}

TEST(FleetTrend, HasNoValueWhereCovariatesDetermineNoSlope) {
  Random random(83);
  MatrixX covariates = days_and_degrees(random, 4);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(2, 2);
  const std::vector<UnitValues> calibrations = repeated(random, covariates, none);
  covariates.col(1) = 2 * covariates.col(0);
  EXPECT_FALSE(estimate_trend(calibrations, covariates));
  covariates.col(1).setConstant(20);
  EXPECT_FALSE(estimate_trend(calibrations, covariates));
  EXPECT_FALSE(estimate_trend(std::span(calibrations).first(2), covariates.topRows(2)));
  EXPECT_THROW(estimate_trend(calibrations, covariates.topRows(3)), Error);
  std::vector<UnitValues> exact = calibrations;
  exact[1].covariance.setZero();
  EXPECT_THROW(estimate_trend(exact, covariates.leftCols(1)), Error);
}

TEST(FleetTrend, RepeatedCalibrationsShowWhatTheirCovariancesLack) {
  for (const double excess : {1.0, 4.0}) {
    std::vector<Trend> trends;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      Random random(84, seed);
      const MatrixX days = days_and_degrees(random, 5).leftCols(1);
      trends.push_back(
          *estimate_trend(repeated(random, days, Eigen::MatrixXd::Zero(3, 1), excess), days));
    }
    EXPECT_NEAR(repeat_inflation(trends), excess, 0.15 * excess);
    EXPECT_EQ(repeat_inflation(std::span(trends).first(9)), 1);
  }
}

Said of_population(const std::vector<UnitValues>& units) {
  const Population population = estimate_population(units);
  return {population.status, codes_of(population.findings)};
}

}  // namespace

std::vector<Case> cases_of_fleets() {
  return {{"few_units", of_population(equal_units(1, 10))},
          {"population_mixed", of_population(two_lots())},
          {"spread_unresolved", of_population(equal_units(1))}};
}

}  // namespace tagcal
