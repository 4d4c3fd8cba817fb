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
  constexpr std::array<std::string_view, 13> kNames = {"ok",
                                                       "ambiguous",
                                                       "focal_not_observable",
                                                       "not_observable",
                                                       "degenerate",
                                                       "no_consensus",
                                                       "not_converged",
                                                       "not_connected",
                                                       "extrinsic_not_observable",
                                                       "not_synchronous",
                                                       "rotation_axes_parallel",
                                                       "no_rotation",
                                                       "wrong_direction"};
  return kNames[static_cast<std::size_t>(status)];
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
