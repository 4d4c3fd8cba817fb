#include "tagcal/estimate/findings.hpp"

#include <algorithm>
#include <array>

namespace tagcal {
namespace {

constexpr std::array kRefusals = {code::degenerate,       code::no_consensus,
                                  code::not_converged,    code::focal_not_observable,
                                  code::not_observable,   code::target_unseen,
                                  code::not_connected,    code::extrinsic_not_observable,
                                  code::not_synchronous,  code::rotation_axes_parallel,
                                  code::no_rotation,      code::wrong_direction,
                                  code::pair_contradicts, code::camera_without_answer,
                                  code::sizes_swapped,    code::few_units};

}  // namespace

FindingCode refusal_code(Status status) {
  return *std::ranges::find(kRefusals, status, &FindingCode::status);
}

Status judge(std::span<const Finding> findings) {
  const auto refusal = std::ranges::find_if(findings, is_refusal);
  if (refusal == findings.end()) return Status::ok;
  const auto code = std::ranges::find(kRefusals, refusal->code, &FindingCode::name);
  return code == kRefusals.end() ? Status::degenerate : code->status;
}

}  // namespace tagcal
