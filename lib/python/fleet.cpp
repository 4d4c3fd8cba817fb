#include "tagcal/estimate/fleet.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/calibration.hpp"
#include "python/findings.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

// Many units of one make (tagcal fleet).

namespace tagcal::python {
namespace {

using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// (N, P) values and their (N, P, P) covariances.
std::vector<UnitValues> units_of(const ArrayLike& values, const ArrayLike& covariances) {
  const auto v = real_array(values, "values"), c = real_array(covariances, "covariances");
  if (v.ndim() != 2) throw Error("values: must have the shape (N, P)");
  const py::ssize_t n = v.shape(0), p = v.shape(1);
  if (c.ndim() != 3 || c.shape(0) != n || c.shape(1) != p || c.shape(2) != p)
    throw Error("covariances: must have the shape (N, P, P), with N and P those of the values");
  std::vector<UnitValues> units;
  for (py::ssize_t i = 0; i < n; ++i)
    units.push_back({{v.data() + i * p, v.data() + (i + 1) * p},
                     Eigen::Map<const RowMajorX>(c.data() + i * p * p, p, p)});
  return units;
}

Population population_of(const ArrayLike& values, const ArrayLike& covariances,
                         const std::vector<std::string>& names) {
  const std::vector<UnitValues> units = units_of(values, covariances);
  py::gil_scoped_release release;
  return estimate_population(units, names);
}

std::vector<UnitDistance> distances_of(const Population& population, const ArrayLike& values,
                                       const ArrayLike& covariances) {
  const std::vector<UnitValues> units = units_of(values, covariances);
  check_units(units);
  if (!is_answer(population.status)) throw Error("population: is no answer");
  if (!units.empty() && units.front().values.size() != population.centre.size())
    throw Error("values: must have " + std::to_string(population.centre.size()) + " columns");
  std::vector<UnitDistance> distances;
  for (const UnitValues& unit : units) distances.push_back(unit_distance(population, unit));
  return distances;
}

std::optional<Trend> trend_of(const ArrayLike& values, const ArrayLike& covariances,
                              const ArrayLike& covariates) {
  const auto z = real_array(covariates, "covariates");
  if (z.ndim() != 2) throw Error("covariates: must have the shape (N, Q)");
  return estimate_trend(units_of(values, covariances),
                        Eigen::Map<const RowMajorX>(z.data(), z.shape(0), z.shape(1)));
}

// The p value of all covariates, then that of the scatter; NaN without scatter.
std::vector<double> p_values_of(const Trend& trend, double inflation) {
  if (!(inflation >= 1)) throw Error("inflation: must be >= 1, got " + number(inflation));
  std::vector<double> all;
  for (std::size_t j = 0; j < trend.chi_square.size(); ++j)
    all.push_back(*trend_p_value(trend, j, inflation));
  all.push_back(trend_p_value(trend, std::nullopt, inflation).value_or(std::nan("")));
  return all;
}

void bind_population(py::module_& m) {
  Record<Population>(m, "Population", "What units of one make differ by; of P quantities.")
      .field("status", &Population::status, "\"ok\", or \"not_observable\": too few units.")
      .field("num_units", &Population::num_units, "That were given.")
      .field("num_used", &Population::num_used, "That are not beyond p = 0.001.")
      .field("centre", &Population::centre, "P values: the robust mean.")
      .field("centre_covariance", &Population::centre_covariance, "(P, P), of the centre.")
      .field("scatter", &Population::scatter,
             "(P, P): the covariance of units, their own covariances removed.")
      .field("spread", &Population::spread, "P standard deviations: of the scatter.")
      .field("sigma_spread", &Population::sigma_spread, "Their standard deviations.")
      .field("findings", &Population::findings, "List of Finding.")
      .representation([](const Population& p) {
        return is_answer(p.status) ? counted(p.num_units, "unit") + warnings_text(p.findings)
                                   : refusal(p.status, p.findings);
      });
  Record<UnitDistance>(m, "UnitDistance", "How unlike a population a unit is.")
      .field("squared", &UnitDistance::squared, "Squared Mahalanobis distance.")
      .field("p_value", &UnitDistance::p_value, "That a unit of the population is farther away.")
      .field("quantity", &UnitDistance::quantity, "Index of the one that deviates most.")
      .field("in_sigmas", &UnitDistance::in_sigmas, "By how many standard deviations it does.")
      .representation([](const UnitDistance& d) {
        return "p " + number(d.p_value, 2) + ", quantity " + std::to_string(d.quantity) + " " +
               number(d.in_sigmas, 3) + " sd";
      });
}

void bind_trend(py::module_& m) {
  Record<Trend>(m, "Trend", "How P values of one unit change by Q covariates.")
      .field("slopes", &Trend::slopes, "(P, Q).")
      .field("sigmas", &Trend::sigmas, "(P, Q): standard deviations of the slopes.")
      .field("chi_square", &Trend::chi_square, "Q: of a covariate's slopes, P degrees of freedom.")
      .field("scatter", &Trend::scatter, "Chi-square of the residuals about the trend.")
      .field("scatter_freedom", &Trend::scatter_freedom, "Its degrees of freedom.")
      .representation([](const Trend& t) {
        return counted(static_cast<std::size_t>(t.slopes.rows()), "value") + " by " +
               counted(static_cast<std::size_t>(t.slopes.cols()), "covariate");
      });
}

CameraHistory history_of(const std::vector<CameraLike>& calibrations,
                         const std::optional<std::vector<double>>& keys,
                         const std::optional<ArrayLike>& samples) {
  std::vector<UncertainCamera> cameras;
  for (const CameraLike& camera : calibrations)
    cameras.push_back(uncertain_camera(known_camera(camera, "calibrations")));
  std::vector<double> values = keys.value_or(std::vector<double>());
  if (!keys)
    for (std::size_t k = 0; k < cameras.size(); ++k) values.push_back(static_cast<double>(k));
  std::vector<Eigen::Vector2d> pixels;
  if (samples) {
    const auto array = real_array(*samples, "samples");
    if (array.ndim() != 2 || array.shape(1) != 2)
      throw Error("samples: must have the shape (N, 2)");
    for (py::ssize_t i = 0; i < array.shape(0); ++i)
      pixels.emplace_back(array.data()[2 * i], array.data()[2 * i + 1]);
  } else if (!cameras.empty()) {
    pixels = common_samples(cameras.front().camera.image_size, {}, {});
  }
  py::gil_scoped_release release;
  return estimate_history(cameras, values, pixels);
}

void bind_history(py::module_& m) {
  Record<HistoryChange>(m, "HistoryChange", "By how much something changes.")
      .field("name", &HistoryChange::name, "fx, cx, ..; \"distortion\"; \"image\".")
      .field("px", &HistoryChange::px, "The change in pixels.")
      .field("sigma_px", &HistoryChange::sigma_px, "Its standard deviation.")
      .representation([](const HistoryChange& c) {
        return c.name + " " + number(c.px) + " +- " + number(c.sigma_px, 2) + " px";
      });
  Record<HistoryFit>(m, "HistoryFit", "A line by the key, or one step.")
      .field("p_value", &HistoryFit::p_value,
             "Probability that values without a change differ as much as these.")
      .field("parameters", &HistoryFit::parameters,
             "A list of HistoryChange: by one unit of the key, or by the step.")
      .field("image", &HistoryFit::image,
             "HistoryChange: the largest displacement between the first key and the last, or by "
             "the step, less what a turned camera explains.")
      .field("scatter", &HistoryFit::scatter,
             "Of the calibrations about it, over what their covariances say.")
      .field("p_scatter", &HistoryFit::p_scatter, "Probability of a scatter as large as this.")
      .field("after", &HistoryFit::after, "The key before the step, or the first one.")
      .field("before", &HistoryFit::before, "The key behind the step, or the last one.")
      .representation([](const HistoryFit& f) { return "p " + number(f.p_value, 2); });
  Record<CameraHistory>(m, "CameraHistory", "If a camera is stable over its calibrations.")
      .field("verdict", &CameraHistory::verdict,
             "\"stable\", \"trend\", \"change\" or \"too_few\".")
      .field("false_alarm", &CameraHistory::false_alarm,
             "Probability of \"trend\" or \"change\" if nothing changed.")
      .field("trend", &CameraHistory::trend, "HistoryFit: a line by the key.")
      .field("step", &CameraHistory::step, "HistoryFit: one step.")
      .representation([](const CameraHistory& h) {
        return std::string(verdict_name(h.verdict)) + ", trend p " + number(h.trend.p_value, 2) +
               ", step p " + number(h.step.p_value, 2);
      });
}

}  // namespace

void bind_fleet(py::module_& m) {
  bind_population(m);
  bind_trend(m);
  bind_history(m);
  m.def("estimate_history", &history_of, py::arg("calibrations"), py::arg("keys") = py::none(),
        py::arg("samples") = py::none(),
        "If a camera is stable over its calibrations (Calibration or UncertainCamera, of one "
        "model), drifts by the `keys`, such as days or degrees (None: the order), or changed once. "
        "samples: (N, 2) pixels where displacements count (None: the whole image).");
  m.def("estimate_population", &population_of, py::arg("values"), py::arg("covariances"),
        py::arg("names") = std::vector<std::string>(),
        "What units of one make differ by: `values` (N, P) of N units, such as their lens "
        "parameters, with their covariances (N, P, P). Up to a quarter of the units may be "
        "anything. names: of the quantities, for findings.");
  m.def("unit_distances", &distances_of, py::arg("population"), py::arg("values"),
        py::arg("covariances"), "A UnitDistance for each unit.");
  m.def("estimate_trend", &trend_of, py::arg("values"), py::arg("covariances"),
        py::arg("covariates"),
        "How the values (N, P) of N calibrations of one unit change by covariates (N, Q), such as "
        "days and degrees. None if they do not determine slopes.");
  m.def("trend_p_values", &p_values_of, py::arg("trend"), py::arg("inflation") = 1.0,
        "Q + 1 probabilities of slopes as large as these, and of the scatter (NaN without any), if "
        "nothing changes.");
  m.def(
      "repeat_inflation", [](const std::vector<Trend>& trends) { return repeat_inflation(trends); },
      py::arg("trends"),
      "By how much calibrations of one unit scatter beyond their covariances, as a factor of the "
      "variance: the median of the trends of ten units or more.");
}

}  // namespace tagcal::python
