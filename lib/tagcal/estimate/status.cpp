#include "tagcal/estimate/status.hpp"

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
  }
  return "";
}

}  // namespace tagcal
