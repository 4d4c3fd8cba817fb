#include "tagcal/estimate/types.hpp"

#include <array>

namespace tagcal {

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
