#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/atlas/stability.hpp"
#include "study/tasks/calibration_tasks.hpp"
#include "tagcal/camera/model.hpp"

// What a calibration that is answered, or refused, is worth. Private to study.

namespace tagcal::study {

// What is held against the truth. Coefficients never are.
enum class JudgedLens {
  camera_matrix,  // fx, fy, cx, cy (f: their mean), those that the model has
  projection,     // at infinity over the region with corners, a turned camera taken out
  image_corners,  // the same at the four corners of the image: extrapolated
};

struct CalibrationQuestion {
  Dataset dataset;       // as it is asked
  CalibrationTask good;  // its corners that are right, of a board of points, and their truth
  JudgedLens judged = JudgedLens::camera_matrix;
  bool knowable = true;  // unless the bound says that it is not
};

struct LensAnswer {
  bool success = false;
  bool doubted = false;  // with a warning that what was stated does not hold
  std::string said;
  Lens lens = pinhole(1, 1, 0, 0);
  std::string model;           // whose free parameters the covariance is of
  Eigen::MatrixXd covariance;  // claimed; empty: none is, and the bound counts
};

// Known well enough that it must not be refused, at the bound: sd(f) / f, and the projection's
// standard deviation at infinity, RMS over the region with corners.
inline constexpr double kKnownFocalShare = 0.05;
inline constexpr double kKnownProjectionPx = 1;

class CalibrationJudge {
 public:
  explicit CalibrationJudge(CalibrationQuestion question);

  // `may_refuse`: a method that was asked for a lens which the data do not have.
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
