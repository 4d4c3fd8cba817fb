// Calibrates single views of real data sets, or random groups of a few, and compares their focal
// length fx with the answer of all views of the set (trial 0), or with a true one: z is the
// difference in units of the standard deviation that both claim.
// Single views also as the `pose` of an unknown camera has them, which estimates no distortion.
// Refused: no answer, or the answer `weak`. No answer may claim an sd(fx) / fx above 10 %.

#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>

#include "real_sets.hpp"
#include "studies/studies.hpp"
#include "study/tasks/pose_tasks.hpp"
#include "tagcal/estimate/pose.hpp"

namespace tagcal {
using namespace study;
namespace {

// The groups of views of a set; the first one has all of them.
std::vector<std::vector<std::size_t>> groups_of(std::size_t num_views,
                                                const StudyOptions& options) {
  Random random(static_cast<std::uint64_t>(options.number("seed")));
  const auto size = static_cast<std::size_t>(options.number("views"));
  std::vector<std::vector<std::size_t>> groups = {some_of(num_views, num_views, random)};
  if (size == 1)
    for (std::size_t i = 0; i < num_views; ++i) groups.push_back({i});
  else if (size <= num_views)
    for (int i = 0; i < options.count; ++i) groups.push_back(some_of(num_views, size, random));
  return groups;
}

class Set {
 public:
  Set(RealSet set, const StudyOptions& options)
      : set_(std::move(set)),
        groups_(groups_of(set_.dataset.views.size(), options)),
        model_(options.text("model")),
        truth_px_(options.number("truth")) {}

  const std::string& name() const { return set_.name; }
  int num_groups() const { return static_cast<int>(groups_.size()); }

  std::vector<Values> measure(std::uint64_t trial) {
    if (trial >= groups_.size()) return {};
    std::call_once(once_, [this] { all_ = calibrate_views(set_.dataset, groups_[0], model_); });
    const std::vector<std::size_t>& views = groups_[trial];
    const Calibration c = trial == 0 ? all_ : calibrate_views(set_.dataset, views, model_);
    std::string names;
    for (const std::size_t v : views) names += (names.empty() ? "" : " ") + std::to_string(v);
    std::vector<Values> rows = {row(names, outcome(c), has_focal_length(c) ? claim_of(c, 0) : kNone,
                                    trial == 0 ? "all views" : "groups")};
    if (trial == 0 || views.size() > 1) return rows;
    for (const bool exact_pinhole : {false, true}) {
      const auto e = estimate_pose_and_focal(
          view_correspondences(set_.dataset.views[views[0]], set_.dataset.boards),
          set_.dataset.image_size, {{}, 0, exact_pinhole});
      rows.push_back(row(names, std::string(status_name(e.status)),
                         is_answer(e.status) ? Claim{e.focal_px, e.sigma_focal_px} : kNone,
                         exact_pinhole ? "pose, exact pinhole" : "pose"));
    }
    return rows;
  }

 private:
  static constexpr Claim kNone{std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::quiet_NaN()};

  Values row(const std::string& names, const std::string& outcome, const Claim& focal,
             const char* of) const {
    const Claim truth = truth_px_ > 0            ? Claim{truth_px_, 0}
                        : has_focal_length(all_) ? claim_of(all_, 0)
                                                 : kNone;
    const double sd = 100 * focal.sd / focal.value, z = z_of(focal, truth);
    return {names,
            outcome,
            focal.value,
            focal.sd,
            truth.value,
            truth.sd,
            of,
            std::isnan(focal.value) ? 1. : 0.,
            sd > 10 ? 1. : 0.,
            z,
            std::abs(z) > 3 ? 1. : 0.,
            100 * std::abs(focal.value - truth.value) / truth.value,
            sd};
  }

  RealSet set_;
  std::vector<std::vector<std::size_t>> groups_;
  std::string model_;
  double truth_px_;  // 0: the answer of all views
  std::once_flag once_;
  Calibration all_;
};

std::vector<Task> single_views_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (RealSet& read : read_sets(options.inputs)) {
    const auto set = std::make_shared<Set>(std::move(read), options);
    tasks.push_back(
        {set->name(), [=](std::uint64_t trial) { return set->measure(trial); }, set->num_groups()});
  }
  return tasks;
}

}  // namespace

Study single_views_study() {
  const std::vector<Figure> figures = {rows_in("calibrations"),
                                       sum_of("refused", "refused"),
                                       sum_of("sd > 10 %", "too_wide"),
                                       sum_of("beyond 3 sd", "beyond"),
                                       rms_of("rms z", "z", 2),
                                       largest_of("largest z", "z", 1),
                                       quantile_of("error, %", "error_percent", 0.5, 2),
                                       quantile_of("sd, %", "sd_percent", 0.5, 2),
                                       mean_of("compared with fx", "fx_all", 2)};
  return {.name = "single_views",
          .summary = "calibrations of single views of real data sets against those of all views",
          .inputs = "folders of data sets",
          .count = 20,
          .first = 0,
          .options = {{"views", "1", "in each calibration; with 2 or more --count random groups"},
                      {"truth", "0", "true fx of all sets, px; 0: the answer of all views"},
                      {"model", "auto", "of all calibrations"},
                      {"seed", "1", "of the groups"}},
          .columns = {"views", "outcome", "fx", "sd_fx", "fx_all", "sd_fx_all", "of", "refused",
                      "too_wide", "z", "beyond", "error_percent", "sd_percent"},
          .tasks = single_views_tasks,
          .tables = {{{"of", "task"}, figures}, {{"of"}, figures}}};
}

}  // namespace tagcal
