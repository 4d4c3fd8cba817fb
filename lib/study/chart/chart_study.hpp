#pragma once

#include <vector>

#include "study/chart/chart.hpp"
#include "study/method.hpp"
#include "tagcal/random.hpp"

// The parts of a job of the chart. Private to study.

namespace tagcal::study {

// The answer of a method to one problem, compared with the truth.
struct Verdict {
  bool failed = true;
  double error = 0;
  double over_bound = 0;
};

// A problem in the form that a method takes it, with the judge of its answer.
using Attempt = Prepared<Verdict>;

// The attempts of all methods at one task. A method that throws has no answer.
template <typename Task, typename Answer, typename Judge>
std::vector<Attempt> attempts_of(const std::vector<Method<Task, Answer>>& methods, const Task& task,
                                 const Judge& judge) {
  std::vector<Attempt> attempts;
  for (const auto& method : methods)
    attempts.push_back(
        judged(guarded(method.prepare(task)), [judge](const std::optional<Answer>& answer) {
          return answer ? judge(*answer) : Verdict();
        }));
  return attempts;
}

struct StudyPanel {
  ChartPanel panel;
  std::vector<int> methods;  // of ChartStudy::methods
  // A new problem, prepared for each of the methods. Called from several threads.
  std::function<std::vector<Attempt>(Random&)> draw;
};

struct ChartStudy {
  std::string error_unit, bound_name, failure;
  int trials = 0, quick_trials = 0;
  std::vector<ChartMethod> methods;
  std::vector<StudyPanel> panels;

  // The number of a method, which is added if it is new.
  int number_of(const ChartMethod& method);
  template <typename Task, typename Answer>
  std::vector<int> numbers_of(const std::vector<Method<Task, Answer>>& all) {
    std::vector<int> numbers;
    for (const auto& m : all) numbers.push_back(number_of({m.name, m.settings, m.ours()}));
    return numbers;
  }
};

ChartStudy pose_study();
ChartStudy focal_study();
ChartStudy project_study();
ChartStudy calibrate_study(bool quick);
ChartStudy corners_study();
ChartStudy rig_study(bool quick);
ChartStudy handeye_chart(bool quick);

ChartResult run_study(const ChartStudy& study, const ChartOptions& options,
                      const std::function<void(int, int)>& progress);

}  // namespace tagcal::study
