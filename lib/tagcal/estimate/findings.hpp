#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/estimate/types.hpp"

// Every code of a finding, with its severity and the status that it causes.
// docs/reference/findings.md explains each code; a test keeps that list complete.

namespace tagcal {

struct FindingCode {
  std::string_view name;
  Severity severity = Severity::warning;
  Status status = Status::ok;  // of a refusal
};

namespace code {

// No answer.
inline constexpr FindingCode degenerate{"degenerate", Severity::refusal, Status::degenerate};
inline constexpr FindingCode no_consensus{"no_consensus", Severity::refusal, Status::no_consensus};
inline constexpr FindingCode not_converged{"not_converged", Severity::refusal,
                                           Status::not_converged};
inline constexpr FindingCode focal_not_observable{"focal_not_observable", Severity::refusal,
                                                  Status::focal_not_observable};
inline constexpr FindingCode not_observable{"not_observable", Severity::refusal,
                                            Status::not_observable};
inline constexpr FindingCode target_unseen{"target_unseen", Severity::refusal, Status::degenerate};
inline constexpr FindingCode not_connected{"not_connected", Severity::refusal,
                                           Status::not_connected};
inline constexpr FindingCode extrinsic_not_observable{"extrinsic_not_observable", Severity::refusal,
                                                      Status::extrinsic_not_observable};
inline constexpr FindingCode not_synchronous{"not_synchronous", Severity::refusal,
                                             Status::not_synchronous};
inline constexpr FindingCode rotation_axes_parallel{"rotation_axes_parallel", Severity::refusal,
                                                    Status::rotation_axes_parallel};
inline constexpr FindingCode no_rotation{"no_rotation", Severity::refusal, Status::no_rotation};
inline constexpr FindingCode wrong_direction{"wrong_direction", Severity::refusal,
                                             Status::wrong_direction};
inline constexpr FindingCode pair_contradicts{"pair_contradicts", Severity::refusal,
                                              Status::no_consensus};
inline constexpr FindingCode sizes_swapped{"sizes_swapped", Severity::refusal,
                                           Status::no_consensus};
inline constexpr FindingCode camera_without_answer{"camera_without_answer", Severity::refusal,
                                                   Status::not_observable};

// The data.
inline constexpr FindingCode input{"input", Severity::warning};  // from a reader or the detector
inline constexpr FindingCode view_unusable{"view_unusable", Severity::warning};
inline constexpr FindingCode view_repeated{"view_repeated", Severity::note};
inline constexpr FindingCode view_mirrored{"view_mirrored", Severity::warning};
inline constexpr FindingCode corners_outside{"corners_outside", Severity::warning};
inline constexpr FindingCode view_rejected{"view_rejected", Severity::warning};
inline constexpr FindingCode board_moved{"board_moved", Severity::warning};
inline constexpr FindingCode corners_rejected{"corners_rejected", Severity::warning};
inline constexpr FindingCode covariance_missing{"covariance_missing", Severity::note};
inline constexpr FindingCode noise_assumed{"noise_assumed", Severity::note};
inline constexpr FindingCode noise_understated{"noise_understated", Severity::warning};
inline constexpr FindingCode rows_displaced{"rows_displaced", Severity::warning};
inline constexpr FindingCode rolling_shutter{"rolling_shutter", Severity::warning};
inline constexpr FindingCode readout_not_observable{"readout_not_observable", Severity::warning};
inline constexpr FindingCode instants_rejected{"instants_rejected", Severity::warning};
inline constexpr FindingCode instants_strained{"instants_strained", Severity::warning};
inline constexpr FindingCode camera_contradicts{"camera_contradicts", Severity::warning};
inline constexpr FindingCode camera_moved{"camera_moved", Severity::warning};
inline constexpr FindingCode corner_order_differs{"corner_order_differs", Severity::warning};
inline constexpr FindingCode clock_corrected{"clock_corrected", Severity::note};
inline constexpr FindingCode lens_without_covariance{"lens_without_covariance", Severity::note};
inline constexpr FindingCode single_instant{"single_instant", Severity::warning};

// The target.
inline constexpr FindingCode tags_misplaced{"tags_misplaced", Severity::warning};
inline constexpr FindingCode tag_scale{"tag_scale", Severity::warning};
inline constexpr FindingCode board_bent{"board_bent", Severity::note};
inline constexpr FindingCode board_bend_impossible{"board_bend_impossible", Severity::warning};
inline constexpr FindingCode flatness_exceeded{"flatness_exceeded", Severity::warning};
inline constexpr FindingCode print_aspect{"print_aspect", Severity::note};
inline constexpr FindingCode print_exceeded{"print_exceeded", Severity::warning};
inline constexpr FindingCode scale_untested{"scale_untested", Severity::warning};
inline constexpr FindingCode board_scale{"board_scale", Severity::warning};

// The model.
inline constexpr FindingCode model_too_small{"model_too_small", Severity::warning};
inline constexpr FindingCode held_contradicted{"held_contradicted", Severity::warning};
inline constexpr FindingCode other_lens{"other_lens", Severity::warning};
inline constexpr FindingCode perspective_seen{"perspective_seen", Severity::warning};
inline constexpr FindingCode residuals_biased{"residuals_biased", Severity::warning};
inline constexpr FindingCode residuals_correlated{"residuals_correlated", Severity::warning};
inline constexpr FindingCode halves_disagree{"halves_disagree", Severity::warning};
inline constexpr FindingCode sources_disagree{"sources_disagree", Severity::warning};
inline constexpr FindingCode pole_in_image{"pole_in_image", Severity::warning};
inline constexpr FindingCode fold_in_image{"fold_in_image", Severity::warning};
inline constexpr FindingCode camera_exact{"camera_exact", Severity::note};
inline constexpr FindingCode camera_changed{"camera_changed", Severity::warning};

// Limits of what the data determine.
inline constexpr FindingCode direction_weak{"direction_weak", Severity::warning};
inline constexpr FindingCode coefficients_correlated{"coefficients_correlated", Severity::note};
inline constexpr FindingCode extrapolated{"extrapolated", Severity::warning};
inline constexpr FindingCode principal_point_untested{"principal_point_untested",
                                                      Severity::warning};
inline constexpr FindingCode few_views{"few_views", Severity::warning};
inline constexpr FindingCode tilt_unknown{"tilt_unknown", Severity::warning};

// Populations of units (fleet.hpp).
inline constexpr FindingCode few_units{"few_units", Severity::refusal, Status::not_observable};
inline constexpr FindingCode population_mixed{"population_mixed", Severity::warning};
inline constexpr FindingCode spread_unresolved{"spread_unresolved", Severity::note};

}  // namespace code

inline Finding finding(const FindingCode& code, std::string sentence) {
  return {std::string(code.name), code.severity, std::move(sentence)};
}

inline void add(std::vector<Finding>& findings, const FindingCode& code, std::string sentence) {
  findings.push_back(finding(code, std::move(sentence)));
}

// The code of a status without an answer. Precondition: !is_answer(status).
FindingCode refusal_code(Status status);

inline bool is_refusal(const Finding& finding) { return finding.severity == Severity::refusal; }

// The status that findings mean: that of the first refusal, or ok.
Status judge(std::span<const Finding> findings);

}  // namespace tagcal
