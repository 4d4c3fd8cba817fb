#include "summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

namespace tagcal {
namespace {

std::string row(std::string_view what, const std::string& value, const std::string& share = "") {
  return fmt::format("| {} | {} | {} |\n", what, value, share);
}

std::string share(double part, double whole, double of, std::string_view unit) {
  return whole > 0 ? fmt::format("{:.3g} {}", of * part / whole, unit) : "";
}

std::string of_answers(std::string_view what, int count, const Totals& t) {
  return row(what, fmt::format("{}", count), share(count, t.answers, 1000, "in 1,000 answers"));
}

std::string lens_rows(const Totals& t) {
  std::string text = of_answers("focal length beyond 5 sd", t.wrong(Wrong::focal), t);
  text += of_answers("region of the corners beyond 5 sd", t.wrong(Wrong::region), t);
  text += of_answers("whole image beyond 5 sd", t.wrong(Wrong::image), t);
  const auto axis = std::ranges::count_if(
      t.records, [](const Record& r) { return r.image_axis_ratio > kAllowed; });
  text += of_answers("one coordinate in the image beyond 5 sd", static_cast<int>(axis), t);
  text += of_answers("any of the first three", t.wrong(Wrong::beyond), t);
  const auto uncertain = std::ranges::count_if(t.records, is_uncertain_answer);
  text += of_answers("`ok` with sd(f) / f above 10 %", static_cast<int>(uncertain), t);
  text += row("error / sd of the focal length, median",
              fmt::format("{:.2f}", t.quantile(0.5, &Record::f_ratio)));
  return text + row("error / sd of the region, median",
                    fmt::format("{:.2f}", t.quantile(0.5, &Record::region_ratio)));
}

// The claims of `auto` over those of the model that made the data.
std::string claim_rows(const Totals& right) {
  const auto claim = [&](std::string_view what, const auto& value) {
    return row(fmt::format("claim of auto / claim of the true model, {}", what),
               fmt::format("{:.2f}", right.quantile(0.5, value)),
               fmt::format("{:.2f} in 90 %", right.quantile(0.9, value)));
  };
  return claim("focal length, right data", f_claim) + claim("region", region_claim) +
         claim("whole image", image_claim);
}

std::string own_row(const Totals& t) {
  const auto beyond = [&](const auto& ratio) {
    return std::ranges::count_if(t.records,
                                 [&](const Record& r) { return std::invoke(ratio, r) > kAllowed; });
  };
  return row("the true model by name, beyond 5 sd",
             fmt::format("{} f, {} region, {} image", beyond(&Record::own_f_ratio),
                         beyond(own_region_ratio), beyond(&Record::own_image_ratio)),
             fmt::format("of {} answers", std::ranges::count_if(t.records, own_answered)));
}

std::string rejection_rows(const Totals& t) {
  const auto of_answer = [&](int Record::*count) {
    return t.sum([&](const Record& r) { return answered(r) ? r.*count : 0; });
  };
  const double gross = of_answer(&Record::gross), right = of_answer(&Record::corners) - gross;
  const double rejected = t.sum(&Record::right_rejected), kept = t.sum(&Record::gross_kept);
  return row("right corners rejected", fmt::format("{:.0f}", rejected),
             share(rejected, right, 1e4, "in 10,000")) +
         row("gross outliers kept", fmt::format("{:.0f}", kept), fmt::format("of {:.0f}", gross));
}

// Errors of corners against their covariances, under even or uneven light.
std::string corner_claim_rows(const Totals& t, int uneven) {
  const auto sum = [&](auto Record::*value) {
    return t.sum([&](const Record& r) { return r.uneven_light == uneven ? r.*value : 0; });
  };
  const double known = sum(&Record::corners) - sum(&Record::corners_without_covariance);
  const double beyond = sum(&Record::corners_beyond);
  if (known == 0) return "";
  const std::string_view light = uneven ? ", uneven light" : "";
  return row(fmt::format("corners beyond 5 sigma{}", light), fmt::format("{:.0f}", beyond),
             share(beyond, known, 1e4, "in 10,000")) +
         row(fmt::format("corners, error^2 in variances, mean{}", light),
             fmt::format("{:.2f}", sum(&Record::corner_squares) / (2 * known)));
}

std::string corner_rows(const Totals& t) {
  const double visible = t.sum(&Record::tags_visible), tags = t.sum(&Record::tags);
  const double corners = t.sum(&Record::corners);
  const double unknown = t.sum(&Record::corners_without_covariance);
  std::string text = row("tags wholly in view", fmt::format("{:.0f}", visible));
  text += row("tags reported", fmt::format("{:.0f}", tags), share(tags, visible, 100, "%"));
  const double fitted = t.sum(&Record::tags_fitted);
  text += row("tags with covariance", fmt::format("{:.0f}", fitted),
              share(fitted, tags, 100, "% of those reported"));
  text += row("corners without covariance", fmt::format("{:.0f}", unknown),
              share(unknown, corners, 1e4, "in 10,000"));
  return text + corner_claim_rows(t, 0) + corner_claim_rows(t, 1);
}

std::string diagnosis_rows(const Totals& t) {
  std::map<std::string_view, int> counts;
  for (const Record& r : t.records)
    for (const std::string_view name : false_diagnoses(r)) ++counts[name];
  const auto all = static_cast<double>(t.records.size());
  const int wrong = t.wrong(Wrong::diagnosis);
  std::string text =
      row("false diagnoses", fmt::format("{} worlds", wrong), share(wrong, all, 100, "%"));
  for (const auto& [name, count] : counts)
    text += row(fmt::format("- {}", name), fmt::format("{}", count), share(count, all, 100, "%"));
  return text;
}

std::string corners_text(const Record& r) {
  if (r.mode == kCorners)
    return fmt::format("corners {:.3f} px{}{}", r.noise_px, r.covariances ? "" : ", bare",
                       r.gross > 0 ? ", outliers" : "");
  return fmt::format("blur {:.1f}, noise {:.1f}, ink {:.2f}, gamma {:.2f}, worst corner {:.1f}",
                     r.blur_px, r.noise_levels, r.ink_spread_px, r.gamma, r.corner_worst);
}

std::string totals_rows(const Totals& t, const std::vector<Record>& right) {
  const auto all = static_cast<double>(t.records.size());
  std::string text = "| | | |\n|---|---|---|\n";
  text += row("worlds", fmt::format("{}", t.records.size()));
  text += row("answers", fmt::format("{}", t.answers), share(t.answers, all, 100, "%"));
  text += lens_rows(t) + own_row(t) + claim_rows(Totals(right));
  const int refusals = t.wrong(Wrong::refused);
  text += row("right data refused", fmt::format("{}", refusals), share(refusals, all, 100, "%"));
  const auto neither = std::ranges::count_if(t.records, [](const Record& r) {
    return !answered(r) && !(wrongness(r, Wrong::refused) > 1) && r.corners > 0;
  });
  text += row("no right answer by name either", fmt::format("{}", neither));
  return text + diagnosis_rows(t) + rejection_rows(t);
}

std::string time_row(const Totals& t) {
  const auto seconds = [&](double Record::*time) {
    return t.sum(time) / static_cast<double>(t.records.size());
  };
  return row("processor time of a world, s",
             fmt::format("{:.2f} render, {:.2f} detect, {:.3f} auto, {:.3f} the true model",
                         seconds(&Record::render_s), seconds(&Record::detect_s),
                         seconds(&Record::calibrate_s), seconds(&Record::own_s)));
}

std::string summary_of_mode(std::string_view mode, const std::vector<Record>& records) {
  std::vector<Record> right;
  for (const Record& r : records)
    if (r.defects.empty()) right.push_back(r);
  const Totals t(records);
  std::string text = fmt::format("mode: {}\n\n", mode) + totals_rows(t, right);
  if (mode == kPixels) text += corner_rows(t);
  text += time_row(t) + by_defect(records);
  return text + (mode == kCorners ? by_corners(records) : by_light(records) + by_pictures(records));
}

}  // namespace

std::string summary(const std::vector<Record>& records) {
  std::string text;
  for (const std::string_view mode : {kPixels, kCorners}) {
    std::vector<Record> part;
    for (const Record& r : records)
      if (r.mode == mode) part.push_back(r);
    if (part.empty()) continue;
    text += (text.empty() ? "" : "\n") + summary_of_mode(mode, part);
  }
  return text;
}

std::string one_line(const Record& r) {
  return fmt::format(
      "{}/{}{}{}: {} {:.0f} deg {}x{}, {} views, tags {:.0f} px, coverage {:.2f}, {}{}{}: {} {}, f "
      "{:.1f} region {:.1f} image {:.1f}{}{}",
      r.seed, r.index, r.switches.empty() ? "" : " ", r.switches, r.model, r.field_of_view_deg,
      r.width, r.height, r.views, r.tag_px, r.coverage, corners_text(r),
      r.defects.empty() ? "" : ", ", r.defects, r.status, r.answer, r.f_ratio, region_ratio(r),
      r.image_ratio, r.findings.empty() ? "" : "; ", r.findings);
}

}  // namespace tagcal
