#include "summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"

namespace tagcal {
namespace {

constexpr double kLargestFocalSd = 0.1;  // share of the focal length, as policy.hpp has it

// The larger of both; of a NaN and a number the number.
double larger(double a, double b) { return std::isnan(a) ? b : std::isnan(b) ? a : std::max(a, b); }

bool is_answer_name(std::string_view status) { return status == "ok" || status == "ambiguous"; }

// True if `auto` gives no answer although the model that made the data does, and is right.
bool refused(const Record& r) {
  return !answered(r) && own_answered(r) && r.own_f_ratio <= kAllowed &&
         own_region_ratio(r) <= kAllowed;
}

// Findings that blame what may be right in a world. The first that matches decides.
struct Diagnosis {
  std::string_view name;
  FindingCode code;
  std::string_view true_with;  // names of the defects and of the mode in which it may be true
  std::string_view text = "";  // part of the sentence; empty: any sentence
  bool of_model = false;       // true where the answer's model does not contain the truth's lens
};
constexpr std::string_view kAnyDefect = "bend twist aspect rows";
constexpr Diagnosis kDiagnoses[] = {
    {"bent", code::board_bend_impossible, ""},
    {"bent", code::board_bent, "bend twist"},
    {"bent", code::flatness_exceeded, "bend twist"},
    {"target", code::tags_misplaced, "bend twist aspect"},
    {"target", code::tag_scale, "pixels"},  // ink spreads
    {"moved", code::view_rejected, "rows bend twist", "during the exposure"},
    {"view", code::board_moved, ""},
    {"view", code::view_rejected, "rows"},
    {"view", code::view_mirrored, ""},
    {"view", code::view_repeated, ""},
    {"consensus", code::no_consensus, "", "more than half"},
    {"noise", code::noise_understated, "pixels bend twist aspect rows"},
    {"model", code::model_too_small, "", "", true},
    {"model", code::other_lens, "", "", true},
    {"model", code::residuals_biased, kAnyDefect, "", true},
    {"model", code::halves_disagree, kAnyDefect, "", true}};

// True if the world has a defect, or the mode, for which the finding may be right.
bool may_be_true(const Diagnosis& diagnosis, const Record& record) {
  const auto has = [&](std::string_view name) {
    return record.mode == name || record.defects.find(name) != std::string::npos;
  };
  std::string_view rest = diagnosis.true_with;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (has(rest.substr(0, end))) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

// `finding` is "code: sentence" (record.hpp).
bool is_diagnosis(std::string_view finding, const Diagnosis& diagnosis) {
  const std::size_t end = std::min(finding.find(": "), finding.size());
  return finding.substr(0, end) == diagnosis.code.name &&
         finding.substr(end).find(diagnosis.text) != std::string_view::npos;
}

// True if every lens of model `other` is a lens of `model`: the parameters that a free one of
// `other` sets are free in `model`, and tied to no more.
bool contains(const std::string& model, const std::string& other) {
  const auto named = [](const std::string& name) {
    return std::ranges::find(Model::all(), name, &Model::name);
  };
  const auto large = named(model), small = named(other);
  if (large == Model::all().end() || small == Model::all().end()) return false;
  return &large->kind() == &small->kind() &&
         std::ranges::all_of(small->free(), [&](const FreeParameter& one) {
           std::set<int> rest(one.lens_parameters.begin(), one.lens_parameters.end());
           for (const FreeParameter& many : large->free())
             if (std::ranges::includes(one.lens_parameters, many.lens_parameters))
               for (const int i : many.lens_parameters) rest.erase(i);
           return rest.empty();
         });
}

}  // namespace

Wrong wrong_named(std::string_view name) {
  constexpr std::array<std::string_view, 7> kNames = {
      "beyond", "focal", "region", "image", "corners", "refused", "diagnosis"};  // as Wrong
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end())
    throw Error(fmt::format("--by: must be one of {}, got {}", fmt::join(kNames, ", "), name));
  return static_cast<Wrong>(found - kNames.begin());
}

double wrongness(const Record& r, Wrong kind) {
  const auto ratio = [](double value) { return std::isnan(value) ? 0 : value / kAllowed; };
  switch (kind) {
    case Wrong::beyond:
      return ratio(larger(r.f_ratio, larger(region_ratio(r), r.image_ratio)));
    case Wrong::focal:
      return ratio(r.f_ratio);
    case Wrong::region:
      return ratio(region_ratio(r));
    case Wrong::image:
      return ratio(r.image_ratio);
    case Wrong::corners:
      return r.corner_worst / kFiveSigma2;
    case Wrong::refused:
      return refused(r) ? 2 : 0;
    case Wrong::diagnosis:
      return 2 * static_cast<double>(false_diagnoses(r).size());
  }
  return 0;
}

bool answered(const Record& r) { return is_answer_name(r.status); }
bool own_answered(const Record& r) { return is_answer_name(r.own_status); }
double region_ratio(const Record& r) { return larger(r.region_ratio, r.region_far_ratio); }
double own_region_ratio(const Record& r) {
  return larger(r.own_region_ratio, r.own_region_far_ratio);
}
bool is_uncertain_answer(const Record& r) {
  return r.status == "ok" && r.f_sd_px > kLargestFocalSd * r.f_px;
}
double f_claim(const Record& r) { return r.f_sd_px / r.own_f_sd_px; }
double region_claim(const Record& r) { return r.region_px / r.own_region_px; }
double image_claim(const Record& r) { return r.image_px / r.own_image_px; }

double corner_root_nees(const Record& r) {
  const int known = r.corners - r.corners_without_covariance;
  return known > 0 ? std::sqrt(r.corner_squares / (2 * known)) : kNone;
}

Totals::Totals(std::vector<Record> all) : records(std::move(all)) {
  for (const Record& r : records) answers += answered(r);
}

int Totals::wrong(Wrong kind) const {
  return static_cast<int>(
      std::ranges::count_if(records, [&](const Record& r) { return wrongness(r, kind) > 1; }));
}

std::vector<std::string_view> false_diagnoses(const Record& record) {
  std::vector<std::string_view> classes;
  std::string_view rest = record.findings;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(" | "), rest.size());
    const std::string_view finding = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 3, rest.size()));
    const auto* const found = std::ranges::find_if(
        kDiagnoses, [&](const Diagnosis& d) { return is_diagnosis(finding, d); });
    if (found == std::end(kDiagnoses) || may_be_true(*found, record)) continue;
    if (found->of_model && !contains(record.answer, record.model)) continue;
    if (std::ranges::find(classes, found->name) == classes.end()) classes.push_back(found->name);
  }
  return classes;
}

}  // namespace tagcal
