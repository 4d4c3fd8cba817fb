// The jobs `pose` and `focal` of the chart.

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "study/chart/chart_study.hpp"
#include "study/chart/pose_methods.hpp"
#include "study/tasks/pose_error.hpp"
#include "study/tasks/pose_tasks.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector3d;

enum class Geometry { plane, frontal, space };

struct Cell {
  double sigma_px;
  int num_points;  // 4, 36 or 144
  Geometry geometry;
  bool focal = false;
};

constexpr double kGrossAngleRad = 30 * kDegree;
constexpr double kGrossFocalRatio = 1.5;

const char* title_of(Geometry geometry) {
  switch (geometry) {
    case Geometry::plane:
      return "plane, tilted 20-60°";
    case Geometry::frontal:
      return "frontal plane, tilted 0-3°";
    case Geometry::space:
      return "points in space";
  }
  return "";
}

std::vector<Vector3d> points_of(const Cell& cell, Random& random) {
  if (cell.geometry == Geometry::space)
    return space_points(static_cast<std::size_t>(cell.num_points), 0.6, random);
  if (cell.num_points == 4) return square_points(cell.focal ? 0.6 : 0.088);
  return tag_grid_points(cell.num_points == 36 ? 3 : 6);
}

ViewRange range_of(const Cell& cell) {
  ViewRange range;
  range.sigma_px = cell.sigma_px;
  if (cell.geometry == Geometry::plane) range.min_tilt_deg = 20, range.max_tilt_deg = 60;
  if (cell.geometry == Geometry::frontal) range.max_tilt_deg = 3;
  return range;
}

PoseJob job_of(const Cell& cell) {
  if (cell.geometry == Geometry::space) {
    if (cell.num_points == 4) return cell.focal ? PoseJob::four_space_focal : PoseJob::four_space;
    return cell.focal ? PoseJob::space_focal : PoseJob::space;
  }
  if (cell.focal) return PoseJob::plane_focal;
  return cell.num_points == 4 ? PoseJob::tag : PoseJob::plane;
}

// Failures: the other pose of a tilted plane, any pose with a point behind the camera, and gross
// errors.
bool is_failure(const PoseAnswer& answer, const PoseTask& task, const Cell& cell) {
  if (!answer.success) return true;
  const Pose& pose = answer.camera_from_target;
  for (const Correspondence& c : task.correspondences)
    if (!((pose * c.point).z() > 0)) return true;
  if (cell.geometry == Geometry::plane && is_flip(pose, task.camera_from_target)) return true;
  if (cell.focal) {
    const double ratio = answer.focal_px / kStudyFocalPx;
    if (!(ratio < kGrossFocalRatio && ratio > 1 / kGrossFocalRatio)) return true;
  }
  return !(angle_between_rad(pose, task.camera_from_target) < kGrossAngleRad);
}

// The truth, and the information for the bound.
struct Truth {
  PoseTask task;
  Cell cell;
  Matrix6 information;
  Matrix7 information_with_focal;

  Verdict judge(const PoseAnswer& answer) const {
    Verdict verdict;
    verdict.failed = is_failure(answer, task, cell);
    if (verdict.failed) return verdict;
    if (cell.focal) {
      const Vector7d e = pose_and_focal_error(answer, task);
      verdict.error = 100 * std::abs(answer.focal_px / kStudyFocalPx - 1);
      verdict.over_bound = std::sqrt(e.dot(information_with_focal * e) / 7);
    } else {
      const Vector6d e = pose_error(answer, task);
      verdict.error =
          angle_between_rad(answer.camera_from_target, task.camera_from_target) / kDegree;
      verdict.over_bound = std::sqrt(e.dot(information * e) / 6);
    }
    return verdict;
  }
};

std::vector<Attempt> draw(const Cell& cell, const std::vector<PoseMethod>& methods,
                          Random& random) {
  auto truth = std::make_shared<Truth>();
  truth->cell = cell;
  truth->task = draw_task(points_of(cell, random), range_of(cell), random);
  if (cell.focal)
    truth->information_with_focal = pose_and_focal_information(truth->task);
  else
    truth->information = pose_information(truth->task);
  return attempts_of(methods, truth->task,
                     [truth](const PoseAnswer& answer) { return truth->judge(answer); });
}

std::vector<std::string> cannot(const Cell& cell) {
  if (cell.focal && cell.geometry == Geometry::space && cell.num_points == 4)
    return {"OpenCV calibrateCamera: takes six points in space or more"};
  if (cell.focal) return {};
  std::vector<std::string> why;
  if (cell.num_points > 4) why.emplace_back("OpenCV P3P, AP3P: take four points");
  if (cell.geometry == Geometry::space) {
    why.emplace_back("OpenCV IPPE, tagcal homography + ippe: take points in a plane");
    if (cell.num_points == 4)
      why.emplace_back("OpenCV ITERATIVE: takes six points in space or more");
  }
  if (cell.geometry == Geometry::space || cell.num_points > 4)
    why.emplace_back(
        "OpenCV IPPE_SQUARE, AprilTag estimate_tag_pose: take the corners of a square");
  return why;
}

void add_panel(const Cell& cell, ChartStudy& study) {
  StudyPanel panel;
  panel.panel = {fmt::format("noise {:g} px", cell.sigma_px), title_of(cell.geometry),
                 fmt::format("{} points", cell.num_points), cannot(cell)};
  std::vector<PoseMethod> methods = pose_methods(job_of(cell));
  // A minimal solver does not say which of its solutions is right.
  std::erase_if(methods, [](const PoseMethod& m) { return m.name == "tagcal p4pf"; });
  panel.methods = study.numbers_of(methods);
  panel.draw = [cell, methods](Random& random) { return draw(cell, methods, random); };
  study.panels.push_back(std::move(panel));
}

ChartStudy study_of(bool focal, const std::vector<Geometry>& geometries) {
  ChartStudy study;
  study.bound_name = "Cramér-Rao bound";
  study.trials = 2000;
  study.quick_trials = 40;
  for (const double sigma : {0.5, 0.1, 1.0})
    for (const Geometry geometry : geometries)
      for (const int n : {4, 36, 144}) add_panel({sigma, n, geometry, focal}, study);
  return study;
}

}  // namespace

ChartStudy pose_study() {
  ChartStudy study = study_of(false, {Geometry::plane, Geometry::frontal, Geometry::space});
  study.error_unit = "rotation, degrees";
  study.failure =
      "no answer, a point behind the camera, the other pose of a tilted plane, or a rotation off "
      "by "
      "more than 30°";
  return study;
}

ChartStudy focal_study() {
  ChartStudy study = study_of(true, {Geometry::plane, Geometry::space});
  study.error_unit = "focal length, percent";
  study.failure =
      "no answer or a refused one, a point behind the camera, the other pose of a plane, a "
      "rotation "
      "off by more than 30°, or f by more than half";
  return study;
}

}  // namespace tagcal::study
