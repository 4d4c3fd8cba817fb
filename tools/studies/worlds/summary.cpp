#include "summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "tagcal/error.hpp"

namespace tagcal {
namespace {

constexpr double kAllowed = 5;  // standard deviations; larger errors count as wrong

bool answered(const Record& r) { return r.status == "ok" || r.status == "ambiguous"; }

// The larger of both; of a NaN and a number the number.
double larger(double a, double b) { return std::isnan(a) ? b : std::isnan(b) ? a : std::max(a, b); }

double region_ratio(const Record& r) { return larger(r.region_ratio, r.region_far_ratio); }

// True if `auto` gives no answer although the model that made the data does, and is right.
bool refused(const Record& r) {
  const bool named = r.named_status == "ok" || r.named_status == "ambiguous";
  return !answered(r) && named && r.named_f_ratio <= kAllowed && r.named_region_ratio <= kAllowed;
}

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return kNone;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Sums and medians over the records.
struct Totals {
  explicit Totals(const std::vector<Record>& all) : records(all) {
    for (const Record& r : all) answers += answered(r);
  }

  template <typename Value>
  double sum(const Value& value) const {
    double total = 0;
    for (const Record& r : records) total += static_cast<double>(std::invoke(value, r));
    return total;
  }
  int wrong(Wrong kind) const {
    return static_cast<int>(
        std::ranges::count_if(records, [&](const Record& r) { return wrongness(r, kind) > 1; }));
  }
  double median_of(double Record::*value) const {
    std::vector<double> values;
    for (const Record& r : records) values.push_back(r.*value);
    return median(std::move(values));
  }

  const std::vector<Record>& records;
  int answers = 0;
};

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
  text += row("error / sd of the focal length, median",
              fmt::format("{:.2f}", t.median_of(&Record::f_ratio)));
  return text + row("error / sd of the region, median",
                    fmt::format("{:.2f}", t.median_of(&Record::region_ratio)));
}

std::string corner_rows(const Totals& t) {
  const double visible = t.sum(&Record::tags_visible), tags = t.sum(&Record::tags);
  const double corners = t.sum(&Record::corners);
  const double known = corners - t.sum(&Record::corners_without_covariance);
  std::string text = row("tags wholly in view", fmt::format("{:.0f}", visible));
  text += row("tags reported", fmt::format("{:.0f}", tags), share(tags, visible, 100, "%"));
  const double fitted = t.sum(&Record::tags_fitted);
  text += row("tags with covariance", fmt::format("{:.0f}", fitted),
              share(fitted, tags, 100, "% of those reported"));
  text += row("corners without covariance", fmt::format("{:.0f}", corners - known),
              share(corners - known, corners, 1e4, "in 10,000"));
  const double beyond = t.sum(&Record::corners_beyond);
  text += row("corners beyond 5 sigma", fmt::format("{:.0f}", beyond),
              share(beyond, known, 1e4, "in 10,000"));
  return text + row("corners, error^2 in variances, mean",
                    fmt::format("{:.2f}", t.sum(&Record::corner_squares) / (2 * known)));
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

// Tags that now have covariances, as a share of the tags that another version read.
std::string before_rows(const Totals& t, const std::vector<Record>& before) {
  if (before.empty()) return "";
  std::map<std::pair<std::uint64_t, std::uint64_t>, const Record*> old;
  for (const Record& r : before) old[{r.seed, r.index}] = &r;
  double then = 0, now = 0;
  for (const Record& r : t.records) {
    const auto found = old.find({r.seed, r.index});
    if (found == old.end()) continue;
    then += found->second->tags;
    now += r.tags_fitted;
  }
  return row("tags read before", fmt::format("{:.0f}", then),
             share(now, then, 100, "% of as many have covariances now"));
}

std::string by_model(const std::vector<Record>& records) {
  std::map<std::string, std::vector<Record>> groups;
  for (const Record& r : records) groups[r.model].push_back(r);
  std::string text =
      "| model of the truth | worlds | answers | same model | f | region | image | refused | false "
      "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [model, group] : groups) {
    const Totals t(group);
    const auto same = std::ranges::count_if(
        group, [](const Record& r) { return answered(r) && r.answer == r.model; });
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", model, group.size(),
                        t.answers, same, t.wrong(Wrong::focal), t.wrong(Wrong::region),
                        t.wrong(Wrong::image), t.wrong(Wrong::refused), t.wrong(Wrong::diagnosis));
  }
  return text;
}

}  // namespace

Wrong wrong_named(std::string_view name) {
  static const std::map<std::string_view, Wrong> names = {
      {"beyond", Wrong::beyond},      {"focal", Wrong::focal},     {"region", Wrong::region},
      {"image", Wrong::image},        {"corners", Wrong::corners}, {"refused", Wrong::refused},
      {"diagnosis", Wrong::diagnosis}};
  const auto found = names.find(name);
  if (found == names.end())
    throw Error(
        fmt::format("--by: must be beyond, focal, region, image, corners, refused or "
                    "diagnosis, got {}",
                    name));
  return found->second;
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

std::string summary(const std::vector<Record>& records, const std::vector<Record>& before) {
  const Totals t(records);
  const auto all = static_cast<double>(records.size());
  std::string text = "| | | |\n|---|---|---|\n";
  text += row("worlds", fmt::format("{}", records.size()));
  text += row("answers", fmt::format("{}", t.answers), share(t.answers, all, 100, "%"));
  text += lens_rows(t);
  const int refusals = t.wrong(Wrong::refused);
  text += row("right data refused", fmt::format("{}", refusals), share(refusals, all, 100, "%"));
  const auto neither = std::ranges::count_if(
      records, [](const Record& r) { return !answered(r) && !refused(r) && r.tags > 0; });
  text += row("tags read, and no right answer by name either", fmt::format("{}", neither));
  text += diagnosis_rows(t) + corner_rows(t) + before_rows(t, before);
  const auto seconds = [&](double Record::*time) { return t.sum(time) / all; };
  text +=
      row("processor time of a world, s",
          fmt::format("{:.2f} render, {:.2f} detect, {:.2f} calibrate", seconds(&Record::render_s),
                      seconds(&Record::detect_s), seconds(&Record::calibrate_s)));
  return text + "\n" + by_model(records);
}

std::string one_line(const Record& r) {
  return fmt::format(
      "{}/{}: {} {:.0f} deg {}x{}, {} views, tags {:.0f} px, coverage {:.2f}, blur {:.1f}, noise "
      "{:.1f}, ink {:.2f}, gamma {:.2f}: {} {}, f {:.1f} region {:.1f} image {:.1f} corner "
      "{:.1f}{}{}",
      r.seed, r.index, r.model, r.field_of_view_deg, r.width, r.height, r.views, r.tag_px,
      r.coverage, r.blur_px, r.noise_levels, r.ink_spread_px, r.gamma, r.status, r.answer,
      r.f_ratio, region_ratio(r), r.image_ratio, r.corner_worst, r.findings.empty() ? "" : "; ",
      r.findings);
}

}  // namespace tagcal
