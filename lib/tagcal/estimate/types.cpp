#include "tagcal/estimate/types.hpp"

#include <array>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

const Pose& likeliest(Status status, const std::vector<PoseHypothesis>& hypotheses) {
  if (!is_answer(status) || hypotheses.empty())
    throw Error("camera_from_target: there is no answer, the status is " +
                std::string(status_name(status)) + "; test is_answer(status) first");
  return hypotheses.front().camera_from_target;
}

}  // namespace

const Pose& PoseEstimate::camera_from_target() const { return likeliest(status, hypotheses); }

const Pose& PoseAndFocalEstimate::camera_from_target() const {
  return likeliest(status, hypotheses);
}

std::string_view status_name(Status status) {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::ambiguous:
      return "ambiguous";
    case Status::focal_not_observable:
      return "focal_not_observable";
    case Status::not_observable:
      return "not_observable";
    case Status::degenerate:
      return "degenerate";
    case Status::no_consensus:
      return "no_consensus";
    case Status::not_converged:
      return "not_converged";
    case Status::not_connected:
      return "not_connected";
    case Status::extrinsic_not_observable:
      return "extrinsic_not_observable";
    case Status::not_synchronous:
      return "not_synchronous";
    case Status::rotation_axes_parallel:
      return "rotation_axes_parallel";
    case Status::no_rotation:
      return "no_rotation";
    case Status::wrong_direction:
      return "wrong_direction";
  }
  return "";
}

std::string_view severity_name(Severity severity) {
  constexpr std::array<std::string_view, 3> kNames = {"note", "warning", "refusal"};
  return kNames[static_cast<std::size_t>(severity)];
}

std::vector<std::string> sentences(std::span<const Finding> findings) {
  std::vector<std::string> all;
  for (const Finding& finding : findings) all.push_back(finding.sentence);
  return all;
}

}  // namespace tagcal
