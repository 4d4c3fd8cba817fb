#pragma once

#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "study/atlas/calibration_judge.hpp"
#include "study/tasks/pose_tasks.hpp"

// Maps of failure of calibrations. Private to study.

namespace tagcal::study {

inline constexpr int kSmallGrid = 6;  // points across and down
inline constexpr double kSmallSpacingM = 0.12;

struct CalibrationSolver {
  std::string name, settings;
  bool ours = false;
  std::string lens = {};  // "perspective" or "fisheye": the lens that it fits; empty: either
  std::function<Prepared<LensAnswer>(const CalibrationQuestion&)> prepare = {};
};

CalibrationSolver our_calibration();          // auto, noise not stated
CalibrationSolver our_calibration_by_name();  // the true model, noise stated
CalibrationSolver our_calibration_by_name(const std::string& model);
CalibrationSolver opencv_calibration();                             // default flags
CalibrationSolver opencv_calibration_of(const std::string& model);  // its coefficients only
CalibrationSolver opencv_fisheye();
// Adds libmrcal, if it is installed, for complete views of the small grid.
std::vector<CalibrationSolver> with_mrcal(std::vector<CalibrationSolver> solvers);

void ask_calibration(
    StabilityMap& map, const std::vector<CalibrationSolver>& solvers,
    const std::function<CalibrationQuestion(std::span<const double> at, Random& random)>& question);

// A camera of 1280 x 800 pixels and the board of points, without views.
CalibrationTask empty_task(const Lens& lens, const std::string& model, double sigma_px);

// Model f+c: 900 px, its principal point beside the centre of the image, no distortion.
CalibrationTask pinhole_task();

// A pose with this tilt, a random side and roll, at a distance of 0.9 to 1.3 m (times `nearer`),
// the board a little off the optical axis.
Pose draw_view(double tilt_deg, Random& random, double nearer = 1);

// A question with only correct corners.
CalibrationQuestion ask_all(CalibrationTask task, JudgedLens judged = JudgedLens::camera_matrix);

StabilityMap views_tilt_map();
StabilityMap parallel_planes_map();
StabilityMap roll_map();
StabilityMap repeated_views_map();
StabilityMap board_unit_map();
StabilityMap extrapolation_map();
StabilityMap fold_map();
StabilityMap bent_board_map();
StabilityMap wrong_lens_map();
StabilityMap wrong_views_map();

std::vector<StabilityMap> calibration_maps();
std::vector<StabilityMap> rig_maps();

}  // namespace tagcal::study
