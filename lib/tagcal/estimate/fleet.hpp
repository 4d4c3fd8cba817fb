#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/uncertainty/uncertain_camera.hpp"

// Many units of one make, each with an estimate of the same p quantities and its covariance: the
// population they are drawn from, how unlike it each unit is, and how a unit changes with time or
// temperature. The quantities may have any units, such as the parameters of a lens.

namespace tagcal {

// The values of one unit: the p parameters of a calibration, and their covariance (p x p), positive
// semi-definite (covariance_defect).
struct UnitValues {
  std::vector<double> values;
  MatrixX covariance;
};

// Throws Error if the units have different numbers of values, or none, or covariances of another
// size, and for a value or variance that is not finite. All functions of units check this.
void check_units(std::span<const UnitValues> units);

// The population of units. With `scatter` T and a unit's own covariance C_i,
//   values_i = centre + d_i + e_i,   d_i ~ N(0, T),   e_i ~ N(0, C_i),
// for most units; up to a quarter may be anything. T is what the units differ by in truth.
struct Population {
  // ok, or not_observable (few_units): everything but num_units and findings is empty then.
  Status status = Status::not_observable;
  std::size_t num_units = 0;  // that were given
  std::size_t num_used = 0;   // that took part in the last step: not beyond p = 0.001
  std::vector<double> centre;
  MatrixX centre_covariance;         // p x p
  MatrixX scatter;                   // T, p x p
  std::vector<double> spread;        // sqrt(T_jj)
  std::vector<double> sigma_spread;  // standard deviation of the spread
  std::vector<Finding> findings;     // few_units, population_mixed, spread_unresolved
};

// Estimates the population robustly: the start is the orthogonalised Gnanadesikan-Kettenring
// estimate (Maronna and Zamar 2002, Technometrics 44), less the mean of the own covariances; then
// steps of EM for the model above (Dempster, Laird and Rubin 1977) over the units within the 99.9 %
// ellipsoid, with the correction for that truncation. Of more than 20,000 units as many take part,
// evenly spaced. Throws Error for a quantity in which the units neither differ nor are uncertain.
// Cost: linear in the units.
// `names` of the quantities are for the findings; without them they have numbers.
Population estimate_population(std::span<const UnitValues> units,
                               std::span<const std::string> names = {});

// How unlike the population a unit is.
struct UnitDistance {
  // (x - centre)' (T + C + covariance of the centre)^-1 (x - centre), of p degrees of freedom.
  double squared = 0;
  // Probability that a unit of the population is farther away: Hotelling's F, of p and n - p
  // degrees of freedom, where n is (num_used - 1) / s^2 + 1 with s the share that the usual unit's
  // covariance T + C has in this unit's.
  double p_value = 1;
  std::size_t quantity = 0;  // that deviates most, in its own standard deviations
  double in_sigmas = 0;      // by how many, with its sign
};

// p_value below which a unit is outlying, and a trend is one: a normal variable is beyond 3.72 of
// its standard deviations with it.
double outlying_p();

// Precondition: the population's status is ok, and the unit has its number of values.
UnitDistance unit_distance(const Population& population, const UnitValues& unit);

// How the values of one unit change over repeated calibrations, by q covariates such as days and
// degrees: values_k = constant + slopes z_k + e_k, e_k ~ N(0, C_k), by generalised least squares.
struct Trend {
  MatrixX slopes;                    // p x q, for one unit of the covariate
  MatrixX sigmas;                    // standard deviations of the slopes
  std::vector<MatrixX> covariances;  // of each covariate's slopes, p x p
  std::vector<double> chi_square;    // of each covariate's slopes, p degrees of freedom
  double scatter = 0;       // sum of squared residuals about the trend, in standard deviations
  int scatter_freedom = 0;  // its degrees of freedom; 0: the trend passes through all values
};

// `covariates`: one row for each calibration, q columns. No value if they do not determine the
// slopes: too few calibrations, or covariates that do not vary or vary together. Throws Error for a
// covariance that is not positive definite.
std::optional<Trend> estimate_trend(std::span<const UnitValues> calibrations,
                                    const MatrixX& covariates);

// By how much calibrations of one unit scatter beyond their own covariances, as a factor of the
// variance, 1 or more: the median over the trends of many units. 1 if fewer than ten of them have
// scatter.
double repeat_inflation(std::span<const Trend> trends);

// Probability of slopes of one covariate (or, without one, of the scatter about the trend) as large
// as these if there is no change. No value for the scatter of a trend through all values.
std::optional<double> trend_p_value(const Trend& trend, std::optional<std::size_t> covariate,
                                    double inflation = 1);

// Repeated calibrations of one camera, by a key such as days or degrees: is it stable?
enum class HistoryVerdict {
  stable,   // neither of the next two (p >= CameraHistory::false_alarm)
  trend,    // the lens changes in proportion to the key
  change,   // the lens changed once, between two keys
  too_few,  // fewer than three different keys, or four residual degrees of freedom
};
std::string_view verdict_name(HistoryVerdict verdict);  // as in the enum

// By how much something changes, and its standard deviation.
struct HistoryChange {
  std::string name;  // fx, fy, f, cx, cy; "distortion": outwards, at the corner farthest out
  double px = 0;
  double sigma_px = 0;
};

// One explanation of the differences: a straight line by the key, or one step.
struct HistoryFit {
  double p_value = 1;  // of values without a change that differ as much; of all places of a step
  std::vector<HistoryChange> parameters;  // by one unit of the key, or by the step
  // The largest displacement in the image between the first key and the last, or by the step, less
  // what a turned camera explains.
  HistoryChange image;
  double scatter = 1;    // of the calibrations about it, over what their covariances say, as sd
  double p_scatter = 1;  // of a scatter as large as this, if the covariances are right
  double after = 0, before = 0;  // the keys on both sides of the step; else the first and the last
};

struct CameraHistory {
  HistoryVerdict verdict = HistoryVerdict::too_few;
  double false_alarm = 0;  // probability of `trend` or `change` if nothing changed
  HistoryFit trend, step;  // without values if too_few
};

// Fits the lens parameters x_k of the calibrations by a line, x_k = a + b key_k + e_k, and by a
// step after each key in turn (estimate_trend), e_k ~ N(0, phi C_k). With chi-square X of the p
// slopes, and phi = max(1, R / nu) by the residuals R of nu degrees of freedom, X / (p phi) is
// compared with F of p and nu. That is never beyond its level: phi is known from few calibrations,
// and those that agree better than their covariances do not tighten the test. Both tests share the
// false alarms; the step's p is times the number of its places (Bonferroni). If both are
// significant, the verdict is the likelier one, each place of a step being as likely as the others.
// `samples`: pixels where the displacement counts, such as common_samples. Throws Error for fewer
// than two calibrations, other models, image sizes or numbers of keys, no covariance, and a
// parallel lens.
CameraHistory estimate_history(std::span<const UncertainCamera> calibrations,
                               std::span<const double> keys,
                               std::span<const Eigen::Vector2d> samples);

}  // namespace tagcal
