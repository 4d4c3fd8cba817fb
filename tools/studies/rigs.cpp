// Random rigs with defects: what calibrate_rig answers, and whether its claims hold
// (docs/trust/how_sure.md).
// 2 to 6 cameras, 10 to 50 instants, noise of 0.03 to 0.5 px. `wrong`: a number of an extrinsic is
// beyond 5 of its standard deviations, and no warning says why. NEES: of all extrinsics, over their
// number. The pair of `stereoCalibrate` has the same corners, all instants, and the lenses free,
// from OpenCV's own calibrations of both cameras, whose time counts too.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "rig_worlds.hpp"
#include "studies/studies.hpp"
#include "study/processor_time.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr double kWrongSd = 5;

struct RigCase {
  RigWorldOptions world;
  Board board = usual_board();
};

RigCase usual_rig(Random& random) {
  RigCase rig;
  rig.world.num_cameras = 2 + static_cast<int>(random.uniform(0, 4.999));
  rig.world.num_instants = 10 + static_cast<int>(random.uniform(0, 40));
  rig.world.sigma_px = std::exp(random.uniform(std::log(0.03), std::log(0.5)));
  rig.world.with_covariances = random.uniform() < 0.5;
  rig.world.smooth = random.uniform() < 0.5;
  rig.world.seen_share = random.uniform(0.6, 1);
  return rig;
}

int other_than_first(const RigCase& rig, Random& random) {
  return 1 + static_cast<int>(random.uniform(0, rig.world.num_cameras - 1.001));
}

// A camera whose pictures are later by a part of the time between instants, or by whole ones.
RigCase rig_out_of_time(Random& random) {
  RigCase rig = usual_rig(random);
  rig.world.smooth = true;
  rig.world.offset.assign(static_cast<std::size_t>(rig.world.num_cameras), 0);
  const double sign = random.uniform() < 0.5 ? -1 : 1;
  rig.world.offset[static_cast<std::size_t>(other_than_first(rig, random))] =
      sign * (random.uniform() < 0.5 ? random.uniform(0.05, 1) : std::ceil(random.uniform(0, 3)));
  return rig;
}

RigCase rig_with_moved_camera(Random& random) {
  RigCase rig = usual_rig(random);
  rig.world.moved_camera = other_than_first(rig, random);
  rig.world.moved_m = std::exp(random.uniform(std::log(0.001), std::log(0.05)));
  return rig;
}

RigCase rig_with_turned_boards(Random& random) {
  RigCase rig = usual_rig(random);
  rig.world.turned_share = random.uniform(0, 0.5);
  rig.board = make_board(Checkerboard{8, 6, 0.06, 0.06});
  return rig;
}

RigCase rig_of_wrong_pairs(Random& random) {
  RigCase rig = usual_rig(random);
  rig.world.shuffled = true;
  return rig;
}

RigCase rig_of_few_instants(Random& random) {
  RigCase rig = usual_rig(random);
  rig.world.num_instants = 3 + static_cast<int>(random.uniform(0, 7));
  return rig;
}

// The largest error of a number of an extrinsic, in its standard deviations.
double worst_sd(const RigDataset& rig, const RigCalibration& answer) {
  double worst = 0;
  for (std::size_t c = 1; c < answer.cameras.size(); ++c) {
    const RigCameraEstimate& camera = answer.cameras[c];
    const Vector6d error = minus(rig.truth->camera_from_rig[c], camera.camera_from_rig);
    for (int i = 0; i < 6; ++i)
      worst = std::max(worst, std::abs(error[i]) / std::sqrt(camera.covariance(i, i)));
  }
  return worst;
}

bool warns(const RigCalibration& answer) {
  return std::ranges::any_of(answer.findings, [](const Finding& f) {
    return f.severity == Severity::warning && f.code != "corner_order_differs";
  });
}

std::vector<Values> measure_rig(RigCase (*draw)(Random&), std::uint64_t seed) {
  Random random(seed, 5);
  const RigCase rig_case = draw(random);
  const RigDataset rig = make_rig_world(seed, rig_case.world, rig_case.board);
  RigCalibration answer;
  const double us = processor_us([&] { answer = calibrate_rig(rig); });
  std::string what(status_name(answer.status));
  double nees = std::nan("");
  if (is_answer(answer.status)) {
    nees = nees_of_extrinsics(rig, answer);
    if (worst_sd(rig, answer) > kWrongSd) what = warns(answer) ? "warned" : "wrong";
    if (warns(answer)) nees = std::nan("");
  }
  return {{what, nees, 1e-3 * us}};
}

// The corners of the views of an instant that both cameras see, as OpenCV takes them.
struct StereoPoints {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> a, b;
};

StereoPoints stereo_points(const RigDataset& rig) {
  StereoPoints stereo;
  const auto points = points_in_world(rig.cameras.front().data.boards);
  for (const Instant& instant : rig.instants) {
    if (!instant.view[0] || !instant.view[1]) continue;
    std::map<CornerId, Eigen::Vector2d> in_a;
    for (const Observation& o : rig.cameras[0].data.views[*instant.view[0]].observations)
      in_a[o.id] = o.pixel;
    stereo.points.emplace_back();
    stereo.a.emplace_back();
    stereo.b.emplace_back();
    for (const Observation& o : rig.cameras[1].data.views[*instant.view[1]].observations) {
      const auto other = in_a.find(o.id);
      if (other == in_a.end()) continue;
      const Eigen::Vector3f x = points.at(o.id).cast<float>();
      stereo.points.back().emplace_back(x.x(), x.y(), x.z());
      stereo.a.back().emplace_back(static_cast<float>(other->second.x()),
                                   static_cast<float>(other->second.y()));
      stereo.b.back().emplace_back(static_cast<float>(o.pixel.x()),
                                   static_cast<float>(o.pixel.y()));
    }
  }
  return stereo;
}

// Rotation (degrees) and translation (mm) of an answer against the truth.
std::pair<double, double> errors_of(const RigDataset& rig, const Pose& b_from_a) {
  const Pose& truth = rig.truth->camera_from_rig[1];
  return {angle_between_rad(truth, b_from_a) * 180 / std::numbers::pi,
          1e3 * distance_between_m(truth, b_from_a)};
}

// Two perspectives and 40 instants, beside cv::stereoCalibrate.
std::vector<Values> measure_pair(std::uint64_t seed) {
  RigWorldOptions world;
  world.num_instants = 40;
  world.fisheyes = false;
  const RigDataset rig = make_rig_world(seed, world);
  RigCalibration answer;
  RigOptions options;
  options.calibrate.front().model = "opencv5";
  const double auto_us = processor_us([&] { answer = calibrate_rig(rig); });
  const double named_us = processor_us([&] { calibrate_rig(rig, options); });
  const StereoPoints stereo = stereo_points(rig);
  const cv::Size size(1280, 800);
  cv::Mat k1, d1, k2, d2, r, t, e, f;
  const double peer_us = processor_us([&] {
    std::vector<cv::Mat> rvecs, tvecs;
    cv::calibrateCamera(stereo.points, stereo.a, size, k1, d1, rvecs, tvecs);
    cv::calibrateCamera(stereo.points, stereo.b, size, k2, d2, rvecs, tvecs);
    cv::stereoCalibrate(stereo.points, stereo.a, stereo.b, k1, d1, k2, d2, size, r, t, e, f,
                        cv::CALIB_USE_INTRINSIC_GUESS);
  });
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) rotation(i, k) = r.at<double>(i, k);
  const Pose peer(nearest_rotation(rotation), {t.at<double>(0), t.at<double>(1), t.at<double>(2)});
  const auto ours = errors_of(rig, answer.cameras[1].camera_from_rig);
  const auto theirs = errors_of(rig, peer);
  return {{1e-3 * auto_us, 1e-3 * named_us, 1e-3 * peer_us, ours.first, ours.second, theirs.first,
           theirs.second}};
}

Task rigs_task(const std::string& name, RigCase (*draw)(Random&)) {
  return {name, [draw](std::uint64_t seed) { return measure_rig(draw, seed); }};
}

}  // namespace

Study rigs_study() {
  return {.name = "rigs",
          .summary = "random rigs with defects: answers, and whether their claims hold",
          .count = 1000,
          .columns = {"answer", "nees", "ms"},
          .tasks =
              [](const StudyOptions&) {
                return std::vector<Task>{rigs_task("no defect", usual_rig),
                                         rigs_task("few instants", rig_of_few_instants),
                                         rigs_task("out of time", rig_out_of_time),
                                         rigs_task("camera moved", rig_with_moved_camera),
                                         rigs_task("boards turned", rig_with_turned_boards),
                                         rigs_task("wrong pairs", rig_of_wrong_pairs)};
              },
          .tables = {{{"task"},
                      {rows_in("rigs"), counts_of("answers", "answer"), mean_of("NEES", "nees", 2),
                       mean_of("CPU ms", "ms", 0)}}}};
}

Study stereo_study() {
  return {
      .name = "stereo",
      .summary = "pairs of cameras, beside cv::stereoCalibrate",
      .count = 20,
      .columns = {"auto_ms", "named_ms", "opencv_ms", "deg", "mm", "opencv_deg", "opencv_mm"},
      .tasks =
          [](const StudyOptions&) {
            return std::vector<Task>{{"two cameras, 40 instants", measure_pair}};
          },
      .tables = {{{"task"},
                  {rows_in("pairs"), mean_of("auto, ms", "auto_ms", 1),
                   mean_of("opencv5, ms", "named_ms", 1), mean_of("OpenCV, ms", "opencv_ms", 0),
                   ratio_of("OpenCV / opencv5", "opencv_ms", "named_ms", 1),
                   rms_of("deg", "deg", 4), rms_of("mm", "mm", 3),
                   rms_of("OpenCV, deg", "opencv_deg", 4), rms_of("OpenCV, mm", "opencv_mm", 3)}}}};
}

}  // namespace tagcal
