#include "summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tagcal/error.hpp"

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

}  // namespace tagcal
