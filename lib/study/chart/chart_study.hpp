#pragma once

#include <vector>

#include "study/chart/chart.hpp"
#include "study/method.hpp"
#include "tagcal/random.hpp"

// What a job of the chart is made of. Private to study.

namespace tagcal::study {

// What came of a method at one problem, held against the truth.
struct Verdict {
  bool failed = true;
  double error = 0;
  double over_bound = 0;
};

// A problem in the form that a method takes it.
using Attempt = Prepared<Verdict>;

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
};

ChartStudy pose_study();
ChartStudy focal_study();
ChartStudy project_study();
ChartStudy calibrate_study(bool quick);
ChartStudy corners_study();

ChartResult run_study(const ChartStudy& study, const ChartOptions& options,
                      const std::function<void(int, int)>& progress);

}  // namespace tagcal::study
