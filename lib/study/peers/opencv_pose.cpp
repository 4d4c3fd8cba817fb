#include "study/peers/pose_peers.hpp"

#include <map>
#include <opencv2/calib3d.hpp>

namespace tagcal::study {
namespace {

using Eigen::Vector3d;

struct OpenCvInput {
  explicit OpenCvInput(const PoseTask& task) {
    const auto p = parameters(task.camera.lens);
    k = cv::Matx33d(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    for (const Correspondence& c : task.correspondences) {
      points.emplace_back(c.point.x(), c.point.y(), c.point.z());
      pixels.emplace_back(c.pixel.x(), c.pixel.y());
    }
  }

  cv::Matx33d k;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  cv::Mat rotation, translation, inliers;
  std::vector<cv::Mat> rotations, translations;
  bool success = false;

  PoseAnswer answer() const {
    if (!success || !cv::checkRange(rotation) || !cv::checkRange(translation)) return {};
    const auto vector = [](const cv::Mat& m) {
      return Vector3d(m.at<double>(0), m.at<double>(1), m.at<double>(2));
    };
    PoseAnswer result;
    result.success = true;
    result.camera_from_target = Pose(exp_rotation(vector(rotation)), vector(translation));
    return result;
  }
};

// A method that throws has no answer.
template <typename Solve>
PreparedPose prepare(const PoseTask& task, Solve solve) {
  return prepare_state<PoseAnswer>(
      OpenCvInput(task),
      [solve](OpenCvInput& input) {
        try {
          input.success = solve(input);
        } catch (const cv::Exception&) {
          input.success = false;
        }
      },
      &OpenCvInput::answer);
}

bool solve_both(OpenCvInput& in, cv::SolvePnPMethod flag) {
  if (cv::solvePnPGeneric(in.points, in.pixels, in.k, cv::noArray(), in.rotations, in.translations,
                          false, flag) < 1)
    return false;
  in.rotation = in.rotations.front();
  in.translation = in.translations.front();
  return true;
}

cv::UsacParams usac_params(const std::string& name, double tolerance) {
  cv::UsacParams params;
  params.threshold = tolerance;
  params.maxIterations = 1000;
  params.confidence = 0.9999;
  params.sampler = cv::SAMPLING_UNIFORM;
  params.score = name == "USAC MAGSAC" ? cv::SCORE_METHOD_MAGSAC : cv::SCORE_METHOD_MSAC;
  params.loMethod = cv::LOCAL_OPTIM_INNER_LO;
  return params;
}

// cv::calibrateCamera of one view, f free and nothing else.
class OneViewCalibration {
 public:
  explicit OneViewCalibration(const PoseTask& task)
      : input_(task), size_(task.camera.image_size.width, task.camera.image_size.height) {
    for (const Correspondence& c : task.correspondences) {
      planar_ &= c.point.z() == 0;
      points_[0].emplace_back(static_cast<float>(c.point.x()), static_cast<float>(c.point.y()),
                              static_cast<float>(c.point.z()));
      pixels_[0].emplace_back(static_cast<float>(c.pixel.x()), static_cast<float>(c.pixel.y()));
    }
  }

  void solve() {
    int flags = cv::CALIB_FIX_PRINCIPAL_POINT | cv::CALIB_FIX_ASPECT_RATIO |
                cv::CALIB_ZERO_TANGENT_DIST | cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 |
                cv::CALIB_FIX_K3;
    k_ = cv::Mat::eye(3, 3, CV_64F);  // the aspect ratio is 1
    if (!planar_) {                   // its documentation requires a guess
      flags |= cv::CALIB_USE_INTRINSIC_GUESS;
      k_.at<double>(0, 0) = k_.at<double>(1, 1) = size_.width;
      k_.at<double>(0, 2) = 0.5 * (size_.width - 1);
      k_.at<double>(1, 2) = 0.5 * (size_.height - 1);
    }
    distortion_ = cv::Mat();
    input_.success = false;
    try {
      cv::calibrateCamera(points_, pixels_, size_, k_, distortion_, input_.rotations,
                          input_.translations, flags);
      input_.rotation = input_.rotations.front();
      input_.translation = input_.translations.front();
      input_.success = true;
    } catch (const cv::Exception&) {  // a method that throws has no answer
    }
  }

  PoseAnswer answer() const {
    PoseAnswer answer = input_.answer();
    if (answer.success) answer.focal_px = k_.at<double>(0, 0);
    return answer;
  }

 private:
  OpenCvInput input_;
  cv::Size size_;
  bool planar_ = true;
  std::vector<std::vector<cv::Point3f>> points_{1};  // of one view
  std::vector<std::vector<cv::Point2f>> pixels_{1};
  cv::Mat k_, distortion_;
};

}  // namespace

PoseMethod opencv_pose(const std::string& flag) {
  static const std::map<std::string, cv::SolvePnPMethod> kFlags = {
      {"ITERATIVE", cv::SOLVEPNP_ITERATIVE},
      {"EPNP", cv::SOLVEPNP_EPNP},
      {"SQPNP", cv::SOLVEPNP_SQPNP},
      {"AP3P", cv::SOLVEPNP_AP3P},
      {"P3P", cv::SOLVEPNP_P3P},
      {"IPPE", cv::SOLVEPNP_IPPE},
      {"IPPE_SQUARE", cv::SOLVEPNP_IPPE_SQUARE}};
  const cv::SolvePnPMethod method = kFlags.at(flag);
  const bool both = flag.starts_with("IPPE");
  return {"OpenCV " + flag,
          [method, both](const PoseTask& task) {
            return prepare(task, [method, both](OpenCvInput& in) {
              if (both) return solve_both(in, method);
              return cv::solvePnP(in.points, in.pixels, in.k, cv::noArray(), in.rotation,
                                  in.translation, false, method);
            });
          },
          both ? "solvePnPGeneric, the first of both poses, double precision"
               : "solvePnP, double precision"};
}

PoseMethod opencv_ransac(const std::string& name) {
  cv::SolvePnPMethod flag = cv::SOLVEPNP_ITERATIVE;
  if (name.ends_with("AP3P")) flag = cv::SOLVEPNP_AP3P;
  if (name.ends_with("SQPNP")) flag = cv::SOLVEPNP_SQPNP;
  const bool usac = name.starts_with("USAC");
  return {"OpenCV " + name,
          [name, flag, usac](const PoseTask& task) {
            const double tolerance = 4 * task.sigma_px;
            const cv::UsacParams params = usac_params(name, tolerance);
            return prepare(task, [=](OpenCvInput& in) {
              cv::Mat k(in.k);
              if (usac)
                return cv::solvePnPRansac(in.points, in.pixels, k, cv::noArray(), in.rotation,
                                          in.translation, in.inliers, params);
              return cv::solvePnPRansac(in.points, in.pixels, k, cv::noArray(), in.rotation,
                                        in.translation, false, 1000, static_cast<float>(tolerance),
                                        0.9999, in.inliers, flag);
            });
          },
          usac
              ? "UsacParams: 1000 iterations, confidence 0.9999, tolerance 4 sigma, uniform samples"
              : "solvePnPRansac: 1000 iterations, confidence 0.9999, tolerance 4 sigma"};
}

PoseMethod opencv_calibrate_camera() {
  return {"OpenCV calibrateCamera",
          [](const PoseTask& task) {
            return prepare_state<PoseAnswer>(OneViewCalibration(task), &OneViewCalibration::solve,
                                             &OneViewCalibration::answer);
          },
          "one view, principal point, aspect ratio and distortion held; in space a guess of f, the "
          "image's width"};
}

}  // namespace tagcal::study
