#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>

#include "study/peers/opencv_views.hpp"
#include "study/tasks/rig_tasks.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::study {
namespace {

RigOptions our_options(const RigTask& task) {
  RigOptions options;
  options.calibrate.front().model = "opencv5";
  options.find_boards = task.rig.cameras.front().data.boards.size() > 1;
  return options;
}

RigCalibration estimate_rig(const RigTask& task) {
  return calibrate_rig(task.rig, our_options(task));
}

// With the lenses of the cameras' own calibrations.
RigCalibration estimate_places(const RigTask& task) {
  RigOptions options = our_options(task);
  options.lenses = RigLenses::fixed;
  for (const RigCamera& camera : task.rig.cameras) {
    const Calibration own = calibrate(camera.data, options.calibrate.front());
    if (!is_answer(own.status)) return {};
    options.known.push_back({uncertain_camera(own), camera_error_px(own)});
  }
  return calibrate_rig(task.rig, options);
}

RigAnswer our_answer(const RigCalibration& found) {
  RigAnswer answer;
  answer.said = status_name(found.status);
  if (!is_answer(found.status)) return answer;
  for (const RigCameraEstimate& camera : found.cameras)
    answer.camera_from_first.push_back(camera.camera_from_rig);
  const auto size = 6 * (std::ssize(found.cameras) - 1);
  answer.covariance = found.covariance.topLeftCorner(size, size);
  answer.warned = std::ranges::count(found.findings, Severity::warning, &Finding::severity) > 0;
  if (answer.warned) answer.said += "+warning";
  return answer;
}

// The corners that two cameras see at the same instants, in OpenCV's form.
struct StereoPair {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> a, b;

  StereoPair(const RigDataset& rig, std::size_t first, std::size_t second) {
    const auto where = points_in_world(rig.cameras.front().data.boards);
    const auto pixel = [](const Eigen::Vector2d& p) {
      return cv::Point2f(static_cast<float>(p.x()), static_cast<float>(p.y()));
    };
    for (const Instant& instant : rig.instants) {
      if (!instant.view[first] || !instant.view[second]) continue;
      std::map<CornerId, Eigen::Vector2d> in_a;
      for (const Observation& o : rig.cameras[first].data.views[*instant.view[first]].observations)
        in_a[o.id] = o.pixel;
      points.emplace_back();
      a.emplace_back();
      b.emplace_back();
      for (const Observation& o :
           rig.cameras[second].data.views[*instant.view[second]].observations) {
        const auto other = in_a.find(o.id);
        if (other == in_a.end()) continue;
        const Eigen::Vector3f x = where.at(o.id).cast<float>();
        points.back().emplace_back(x.x(), x.y(), x.z());
        a.back().push_back(pixel(other->second));
        b.back().push_back(pixel(o.pixel));
      }
    }
  }
};

struct OpenCvRig {
  std::vector<OpenCvViews> cameras;
  std::vector<StereoPair> pairs;  // of neighbours
  RigAnswer answer;

  explicit OpenCvRig(const RigDataset& rig) {
    for (const RigCamera& camera : rig.cameras) cameras.emplace_back(camera.data);
    for (std::size_t c = 1; c < cameras.size(); ++c) pairs.emplace_back(rig, c - 1, c);
  }

  void solve(int flags) {
    for (OpenCvViews& camera : cameras) {
      camera.k = camera.distortion = cv::Mat();
      cv::calibrateCamera(camera.points, camera.pixels, camera.size, camera.k, camera.distortion,
                          camera.turns, camera.moves);
    }
    answer = {};
    std::vector<Pose> chain = {Pose()};
    for (std::size_t c = 0; c < pairs.size(); ++c) {
      OpenCvViews &a = cameras[c], &b = cameras[c + 1];
      cv::Mat k_a = a.k.clone(), d_a = a.distortion.clone(), k_b = b.k.clone(),
              d_b = b.distortion.clone(), r, t, e, f;
      cv::stereoCalibrate(pairs[c].points, pairs[c].a, pairs[c].b, k_a, d_a, k_b, d_b, a.size, r, t,
                          e, f, flags);
      Eigen::Matrix3d rotation;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) rotation(i, j) = r.at<double>(i, j);
      chain.push_back(
          Pose(nearest_rotation(rotation), {t.at<double>(0), t.at<double>(1), t.at<double>(2)}) *
          chain.back());
    }
    answer.camera_from_first = chain;
    answer.said = "answer";
  }
};

RigMethod opencv_rig(const std::string& name, const std::string& settings, int flags) {
  return {name,
          [flags](const RigTask& task) {
            return prepare_state<RigAnswer>(
                OpenCvRig(task.rig), [flags](OpenCvRig& rig) { rig.solve(flags); },
                [](const OpenCvRig& rig) { return rig.answer; });
          },
          settings +
              ", after calibrateCamera of each camera, with default flags and criteria; no "
              "standard deviations; neighbours of more than two cameras are chained"};
}

RigMethod mrcal_rig() {
  const auto answer_of = [](const std::vector<Pose>& poses) {
    RigAnswer answer;
    answer.camera_from_first = poses;
    if (!poses.empty()) answer.said = "answer";
    return answer;
  };
  const auto solve = [](const RigTask& task) {
    const Lens& lens = task.rig.cameras.front().data.truth->camera.lens;
    return calibrate_rig_by_mrcal(task.rig, parameters(lens)[0]);
  };
  return {
      "mrcal", [=](const RigTask& task) { return prepare_task<RigAnswer>(task, solve, answer_of); },
      "LENSMODEL_OPENCV5 in the three stages of its tool, all cameras together, the true f of the "
      "first given, poses by solvePnP; no outliers looked for, no regularisation, no "
      "uncertainties"};
}

}  // namespace

std::vector<RigMethod> rig_methods(const RigKind& kind) {
  const auto ours = [](const std::string& name, const std::string& settings, auto solve) {
    return RigMethod{
        name,
        [solve](const RigTask& task) { return prepare_task<RigAnswer>(task, solve, &our_answer); },
        settings};
  };
  std::vector<RigMethod> methods = {
      ours("tagcal rig",
           "opencv5 by its name, lenses and places together, clocks, moves and wrong corners "
           "looked for, with the joint covariance; one thread",
           &estimate_rig),
      ours("tagcal rig, fixed",
           "the same with the lenses of `calibrate`, whose time counts, and their covariances",
           &estimate_places),
      opencv_rig("OpenCV stereoCalibrate", "CALIB_USE_INTRINSIC_GUESS",
                 cv::CALIB_USE_INTRINSIC_GUESS),
      opencv_rig("OpenCV stereoCalibrate, fixed", "CALIB_FIX_INTRINSIC", cv::CALIB_FIX_INTRINSIC)};
  if (kind.is_grid && has_mrcal()) methods.push_back(mrcal_rig());
  return methods;
}

}  // namespace tagcal::study
