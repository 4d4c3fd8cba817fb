#include "tagcal/estimate/calibrate_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/calibration/readout_rounds.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/pose/corner_noise.hpp"
#include "tagcal/estimate/rig/rig_advice.hpp"
#include "tagcal/estimate/rig/rig_claims.hpp"
#include "tagcal/estimate/rig/rig_clocks.hpp"
#include "tagcal/estimate/rig/rig_findings.hpp"
#include "tagcal/estimate/rig/rig_readouts.hpp"
#include "tagcal/estimate/rig/rig_report.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

void check_rig(const RigDataset& rig, const RigOptions& options) {
  const std::size_t n = rig.cameras.size();
  if (n == 0) throw Error("rig: has no cameras");
  if (options.reference >= n)
    throw Error(fmt::format("reference: must be below {}, the number of cameras, got {}", n,
                            options.reference));
  if (options.calibrate.size() != 1 && options.calibrate.size() != n)
    throw Error(fmt::format("calibrate: must have options for one camera or for {}, got {}", n,
                            options.calibrate.size()));
  for (const CalibrateOptions& of_camera : options.calibrate)
    if (!of_camera.times_s.empty())
      throw Error("calibrate: times_s: must be empty: a rig has the stamps of its cameras");
  for (const RigCamera& camera : rig.cameras) {
    const std::size_t stamps = camera.times_s.size();
    const bool needs_stamps = options.find_clocks || options.find_readouts;
    if (stamps != camera.data.views.size() && (stamps > 0 || needs_stamps))
      throw Error(fmt::format("{}: needs a stamp for each of its {} views, got {}", camera.name,
                              camera.data.views.size(), stamps));
  }
  const bool fixed = options.lenses == RigLenses::fixed;
  if (options.known.size() != (fixed ? n : 0))
    throw Error(
        fmt::format("known: must have {} cameras, got {}", fixed ? n : 0, options.known.size()));
  for (const Instant& instant : rig.instants) {
    if (instant.view.size() != n)
      throw Error(fmt::format("instants: must have {} views, got {}", n, instant.view.size()));
    for (std::size_t c = 0; c < n; ++c)
      if (instant.view[c] && *instant.view[c] >= rig.cameras[c].data.views.size())
        throw Error(rig.cameras[c].name + ": an instant names a view that it does not have");
  }
  const auto points = points_in_world(rig.cameras.front().data.boards);
  for (const RigCamera& camera : rig.cameras)
    if (points_in_world(camera.data.boards) != points)
      throw Error(camera.name + ": its boards must be those of " + rig.cameras.front().name);
}

// The poses of all views under a lens that is known, in place of a calibration.
Calibration calibration_by(const RigOptions::KnownCamera& known, const Dataset& data,
                           std::size_t num_threads) {
  ViewPoses poses = poses_of_views(data, known.camera.camera, known.error_px, num_threads);
  Calibration own;
  own.camera = known.camera.camera;
  if (known.camera.model) own.claim = known.camera;
  own.model_error_px = known.error_px;
  own.status = poses.views.empty() ? Status::degenerate : Status::ok;
  own.views = std::move(poses.views);
  own.outliers = std::move(poses.outliers);
  own.rms_px = poses.rms_px;
  CornerNoise noise;
  for (const View& view : data.views) noise.add(view);
  own.sigma_of_corners = noise.counts();
  own.sigma_px = noise.counts() ? 1 : poses.sigma_px;
  own.sigma_from_residuals = poses.sigma_from_residuals;
  own.findings = std::move(poses.findings);
  if (!known.camera.model) return own;
  if (auto finding = contradiction_of_camera(data, known.camera, num_threads))
    own.findings.push_back(*std::move(finding));
  return own;
}

const CalibrateOptions& options_of(const RigOptions& options, std::size_t camera) {
  return options.calibrate[options.calibrate.size() == 1 ? 0 : camera];
}

// The camera that is given for the pictures of one; null if none is.
const Camera* given_camera(const RigOptions& options, std::size_t c) {
  if (options.lenses == RigLenses::fixed) return &options.known[c].camera.camera;
  const std::optional<Camera>& start = options_of(options, c).start;
  return start ? &*start : nullptr;
}

void report_swapped(const RigDataset& rig, std::size_t a, std::size_t b, const char* what,
                    RigCalibration& answer) {
  add(answer.findings, code::sizes_swapped,
      fmt::format("the pictures of {} have the {} of the camera that is given for {}: the folders "
                  "or the camera files are exchanged",
                  rig.cameras[a].name, what, rig.cameras[b].name));
}

// Pictures that have the image size of the camera that is given for others. Throws Error for a size
// that no given camera has.
void check_sizes(const RigDataset& rig, const RigOptions& options, RigCalibration& answer) {
  for (std::size_t c = 0; c < rig.cameras.size() && answer.findings.empty(); ++c) {
    const ImageSize& size = rig.cameras[c].data.image_size;
    const auto has_size = [&](std::size_t other) {
      const Camera* const given = given_camera(options, other);
      return given && given->image_size == size;
    };
    if (!given_camera(options, c) || has_size(c)) continue;
    for (std::size_t other = 0; other < rig.cameras.size() && answer.findings.empty(); ++other)
      if (has_size(other)) report_swapped(rig, c, other, "image size", answer);
    if (answer.findings.empty())
      throw Error(rig.cameras[c].name + ": the known camera must have its image size");
  }
}

double median_rms(const std::vector<CalibratedView>& views) {
  std::vector<double> rms;
  for (const CalibratedView& view : views) rms.push_back(view.rms_px);
  return rms.empty() ? 0 : median(rms);
}

// Two known cameras of one image size, each of which fits the pictures of the other better.
void check_lenses(const RigDataset& rig, const RigOptions& options,
                  const std::vector<Calibration>& own, RigCalibration& answer) {
  constexpr std::size_t kFew = 3;    // numeric: views that tell most lenses apart
  constexpr std::size_t kMany = 20;  // numeric: and those that differ by 1 or 2 % in f
  // The score of the noise of views of one camera under its own lens over that under another.
  const auto score = [&](std::size_t c, std::size_t other, std::size_t num_views) {
    Dataset few = rig.cameras[c].data;
    few.views.clear();
    int num_residuals = 0;
    for (const std::size_t v : spread_indices(rig.cameras[c].data.views.size(), num_views)) {
      few.views.push_back(rig.cameras[c].data.views[v]);
      num_residuals += 2 * static_cast<int>(few.views.back().observations.size());
    }
    const double mine = median_rms(own[c].views);
    const double its = median_rms(
        poses_of_views(few, options.known[other].camera.camera, options.known[other].error_px)
            .views);
    return its > 0 && mine > its
               ? variance_ratio_score(mine * mine / (its * its), num_residuals, num_residuals)
               : 0;
  };
  for (std::size_t a = 0; options.lenses == RigLenses::fixed && a < own.size(); ++a)
    for (std::size_t b = a + 1; b < own.size() && answer.findings.empty(); ++b)
      if (rig.cameras[a].data.image_size == rig.cameras[b].data.image_size &&
          score(a, b, kFew) > 0 && score(b, a, kFew) > 0 &&
          score(a, b, kMany) > policy::kOutlierSigmas &&
          score(b, a, kMany) > policy::kOutlierSigmas)
        report_swapped(rig, a, b, "lens", answer);
}

// A camera's own calibration, and its corners.
struct OwnCamera {
  Calibration own;
  std::optional<Dataset> still;  // without the motion during the readout, where that is seen
};

OwnCamera own_camera(const PlacedViews& views, const RigOptions& options, std::size_t c) {
  const Dataset& data = views.data->cameras[c].data;
  const bool fixed = options.lenses == RigLenses::fixed;
  OwnCamera result;
  CalibrateOptions by_times = options_of(options, c);
  if (options.find_readouts) {
    by_times.times_s = film_times(views, c);
    if (fixed) by_times.start = options.known[c].camera.camera;
  }
  if (!fixed || options.find_readouts) result.own = calibrate(data, by_times);
  if (result.own.readout && result.own.readout->is_seen)
    result.still = without_motion(data, by_times.times_s, result.own);
  if (!fixed) return result;
  const Calibration timed = std::move(result.own);
  result.own =
      calibration_by(options.known[c], result.still ? *result.still : data, by_times.num_threads);
  result.own.readout = timed.readout;
  std::ranges::copy_if(timed.findings, std::back_inserter(result.own.findings), is_of_shutter);
  return result;
}

// The cameras' own calibrations; none if the pictures have the sizes of other cameras. Takes the
// motion during the readouts out of the corners of the views.
std::vector<Calibration> own_calibrations(PlacedViews& views, const RigOptions& options,
                                          RigCalibration& answer) {
  const std::shared_ptr<const RigDataset> given = views.data;
  const RigDataset& rig = *given;
  for (const RigCamera& camera : rig.cameras) answer.cameras.push_back({camera.name});
  check_sizes(rig, options, answer);
  std::vector<Calibration> own;
  if (!answer.findings.empty()) return own;
  std::shared_ptr<RigDataset> still;
  const bool fixed = options.lenses == RigLenses::fixed;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    OwnCamera camera = own_camera(views, options, c);
    own.push_back(std::move(camera.own));
    if (camera.still && !still) still = std::make_shared<RigDataset>(rig);
    if (camera.still) still->cameras[c].data = *std::move(camera.still);
    answer.cameras[c].own = own[c];
    answer.cameras[c].error_px = fixed ? options.known[c].error_px : camera_error_px(own[c]);
  }
  if (still) views.data = still;
  check_lenses(*views.data, options, own, answer);
  report_unanswered(options.lenses, answer);
  report_cameras(fixed, answer);
  return own;
}

// Views without an instant, and of cameras and boards that nothing connects with the reference,
// inform their lens only.
void set_unconnected_alone(RigState& state, const RigStart& start) {
  for (std::size_t c = 0; c < state.cameras.size(); ++c)
    for (std::size_t v = 0; v < state.instant[c].size(); ++v)
      if (!state.instant[c][v] || !start.has(c) ||
          !start.connected.boards[state.poses.links[c][v].board])
        state.set_alone(c, v);
}

void set_cameras(const RigState& state, const SolvedRig& solved, RigCalibration& answer) {
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const Bundle& bundle = state.cameras[c];
    UncertainCamera& camera = answer.cameras[c].camera;
    camera.camera = {bundle.lens(), bundle.image_size};
    answer.cameras[c].model = full_model(bundle.lens()).name();
    const std::optional<UncertainCamera>& claim = answer.cameras[c].own.claim;
    if (!claim || !claim->model) continue;
    const Index k = claim->model->num_free();
    answer.cameras[c].model = claim->model->name();
    camera.model = claim->model;
    camera.covariance = solved.covariance.block(solved.layout.lens[c], solved.layout.lens[c], k, k);
  }
}

// Places the cameras, and tests their clocks and places.
RigStart place_cameras(const RigDataset& rig, const RigOptions& options, RigState& state,
                       RigCalibration& answer) {
  RigStart start = start_rig(state, half_turn_of(rig.cameras.front().data.boards));
  answer.groups = groups_of(state, start);
  report_groups(rig, state, answer);
  set_unconnected_alone(state, start);
  report_turned(start, answer);
  if (options.find_clocks) {
    take_stamps(rig, state);
    for (const ClockFit& fit : correct_clocks_and_lenses(options, state, start))
      answer.clocks.push_back(fit.clock);
  } else {
    // A camera's own lens may be known badly: where it shows nothing, that of the bundle is asked.
    answer.clocks = find_clocks_off(options, state, start);
    take_first_bundle(state, options);
    if (answer.clocks.empty()) answer.clocks = find_clocks_off(options, state, start);
  }
  report_clocks(rig, options.find_clocks, tells_offset(state), answer);
  if (answer.clocks.empty()) report_shifts(rig, start, answer);
  // Cameras that are not synchronous seem to move.
  if (is_answer(judge(answer.findings))) report_moves(rig, separate_moves(state, start), answer);
  return start;
}

// Adds the findings of the bundle's minimum.
void report_minimum(const RigState& state, const RigSolution& solution, bool has_covariance,
                    RigCalibration& answer) {
  if (has_covariance)
    report_unobservable(state, answer);
  else
    add(answer.findings, code::extrinsic_not_observable,
        "the instants do not determine the places of the cameras: take more, with tilted boards");
  if (!solution.summary.converged)
    add(answer.findings, code::not_converged, "the bundle of the rig found no minimum");
  if (answer.pairs.size() == 1 && answer.pairs.front().num_instants == 1)
    add(answer.findings, code::single_instant,
        "one instant connects the cameras: nothing tests the answer; take more");
}

// Fills in all that the rig says beyond its cameras' own calibrations.
void solve_rig(const PlacedViews& views, const RigOptions& options, RigState& state,
               RigCalibration& answer) {
  const RigDataset& rig = *views.data;
  const RigStart start = place_cameras(rig, options, state, answer);
  const RigSolution solution = solve_robustly(state, options.calibrate.front());
  answer.num_iterations = solution.num_iterations;
  answer.rejected_instants = solution.rejected;

  const RigState of_claims = state_of_claims(state, answer);
  SolvedRig solved{&rig, &state, start, RigLayout(of_claims, start.connected), MatrixXd()};
  const MatrixXd by_readouts =
      covariance_by_readouts(state, views, solved.layout, answer, options.calibrate.front());
  auto covariance = joint_covariance(state, of_claims, solved.layout, answer, options);
  if (covariance) *covariance += by_readouts;
  solved.covariance = covariance.value_or(MatrixXd::Zero(solved.layout.size, solved.layout.size));
  set_cameras(state, solved, answer);
  report_rig(solved, answer);
  answer.covariance = solved.covariance;
  report_contradictions(rig, state, solution, answer);
  report_minimum(state, solution, covariance.has_value(), answer);
  answer.status = judge(answer.findings);
  if (!is_answer(answer.status) && answer.status != Status::extrinsic_not_observable) return;
  add_scale(state, solved.layout, -1, solved.covariance);  // which no view tells
  answer.next = advised_pair(solved);
}

}  // namespace

RigCalibration calibrate_rig(const RigDataset& given, const RigOptions& options) {
  const Stopwatch stopwatch;
  check_rig(given, options);
  PlacedViews views = options.find_boards ? views_of_boards(given) : views_of_world(given);
  RigCalibration answer;
  const std::vector<Calibration> own = own_calibrations(views, options, answer);
  answer.status = judge(answer.findings);
  if (!is_answer(answer.status)) return answer;
  RigState state = rig_state(views, own, options.lenses);
  state.poses.reference = options.reference;
  solve_rig(views, options, state, answer);
  answer.seconds = stopwatch.seconds();
  return answer;
}

}  // namespace tagcal
