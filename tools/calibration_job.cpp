#include "calibration_job.hpp"

#include "progress.hpp"

namespace tagcal::tools {

CalibrationAnswer run_job(const CalibrationJob& job) {
  const Stopwatch watch;
  Input input = read_input(job.input);
  need_views(input, job.threads, job.shows_progress);
  CalibrationAnswer answer;
  answer.seconds.read = watch.seconds();
  std::optional<Progress> progress;
  if (job.shows_progress) progress.emplace("calibrating");
  CalibrateOptions options = job.options;
  options.num_threads = static_cast<std::size_t>(job.threads);
  answer.calibration = calibrate(input.dataset, options);
  progress.reset();
  auto& warnings = answer.calibration.warnings;
  warnings.insert(warnings.begin(), input.warnings.begin(), input.warnings.end());
  if (job.advise) answer.advice = advise(input.dataset, answer.calibration);
  answer.seconds.total = watch.seconds();
  return answer;
}

}  // namespace tagcal::tools
