// Random robots with a camera: errors of tagcal handeye and of OpenCV's methods, silent wrong
// answers, and whether the claims hold (docs/trust/how_sure.md).
// 3 to 60 poses, axes spread by 1 to 45 degrees, robots of 0 to 3 mm and 0 to 0.5 degrees, boards
// with the scale of a print on paper. Wrong:
// an answer that is off by more than a tenth of the board's distance, or by 6 degrees; silently so
// without a refusal or warning. OpenCV has neither. NEES: of the camera's place, over six.
// The last table compares the errors of the camera's place in right worlds in which tagcal answers,
// by crossed strata: quantiles of tagcal's over those of the best single method of OpenCV, which
// has another one for each stratum and quantile.

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "studies/studies.hpp"
#include "study/processor_time.hpp"
#include "study/quantile.hpp"
#include "study/tasks/handeye_tasks.hpp"
#include "tagcal/internal/degrees.hpp"

namespace tagcal {
using namespace study;
namespace {

using internal::kDegree;
constexpr const char* kOurs = "tagcal handeye";
constexpr double kWrongShare = 0.1, kWrongRad = 0.1;
constexpr double kNoAnswerMm = 1e9;        // counts as an error
constexpr double kChiSquare95 = 12.592;    // six degrees of freedom
constexpr double kScaleOfPaper = 0.00141;  // standard deviation: the prior of two sides' difference

HandeyeKind drawn_kind(Random& random) {
  HandeyeKind kind;
  kind.mount = random.uniform() < 0.5 ? CameraMount::hand : CameraMount::base;
  kind.num_poses = static_cast<int>(std::exp(random.uniform(std::log(3.0), std::log(60.999))));
  kind.axis_spread_rad = kDegree * std::exp(random.uniform(0, std::log(45)));
  kind.robot_sigma_m = 1e-3 * random.uniform(0, 3);
  kind.robot_sigma_rad = kDegree * random.uniform(0, 0.5);
  kind.sigma_px = std::exp(random.uniform(std::log(0.05), std::log(0.5)));
  kind.board_scale = 1 + kScaleOfPaper * random.normal();
  return kind;
}

std::string stratum(double value, std::initializer_list<double> bounds, const std::string& unit) {
  double low = 0;
  for (const double bound : bounds) {
    if (value < bound) return fmt::format("{:g} to {:g} {}", low, bound, unit);
    low = bound;
  }
  return fmt::format("from {:g} {}", low, unit);
}

// The fault of a world, beside its random parameters.
struct Fault {
  RobotMistake mistake = RobotMistake::none;
  double board_scale = 1;
  int num_wrong = 0, fewest_poses = 3;

  bool is_none() const {
    return mistake == RobotMistake::none && board_scale == 1 && num_wrong == 0;
  }
};

std::vector<Values> measure_handeye(const Fault& fault, std::uint64_t seed) {
  Random random(seed, 11);
  HandeyeKind kind = drawn_kind(random);
  kind.mistake = fault.mistake;
  kind.board_scale *= fault.board_scale;
  kind.num_wrong = fault.num_wrong;
  kind.num_poses = std::max(kind.num_poses, fault.fewest_poses);
  const HandeyeTask task = draw_handeye(kind, random);
  const std::string poses = stratum(kind.num_poses, {5, 10, 25}, "poses");
  const std::string spread = stratum(kind.axis_spread_rad / kDegree, {5, 15}, "deg");
  const std::string noise = stratum(1e3 * kind.robot_sigma_m, {0.75, 1.5}, "mm");
  bool compared = false;
  std::vector<Values> rows;
  for (const HandeyeMethod& method : handeye_methods()) {
    const auto prepared = guarded(method.prepare(task));
    const double us = processor_us(prepared.solve);
    const HandeyeAnswer answer = prepared.answer().value_or(HandeyeAnswer());
    double mm = std::nan(""), deg = mm, nees = mm, covered = mm, wrong = 0, warned = 0;
    if (answer.mount_from_camera) {
      const Vector6d e = minus(task.mount_from_camera, *answer.mount_from_camera);
      mm = 1e3 * e.tail<3>().norm();
      deg = e.head<3>().norm() / kDegree;
      wrong = answer.answered && (e.tail<3>().norm() > kWrongShare * task.distance_m ||
                                  e.head<3>().norm() > kWrongRad);
      warned = wrong > 0 && answer.warned;
      if (answer.answered && answer.covariance.size() > 0) {
        const double square = e.dot(answer.covariance.ldlt().solve(e));
        nees = square / 6;
        covered = square <= kChiSquare95;
      }
    }
    if (rows.empty()) compared = fault.is_none() && answer.answered;
    rows.push_back({method.name, poses, spread, noise, answer.said, mm, deg,
                    compared ? std::fmin(mm, kNoAnswerMm) : std::nan(""), wrong - warned, warned,
                    nees, covered, 1e-3 * us});
  }
  return rows;
}

study::Task handeye_task(const std::string& name, const Fault& fault) {
  return {name, [fault](std::uint64_t seed) { return measure_handeye(fault, seed); }};
}

double error_of(const Sample& sample, const std::string& method, double share) {
  return quantile(sample.where("method", method).numbers("compared"), share);
}

// The least quantile of a method of OpenCV.
double error_of_best_peer(const Sample& sample, double share) {
  double least = std::nan("");
  for (const HandeyeMethod& method : handeye_methods())
    if (method.name != kOurs) least = std::fmin(least, error_of(sample, method.name, share));
  return least;
}

std::vector<Figure> comparison(const std::string& name, double share) {
  const auto number = [](double value, int digits) {
    return std::isnan(value) ? std::string() : fmt::format("{:.{}f}", value, digits);
  };
  return {{name + ", mm", [=](const Sample& s) { return number(error_of(s, kOurs, share), 2); }},
          {"OpenCV's best, mm",
           [=](const Sample& s) { return number(error_of_best_peer(s, share), 2); }},
          {"ratio", [=](const Sample& s) {
             return number(error_of(s, kOurs, share) / error_of_best_peer(s, share), 2);
           }}};
}

Table comparison_table(const std::vector<std::string>& keys) {
  Table table{keys, {{"worlds", [](const Sample& s) {
                        return std::to_string(s.where("method", kOurs).numbers("compared").size());
                      }}}};
  for (const auto& [name, share] : {std::pair("median", 0.5), std::pair("95 %", 0.95)})
    std::ranges::move(comparison(name, share), std::back_inserter(table.figures));
  return table;
}

std::vector<Figure> handeye_figures() {
  return {rows_in("worlds"),
          quantile_of("mm, median", "mm", 0.5, 3),
          quantile_of("mm, 95 %", "mm", 0.95, 2),
          quantile_of("deg, median", "deg", 0.5, 4),
          quantile_of("deg, 95 %", "deg", 0.95, 3),
          sum_of("silently wrong", "wrong"),
          sum_of("with a warning", "warned"),
          mean_of("NEES", "nees", 2),
          mean_of("in 95 %", "covered", 3)};
}

Table handeye_table(const std::string& key) { return {{"task", key, "method"}, handeye_figures()}; }

}  // namespace

Study handeye_study() {
  return {
      .name = "handeye",
      .summary = "random robots with a camera: errors beside OpenCV's, and whether claims hold",
      .count = 1000,
      .options = {{"robots", "all", "right: without those whose poses are read in a wrong way"}},
      .columns = {"method", "poses", "spread", "noise", "answer", "mm", "deg", "compared", "wrong",
                  "warned", "nees", "covered", "ms"},
      .tasks =
          [](const StudyOptions& options) {
            std::vector<study::Task> tasks = {
                handeye_task("right", {}),
                handeye_task("board 1 % larger", {.board_scale = 1.01}),
                handeye_task("two poses off by 3 cm", {.num_wrong = 2, .fewest_poses = 10}),
                handeye_task("inverse", {RobotMistake::inverse}),
                handeye_task("millimetres", {RobotMistake::millimetres}),
                handeye_task("quaternion order", {RobotMistake::quaternion_order}),
                handeye_task("next picture's", {RobotMistake::shifted, 1, 0, 12})};
            if (options.text("robots") == "right") tasks.resize(1);
            return tasks;
          },
      .tables = {
          {{"task", "method"},
           {rows_in("worlds"), counts_of("answers", "answer"), sum_of("silently wrong", "wrong"),
            sum_of("with a warning", "warned"), mean_of("NEES", "nees", 2),
            mean_of("in 95 %", "covered", 3), mean_of("CPU ms", "ms", 1)}},
          handeye_table("poses"),
          handeye_table("spread"),
          handeye_table("noise"),
          comparison_table({"poses", "spread", "noise"})}};
}

}  // namespace tagcal
