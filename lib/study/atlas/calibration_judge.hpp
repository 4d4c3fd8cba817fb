#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/atlas/stability.hpp"
#include "study/tasks/calibration_tasks.hpp"
#include "tagcal/estimate/types.hpp"

// Judges the answer, or the refusal, of a calibration by the truth. Private to study.

namespace tagcal::study {

// The quantity that is compared with the truth; coefficients never are.
enum class JudgedLens {
  camera_matrix,  // those of fx, fy, cx, cy that are free in the claim (f: their mean)
  projection,     // at infinity over the region with corners, up to a rotation of the camera
  image_corners,  // the same at the four corners of the image: extrapolated
};

struct CalibrationQuestion {
  Dataset dataset;       // the input of the methods
  CalibrationTask good;  // its correct corners, on a board of points, and their truth
  JudgedLens judged = JudgedLens::camera_matrix;
  bool knowable = true;  // the bound must allow it as well
};

struct LensAnswer {
  bool success = false;
  bool doubted = false;  // warns that a stated assumption does not hold
  std::string said;
  UncertainCamera claim;  // the lens, and what the method claims; no covariance: the bound instead
};

// A calibration must not be refused if its Cramer-Rao bound is below both: sd(f) / f, and the
// standard deviation of the projection at infinity, RMS over the region with corners.
inline constexpr double kKnownFocalShare = 0.05;
inline constexpr double kKnownProjectionPx = 1;

class CalibrationJudge {
 public:
  explicit CalibrationJudge(CalibrationQuestion question);

  // `may_refuse`: the method fits another lens than that of the data.
  StabilityVerdict judge(const LensAnswer& answer, bool may_refuse = false) const;
  const CalibrationQuestion& question() const { return question_; }
  bool knowable() const { return question_.knowable; }

 private:
  bool right(const LensAnswer& answer) const;
  bool right_by_bound(const LensAnswer& answer) const;
  bool right_camera_matrix(const LensAnswer& answer) const;
  bool right_projection(const LensAnswer& answer) const;
  bool right_at_corners(const LensAnswer& answer) const;

  CalibrationQuestion question_;
  Camera truth_;
  std::vector<Eigen::Vector2d> samples_;  // pixels of the truth
  double bound_px_ = 0;                   // of the projection, RMS of lengths; NaN: none
};

}  // namespace tagcal::study
