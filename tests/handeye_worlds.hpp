#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <string>

#include "study/tasks/handeye_tasks.hpp"
#include "tagcal/estimate/findings.hpp"

// Hand-eye worlds for tests, and their answers.

namespace tagcal {

using study::draw_handeye;
using study::HandeyeKind;
using study::HandeyeTask;
using study::RobotMistake;

inline HandeyeTask task_of(const HandeyeKind& kind, std::uint64_t seed) {
  Random random(seed, 3);
  return draw_handeye(kind, random);
}

inline HandeyeEstimate estimate(const HandeyeTask& task, HandeyeOptions options = {}) {
  options.mount = task.mount;
  return calibrate_handeye(task.views, task.camera, options);
}

inline std::string all_sentences(const HandeyeEstimate& answer) {
  std::string all;
  for (const Finding& f : answer.findings) all += f.code + ": " + f.sentence + "\n";
  return all;
}

inline bool has(const HandeyeEstimate& answer, std::string_view code) {
  return std::ranges::any_of(answer.findings, [&](const Finding& f) { return f.code == code; });
}

inline double nees(const HandeyeTask& task, const HandeyeEstimate& answer) {
  const Vector6d e = minus(task.mount_from_camera, answer.mount_from_camera);
  const Eigen::Matrix<double, 6, 6> covariance = answer.camera_covariance;
  return e.dot(covariance.ldlt().solve(e)) / 6;
}

}  // namespace tagcal
