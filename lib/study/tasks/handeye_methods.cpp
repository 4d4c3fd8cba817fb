#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "study/tasks/handeye_tasks.hpp"

namespace tagcal::study {
namespace {

cv::Mat rotation_of(const Pose& pose) {
  cv::Mat r(3, 3, CV_64F);
  const Eigen::Matrix3d rotation = pose.rotation_matrix();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) r.at<double>(i, k) = rotation(i, k);
  return r;
}

cv::Mat translation_of(const Pose& pose) {
  const Eigen::Vector3d& t = pose.translation();
  return (cv::Mat_<double>(3, 1) << t.x(), t.y(), t.z());
}

// No value for a matrix that is not a rotation.
std::optional<Pose> pose_from(const cv::Mat& r, const cv::Mat& t) {
  if (r.total() != 9 || t.total() != 3 || !cv::checkRange(r) || !cv::checkRange(t)) return {};
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) rotation(i, k) = r.at<double>(i, k);
  constexpr double kSingular = 1e-6;  // numeric: determinant of a rotation is 1
  if (!(rotation.determinant() > kSingular)) return {};
  return Pose(nearest_rotation(rotation), {t.at<double>(0), t.at<double>(1), t.at<double>(2)});
}

struct OpenCvHandeye {
  std::vector<std::vector<cv::Point3d>> points;
  std::vector<std::vector<cv::Point2d>> pixels;
  cv::Mat camera;
  std::vector<cv::Mat> hand_r, hand_t;  // mount's other end in the mount
  HandeyeAnswer answer;

  explicit OpenCvHandeye(const HandeyeTask& task) {
    const auto p = parameters(task.camera.camera.lens);
    camera = (cv::Mat_<double>(3, 3) << p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    for (const HandeyeView& view : task.views) {
      points.emplace_back();
      pixels.emplace_back();
      for (const Correspondence& c : view.seen.correspondences) {
        points.back().emplace_back(c.point.x(), c.point.y(), c.point.z());
        pixels.back().emplace_back(c.pixel.x(), c.pixel.y());
      }
      // OpenCV's gripper is what carries the camera, its base what holds the board.
      const Pose holder_from_mount =
          task.mount == CameraMount::hand ? view.base_from_hand : view.base_from_hand.inverse();
      hand_r.push_back(rotation_of(holder_from_mount));
      hand_t.push_back(translation_of(holder_from_mount));
    }
  }

  void views(std::vector<cv::Mat>& r, std::vector<cv::Mat>& t) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      cv::Mat turn, move, rotation;
      cv::solvePnP(points[i], pixels[i], camera, cv::Mat(), turn, move);
      cv::Rodrigues(turn, rotation);
      r.push_back(rotation);
      t.push_back(move);
    }
  }

  void set(const std::optional<Pose>& found) {
    answer = {};
    if (!found) return;
    answer.mount_from_camera = found;
    answer.answered = true;
    answer.said = "answer";
  }

  void solve_handeye(cv::HandEyeCalibrationMethod method) {
    std::vector<cv::Mat> r, t;
    views(r, t);
    cv::Mat found_r, found_t;
    cv::calibrateHandEye(hand_r, hand_t, r, t, found_r, found_t, method);
    set(pose_from(found_r, found_t));
  }

  void solve_robot_world(cv::RobotWorldHandEyeCalibrationMethod method) {
    std::vector<cv::Mat> r, t, inverse_r, inverse_t;
    views(r, t);
    for (std::size_t i = 0; i < hand_r.size(); ++i) {
      inverse_r.push_back(hand_r[i].t());
      inverse_t.push_back(-inverse_r.back() * hand_t[i]);
    }
    cv::Mat world_r, world_t, found_r, found_t;
    cv::calibrateRobotWorldHandEye(r, t, inverse_r, inverse_t, world_r, world_t, found_r, found_t,
                                   method);
    // camera_from_gripper
    const auto found = pose_from(found_r, found_t);
    set(found ? std::optional(found->inverse()) : std::nullopt);
  }
};

template <typename Solve>
HandeyeMethod opencv_method(const std::string& name, Solve solve) {
  return {"OpenCV " + name,
          [solve](const HandeyeTask& task) {
            return prepare_state<HandeyeAnswer>(OpenCvHandeye(task), solve,
                                                [](const OpenCvHandeye& s) { return s.answer; });
          },
          "after solvePnP (iterative) of each view; no standard deviations, no status"};
}

HandeyeMethod calibrate_hand_eye(const std::string& name, cv::HandEyeCalibrationMethod method) {
  return opencv_method(name, [method](OpenCvHandeye& s) { s.solve_handeye(method); });
}

HandeyeMethod robot_world(const std::string& name, cv::RobotWorldHandEyeCalibrationMethod method) {
  return opencv_method(name, [method](OpenCvHandeye& s) { s.solve_robot_world(method); });
}

HandeyeAnswer our_answer(const HandeyeEstimate& found) {
  HandeyeAnswer answer;
  answer.said = status_name(found.status);
  answer.answered = is_answer(found.status);
  answer.warned = std::ranges::count(found.findings, Severity::warning, &Finding::severity) > 0;
  if (found.views.empty()) return answer;
  answer.mount_from_camera = found.mount_from_camera;
  answer.covariance = found.camera_covariance;
  return answer;
}

HandeyeEstimate estimate_handeye(const HandeyeTask& task) {
  HandeyeOptions options;
  options.mount = task.mount;
  return calibrate_handeye(task.views, task.camera, options);
}

}  // namespace

std::vector<HandeyeMethod> handeye_methods() {
  return {{"tagcal handeye",
           [](const HandeyeTask& task) {
             return prepare_task<HandeyeAnswer>(task, &estimate_handeye, &our_answer);
           },
           "from corners to covariance, with the advised pose; one thread"},
          calibrate_hand_eye("Tsai", cv::CALIB_HAND_EYE_TSAI),
          calibrate_hand_eye("Park", cv::CALIB_HAND_EYE_PARK),
          calibrate_hand_eye("Horaud", cv::CALIB_HAND_EYE_HORAUD),
          calibrate_hand_eye("Andreff", cv::CALIB_HAND_EYE_ANDREFF),
          calibrate_hand_eye("Daniilidis", cv::CALIB_HAND_EYE_DANIILIDIS),
          robot_world("Shah", cv::CALIB_ROBOT_WORLD_HAND_EYE_SHAH),
          robot_world("Li", cv::CALIB_ROBOT_WORLD_HAND_EYE_LI)};
}

}  // namespace tagcal::study
