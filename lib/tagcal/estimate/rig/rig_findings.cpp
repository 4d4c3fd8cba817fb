#include "tagcal/estimate/rig/rig_findings.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/rig/rig_advice.hpp"
#include "tagcal/internal/degrees.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

std::string names_of(const RigDataset& rig, const std::vector<std::size_t>& cameras) {
  std::string names;
  for (const std::size_t c : cameras)
    names += (names.empty() ? "" : c == cameras.back() ? " and " : ", ") + rig.cameras[c].name;
  return names;
}

// "cam1: 12.3 +- 0.5 ms"
std::string offset_of(const RigDataset& rig, const ClockOffset& clock) {
  return rig.cameras[clock.camera].name + ": " + offset_text(clock);
}

std::string strain_of(const RigCameraEstimate& camera) {
  return fmt::format(
      "the rig moves the corners of {} by {:.2g} times their noise: its pictures were "
      "taken at other times than those of the others, the cameras are not rigid, or a lens that "
      "was "
      "given is not its own",
      camera.name, camera.excess);
}

}  // namespace

bool is_of_shutter(const Finding& finding) {
  return finding.code == code::rolling_shutter.name ||
         finding.code == code::readout_not_observable.name;
}

void report_unanswered(RigLenses lenses, RigCalibration& answer) {
  for (const RigCameraEstimate& camera : answer.cameras) {
    const Calibration& own = camera.own;
    const bool has_lens = is_answer(own.status) && own.camera && own.model != "weak";
    if (has_lens) continue;
    if (lenses == RigLenses::fixed) {
      add(answer.findings, code::camera_without_answer,
          camera.name +
              ": no view of it has a pose under the camera that is given for it: it is the file of "
              "another camera, its lens changed, or the board is not that of the target file");
      continue;
    }
    const auto reason = std::ranges::find_if(own.findings, is_refusal);
    add(answer.findings, code::camera_without_answer,
        fmt::format(
            "{}: its own pictures do not calibrate it ({}): take more views with it, or give "
            "its camera file",
            camera.name,
            reason == own.findings.end() ? std::string(status_name(own.status))
                                         : reason->sentence));
  }
}

void report_cameras(bool are_known, RigCalibration& answer) {
  for (const RigCameraEstimate& camera : answer.cameras)
    for (const Finding& finding : camera.own.findings)
      if (are_known || is_of_shutter(finding))
        answer.findings.emplace_back(finding).sentence = camera.name + ": " + finding.sentence;
}

void report_moves(const RigDataset& rig, const std::vector<CameraMove>& moves,
                  RigCalibration& answer) {
  for (const CameraMove& move : moves)
    add(answer.findings, code::camera_moved,
        fmt::format(
            "{} moved against the others at instant {}, by {:.2g} mm and {:.2g} degrees: the "
            "answer is of the longer part; fasten it and calibrate again",
            rig.cameras[move.camera].name, move.instant, 1e3 * move.step.tail<3>().norm(),
            degrees(move.step.head<3>().norm())));
}

void report_shifts(const RigDataset& rig, const RigStart& start, RigCalibration& answer) {
  for (const InstantShift& shift : start.shifts)
    add(answer.findings, code::not_synchronous,
        fmt::format("{} fits the others {} instants {}: the pictures of an instant were not taken "
                    "at the same time; check the pairing, or record with a common trigger",
                    rig.cameras[shift.camera].name, std::abs(shift.instants),
                    shift.instants > 0 ? "later" : "earlier"));
}

void report_clocks(const RigDataset& rig, bool corrected, bool tells_offset,
                   RigCalibration& answer) {
  for (const ClockOffset& clock : answer.clocks) {
    if (corrected)
      add(answer.findings, code::clock_corrected,
          fmt::format("{} later than its stamps say; corrected", offset_of(rig, clock)));
    else
      add(answer.findings, code::not_synchronous,
          fmt::format("{} the others of the same instants: record with a common trigger, "
                      "hold the board still for each picture, or have stamps corrected (--pair "
                      "time:find)",
                      tells_offset ? offset_of(rig, clock) + " later than"
                                   : rig.cameras[clock.camera].name +
                                         " took its pictures at other times than"));
  }
}

void report_groups(const RigDataset& rig, const RigState& state, RigCalibration& answer) {
  if (answer.groups.size() < 2) return;
  std::string others;
  for (std::size_t g = 1; g < answer.groups.size(); ++g)
    others += (g == 1 ? "" : ", nor with ") + names_of(rig, answer.groups[g]);
  std::string advice = "show the board to a camera of each group at the same time";
  if (const auto near = nearest_views(state, answer.groups)) {
    const std::string pair = names_of(rig, {near->a, near->b});
    advice = fmt::format("{}; nearest are {}, at the instants {} and {}, {:.3g} {} apart", advice,
                         pair, near->instant_a, near->instant_b, near->apart,
                         state.has_stamps   ? "s"
                         : near->apart == 1 ? "instant"
                                            : "instants");
    answer.next = {near->a, near->b, 0, std::numeric_limits<double>::infinity(),
                   fmt::format("show the board to {} at the same time", pair)};
  }
  add(answer.findings, code::not_connected,
      fmt::format("no instant connects {} with {}: {}", names_of(rig, answer.groups.front()),
                  others, advice));
}

void report_contradictions(const RigDataset& rig, const RigState& state,
                           const RigSolution& solution, RigCalibration& answer) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCameraEstimate& camera = answer.cameras[c];
    const int rejected = solution.num_rejected[c];
    if (rejected > 0 && policy::is_above(rejected, policy::kMinority, rejected + camera.num_views))
      add(answer.findings, code::pair_contradicts,
          fmt::format("{} of {} instants of {} contradict the others: its pictures were taken at "
                      "other times, or belong to another rig",
                      rejected, rejected + camera.num_views, camera.name));
    else if (camera.excess > policy::kOutlierSigmas)
      add(answer.findings, code::pair_contradicts, strain_of(camera));
    else if (camera.excess > policy::kStrained)
      add(answer.findings, code::instants_strained,
          strain_of(camera) + "; the standard deviations include this");
  }
  if (!answer.rejected_instants.empty())
    add(answer.findings, code::instants_rejected,
        fmt::format("{} of {} instants contradict the rig and are not used: the board or a camera "
                    "moved between the pictures",
                    answer.rejected_instants.size(), state.num_instants));
}

void report_unobservable(const RigState& state, RigCalibration& answer) {
  for (std::size_t c = 0; c < answer.cameras.size(); ++c) {
    const RigCameraEstimate& camera = answer.cameras[c];
    if (!camera.is_connected || c == state.poses.reference || state.own[c].empty()) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of_turn(
        Eigen::Matrix3d(camera.covariance.topLeftCorner<3, 3>()));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of_shift(
        Eigen::Matrix3d(camera.covariance.bottomRightCorner<3, 3>()));
    const double turn = std::sqrt(std::max(0.0, of_turn.eigenvalues()[2]));
    const double shift = std::sqrt(std::max(0.0, of_shift.eigenvalues()[2]));
    const bool is_turn = turn > policy::kFocalRefused;
    if (!is_turn && shift <= policy::kFocalRefused * median(distances_m(state.cameras[c])))
      continue;
    const Eigen::Vector3d axis = (is_turn ? of_turn : of_shift).eigenvectors().col(2);
    add(answer.findings, code::extrinsic_not_observable,
        fmt::format(
            "the {} of {} {} the axis ({:.2f}, {:.2f}, {:.2f}) of its frame is not known (its "
            "standard deviation is {}): no view is common that tells it, or the rig turned "
            "about one axis only",
            is_turn ? "rotation" : "place", camera.name, is_turn ? "about" : "along", axis.x(),
            axis.y(), axis.z(),
            is_turn ? fmt::format("{:.2g} degrees", degrees(turn))
                    : fmt::format("{:.2g} m", shift)));
  }
}

void report_turned(const RigStart& start, RigCalibration& answer) {
  if (start.turned.empty()) return;
  add(answer.findings, code::corner_order_differs,
      fmt::format("the corners of {} views have the order of the board turned by half a turn and "
                  "were exchanged",
                  start.turned.size()));
}

}  // namespace tagcal::internal

namespace tagcal {

std::string offset_text(const ClockOffset& clock) {
  return clock.in_seconds
             ? fmt::format("{:.3g} +- {:.2g} ms", 1e3 * clock.offset, 1e3 * clock.sigma)
             : fmt::format("{:.3g} +- {:.2g} instants", clock.offset, clock.sigma);
}

}  // namespace tagcal
