#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/boards.hpp"
#include "python/calibration.hpp"
#include "python/dataset.hpp"
#include "python/findings.hpp"
#include "python/geometry.hpp"
#include "python/records.hpp"
#include "python/uncertain_camera.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/scene/rig_pairing.hpp"

// Several cameras on one body.

namespace tagcal::python {
namespace {

using Known = std::optional<std::vector<CalibrationFile>>;

std::vector<Instant> paired(const std::string& pair, double tolerance_s,
                            const std::vector<RigCamera>& cameras) {
  if (pair == "name") return pair_by_name(cameras);
  if (pair == "index") return pair_by_index(cameras);
  if (pair == "time") return pair_by_time(cameras, tolerance_s);
  throw Error("pair: must be \"name\", \"index\" or \"time\", got \"" + pair + "\"");
}

template <typename List>
void check_count(const std::optional<List>& list, std::size_t count, const std::string& name) {
  if (list && list->size() != count)
    throw Error(name + ": must have " + std::to_string(count) + " items, one a camera, got " +
                std::to_string(list->size()));
}

RigCalibration calibrate_datasets(const std::vector<Dataset>& datasets, const std::string& model,
                                  const Names& names, const std::string& pair,
                                  const TimesByCamera& times_s, double tolerance_s,
                                  const Known& cameras, int reference, bool find_clocks,
                                  bool find_readouts, int threads) {
  check_count(cameras, datasets.size(), "cameras");
  if (reference < 0) throw Error("reference: must be >= 0, got " + std::to_string(reference));
  check_threads(threads);
  const RigDataset rig = rig_dataset(datasets, names, pair, times_s, tolerance_s);
  RigOptions options;
  options.calibrate.front().model = model;
  options.calibrate.front().num_threads = static_cast<std::size_t>(threads);
  options.reference = static_cast<std::size_t>(reference);
  options.find_clocks = find_clocks;
  options.find_readouts = find_readouts;
  if (cameras) {
    options.lenses = RigLenses::fixed;
    for (const CalibrationFile& camera : *cameras)
      options.known.push_back({uncertain_camera(camera), camera.camera_error_px.value_or(0)});
  }
  py::gil_scoped_release release;
  return calibrate_rig(rig, options);
}

std::string rig_text(const RigCalibration& rig) {
  if (!is_answer(rig.status)) return refusal(rig.status, rig.findings);
  return std::string(status_name(rig.status)) + ", " + counted(rig.cameras.size(), "camera") +
         ", " + counted(rig.instants.size(), "instant") + ", rms " + number(rig.rms_px, 3) + " px" +
         warnings_text(rig.findings);
}

void bind_pairs(py::module_& m) {
  Record<DepthUncertainty> depth(m, "DepthUncertainty",
                                 "The depth of a point on the first camera's optical axis.");
  depth.field("distance_m", &DepthUncertainty::distance_m, "Where the point is.");
  depth.field("sigma_m", &DepthUncertainty::sigma_m,
              "Its standard deviation by lenses and extrinsics, without noise of the pixels.");
  depth.field("of_lenses_m", &DepthUncertainty::of_lenses_m, "The part that the lenses cause.");
  Record<AdvisedPair> next(m, "AdvisedPair",
                           "Cameras that should see a board together, and where.");
  next.field("sentence", &AdvisedPair::sentence, "For users: \"show the board ..\".");
  next.field("a", &AdvisedPair::a, "Index of a camera.");
  next.field("b", &AdvisedPair::b, "Index of the other one.");
  next.field("distance_m", &AdvisedPair::distance_m, "Of the board from a; 0: anywhere.");
  next.field("sigma_px", &AdvisedPair::sigma_px,
             "Standard deviation of the board's projection into b by that of the places of both; "
             "infinite: nothing connects them.");
  next.representation([](const AdvisedPair& n) { return n.sentence; });
  Record<RigPair> pair(m, "RigPair", "Two cameras that have instants in common.");
  pair.field("a", &RigPair::a, "Index of a camera.");
  pair.field("b", &RigPair::b, "Index of the other one.");
  pair.field("num_instants", &RigPair::num_instants, "In common, that take part.");
  pair.field("num_corners", &RigPair::num_corners, "Seen by both at the same instant.");
  pair.field("b_from_a", &RigPair::b_from_a, "Pose.");
  pair.field("covariance", &RigPair::covariance, "(6, 6), of (omega rad, tau m) of b_from_a.");
  pair.field("baseline_m", &RigPair::baseline_m, "Distance of the cameras' centres.");
  pair.field("sigma_baseline_m", &RigPair::sigma_baseline_m, "Its standard deviation.");
  pair.field("disagreement", &RigPair::disagreement,
             "Of this pair alone with the rig, in standard deviations; 0 for two cameras.");
  pair.field("epipolar_px", &RigPair::epipolar_px,
             "RMS distance of a corner from its epipolar curve.");
  pair.field("depths", &RigPair::depths, "How far a triangulated point would be off.");
}

void bind_cameras(py::module_& m) {
  Record<RigCameraEstimate> camera(m, "RigCamera", "One camera of a calibrated rig.");
  camera.field("name", &RigCameraEstimate::name, "Its name.");
  camera.field("calibration", &RigCameraEstimate::own, "Calibration, from its own pictures alone.");
  camera.field(
      "camera", [](const RigCameraEstimate& c) { return c.camera.camera; }, "The rig's Camera.");
  camera.field("model", &RigCameraEstimate::model, "Name of the model of `camera`.");
  camera.field("claim", &RigCameraEstimate::camera,
               "The rig's camera with what is known of its lens.");
  camera.field("camera_from_rig", &RigCameraEstimate::camera_from_rig,
               "Pose; the rig's frame is that of the reference camera.");
  camera.field("covariance", &RigCameraEstimate::covariance,
               "(6, 6), of (omega rad, tau m) of camera_from_rig; zero for the reference.");
  camera.field("is_connected", &RigCameraEstimate::is_connected,
               "False: camera_from_rig has no value.");
  camera.field("num_views", &RigCameraEstimate::num_views, "That take part.");
  camera.field("num_corners", &RigCameraEstimate::num_corners, "That take part.");
  camera.field("rms_px", &RigCameraEstimate::rms_px, "sqrt(sum |r|^2 / corners).");
  camera.field("excess", &RigCameraEstimate::excess,
               "By how much the rig moves the corners from where the camera's own poses have them, "
               "beyond what noise does, over their noise. Below 0.5 the camera agrees with the "
               "others.");
  camera.representation([](const RigCameraEstimate& c) {
    return "\"" + c.name + "\" " + std::to_string(c.num_views) + " views, rms " +
           number(c.rms_px, 3) + " px" + (c.is_connected ? "" : ", not connected");
  });
}

void bind_answer(py::module_& m) {
  Record<RigCalibration> rig(m, "RigCalibration", "Cameras on one body, and how sure that is.");
  rig.field("status", &RigCalibration::status,
            "\"ok\" is an answer; \"not_connected\", \"not_synchronous\", "
            "\"extrinsic_not_observable\" and those of a Calibration are none.");
  rig.field("cameras", &RigCalibration::cameras, "In the order of the data sets.");
  rig.field("pairs", &RigCalibration::pairs, "All with common instants.");
  rig.field("rejected_instants", &RigCalibration::rejected_instants,
            "Those whose views contradict the rig, by index.");
  rig.field("groups", &RigCalibration::groups, "Of connected cameras, by index.");
  rig.field(
      "covariance", &RigCalibration::covariance,
      "Joint: of camera_from_rig of all cameras but the reference (six each), then of the free "
      "parameters of each lens.");
  rig.field("rms_px", &RigCalibration::rms_px, "sqrt(sum |r|^2 / corners).");
  rig.field("num_corners", &RigCalibration::num_corners, "That take part.");
  rig.field("next", &RigCalibration::next,
            "AdvisedPair: what would improve the answer most, or connect the cameras.");
  rig.field("findings", &RigCalibration::findings, "What the estimate found out about its data.");
  rig.field("seconds", &RigCalibration::seconds, "Wall-clock time.");
  define_file_answer(
      rig, &rig_yaml,
      "The text of a rig file, as `tagcal rig --out` writes it. Raises Error without an answer.",
      &rig_text);
}

using Views = std::vector<std::optional<View>>;

KnownRig make_known_rig(const std::vector<CameraLike>& cameras, const std::vector<PoseLike>& places,
                        const std::optional<std::vector<std::string>>& names,
                        const std::optional<ArrayLike>& covariance) {
  check_count(std::optional(places), cameras.size(), "camera_from_rig");
  check_count(names, cameras.size(), "names");
  KnownRig rig;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const CalibrationFile camera = known_camera(cameras[c], "cameras");
    rig.cameras.push_back({names ? (*names)[c] : "cam" + std::to_string(c),
                           uncertain_camera(camera), pose_of(places[c], "camera_from_rig"),
                           camera.camera_error_px});
  }
  if (covariance)
    rig.covariance =
        covariance_matrices(*covariance, "covariance", 1, rig.first_of_lens(rig.cameras.size()))
            .front();
  return rig;
}

KnownRig rig_of_answer(const RigCalibration& rig) {
  if (!is_answer(rig.status)) throw Error("known_rig: " + rig_text(rig));
  return known_rig(rig);
}

KnownRig rig_of_file(const std::filesystem::path& file) {
  py::gil_scoped_release release;
  return known_rig(read_camera_file(file), file.string());
}

RigPoseEstimate pose_of_rig(const Views& views, const TargetLike& target, const KnownRig& rig,
                            double sigma_px, bool reject_outliers, int max_iterations,
                            std::uint64_t seed) {
  const std::vector<PlacedBoard> boards = boards_of(target, "target");
  check_count(std::optional(views), rig.cameras.size(), "views");
  const PoseOptions options = pose_options(sigma_px, reject_outliers, max_iterations, seed);
  py::gil_scoped_release release;
  std::vector<ViewCorrespondences> seen(views.size());
  for (std::size_t c = 0; c < views.size(); ++c)
    if (views[c]) seen[c] = view_correspondences(*views[c], boards, rig.cameras[c].camera_error_px);
  return estimate_rig_pose(seen, rig, options);
}

void bind_known(py::module_& m) {
  Record<KnownRig::Member> member(m, "RigMember", "One camera of a known rig.");
  member.field("name", &KnownRig::Member::name, "Its name.");
  member.field(
      "camera", [](const KnownRig::Member& c) { return c.camera.camera; }, "The Camera.");
  member.field(
      "claim",
      [](const KnownRig::Member& c) {
        return c.camera.model ? std::optional(c.camera) : std::nullopt;
      },
      "What is known of its lens; None: taken as exact.");
  member.field("camera_from_rig", &KnownRig::Member::camera_from_rig, "Pose.");
  member.field("camera_error_px", &KnownRig::Member::camera_error_px,
               "Error of a projection besides the corners' noise; None: unknown.");
  Record<KnownRig> rig(m, "KnownRig", "Cameras at known places on one body.");
  rig.field("cameras", &KnownRig::cameras, "A list of RigMember.");
  rig.field(
      "covariance", &KnownRig::covariance,
      "Of (omega rad, tau m) of all camera_from_rig in turn, then of the free parameters of all "
      "lenses; (0, 0): places and lenses are taken as exact.");
  rig.representation([](const KnownRig& r) { return counted(r.cameras.size(), "camera"); });
  rig.def(py::init(&make_known_rig), py::arg("cameras"), py::arg("camera_from_rig"),
          py::arg("names") = py::none(), py::arg("covariance") = py::none(),
          "Of cameras (Camera, UncertainCamera or Calibration) and their places.");
}

void bind_rig_pose(py::module_& m) {
  Record<RigPoseEstimate> pose(m, "RigPoseEstimate", "The pose of a rig before a target.");
  pose.field("rig", &RigPoseEstimate::rig,
             "PoseEstimate; `camera_from_target` is rig_from_target. Its covariance includes that "
             "of places and lenses.");
  pose.field("of_cameras", &RigPoseEstimate::of_cameras,
             "PoseEstimate of each camera alone; \"degenerate\" if it sees nothing.");
  pose.field(
      "takes_part",
      [](const RigPoseEstimate& e) {
        return std::vector<bool>(e.takes_part.begin(), e.takes_part.end());
      },
      "By camera.");
  pose.representation([](const RigPoseEstimate& e) {
    return std::string(status_name(e.rig.status)) + ", by " +
           counted(static_cast<std::size_t>(std::ranges::count(e.takes_part, 1)), "camera");
  });
}

void define_rig_poses(py::module_& m) {
  m.def("known_rig", &rig_of_answer, py::arg("rig"),
        "The rig of a RigCalibration, or of a file that `tagcal rig --out` or another program "
        "wrote, for `estimate_rig_pose`.");
  m.def("known_rig", &rig_of_file, py::arg("rig"), "The same.");
  m.def(
      "estimate_rig_pose", &pose_of_rig, py::arg("views"), py::arg("target"), py::arg("rig"),
      py::arg("sigma_px") = 0.0, py::arg("reject_outliers") = true, py::arg("max_iterations") = 50,
      py::arg("seed") = 0,
      "The pose of a rig before a target, from all of its cameras at one instant. `views`: a View "
      "of each camera, None if it has none. Cameras that contradict the others take no part "
      "(\"camera_contradicts\"); of two there is then no answer (\"pair_contradicts\").");
}

}  // namespace

RigDataset rig_dataset(const std::vector<Dataset>& datasets, const Names& names,
                       const std::string& pair, const TimesByCamera& times_s, double tolerance_s) {
  const std::size_t n = datasets.size();
  check_count(names, n, "names");
  check_count(times_s, n, "times_s");
  RigDataset rig;
  for (std::size_t c = 0; c < n; ++c)
    rig.cameras.push_back({names ? (*names)[c] : "cam" + std::to_string(c), datasets[c],
                           times_s ? (*times_s)[c] : std::vector<double>()});
  rig.instants = paired(pair, tolerance_s, rig.cameras);
  return rig;
}

void bind_rig(py::module_& m) {
  bind_pairs(m);
  bind_cameras(m);
  bind_answer(m);
  bind_known(m);
  bind_rig_pose(m);
  define_rig_poses(m);
  m.def(
      "calibrate_rig", &calibrate_datasets, py::arg("datasets"), py::arg("model") = "auto",
      py::kw_only(), py::arg("names") = py::none(), py::arg("pair") = "name",
      py::arg("times_s") = py::none(), py::arg("tolerance_s") = 0.005,
      py::arg("cameras") = py::none(), py::arg("reference") = 0, py::arg("find_clocks") = false,
      py::arg("find_readouts") = false, py::arg("threads") = 1,
      "Cameras on one body that see the same boards: their lenses and places, from one Dataset "
      "a camera.\n\n"
      "model: of all cameras, as in `calibrate`.\n"
      "pair: which views belong together: equal names of pictures, but for a part that is the "
      "camera's own (\"name\"), \"index\", or the nearest of the stamps times_s, at most "
      "tolerance_s apart (\"time\").\n"
      "cameras: an UncertainCamera each, to hold the lenses; their covariances enter the answer.\n"
      "reference: the camera whose frame is that of the rig.\n"
      "find_clocks: correct each view for the time between its stamp and its instant, with one "
      "offset a camera.\n"
      "find_readouts: estimate how long the rows of each camera take, from the motion that times_s "
      "show (`calibration.readout`), and take it out of the corners.\n"
      "threads: 0: one per core; the answer does not depend on it.");
}

}  // namespace tagcal::python
