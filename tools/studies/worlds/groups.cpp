#include "summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "draw.hpp"

namespace tagcal {
namespace {

struct Group {
  std::string name;
  std::vector<Record> records;
};

// The groups with records, in the order of `names`.
template <typename NameOf>
std::vector<Group> grouped(const std::vector<Record>& records,
                           const std::vector<std::string>& names, const NameOf& name_of) {
  std::vector<Group> groups;
  for (const std::string& name : names) {
    Group group{name, {}};
    for (const Record& r : records)
      if (name_of(r) == name) group.records.push_back(r);
    if (!group.records.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

// "1.02 (1.34)": median and the value that nine of ten do not exceed.
template <typename Value>
std::string median_and_p90(const Totals& t, const Value& value) {
  const double median = t.quantile(0.5, value);
  return std::isnan(median) ? "" : fmt::format("{:.2f} ({:.2f})", median, t.quantile(0.9, value));
}

template <typename Value>
std::string median_text(const Totals& t, const Value& value) {
  const double median = t.quantile(0.5, value);
  return std::isnan(median) ? "" : fmt::format("{:.2f}", median);
}

std::string share_text(double part, double whole) {
  return whole > 0 ? fmt::format("{:.1f}", 1e4 * part / whole) : "";
}

std::string line_of(const Group& group) {
  const Totals t(group.records);
  const auto same = std::ranges::count_if(
      t.records, [](const Record& r) { return answered(r) && r.answer == r.model; });
  const double right = t.sum([](const Record& r) { return answered(r) ? r.corners - r.gross : 0; });
  std::string text =
      fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} ", group.name, t.records.size(),
                  t.answers, same, t.wrong(Wrong::focal), t.wrong(Wrong::region),
                  t.wrong(Wrong::image), t.wrong(Wrong::refused), t.wrong(Wrong::diagnosis));
  text += fmt::format("| {} | {} | {} | {} | {} ", median_text(t, &Record::f_ratio),
                      median_text(t, region_ratio), median_and_p90(t, f_claim),
                      median_and_p90(t, region_claim), median_and_p90(t, image_claim));
  return text + fmt::format("| {} | {:.0f} |\n", share_text(t.sum(&Record::right_rejected), right),
                            t.sum(&Record::gross_kept));
}

std::string table_of(std::string_view heading, const std::vector<Group>& groups) {
  if (groups.empty()) return "";
  std::string text = fmt::format(
      "\n| {} | worlds | answers | same model | f | region | image | refused | false | f, error / "
      "sd | region, error / sd | f, claim | region, claim | image, claim | right rejected | gross "
      "kept |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      heading);
  for (const Group& group : groups) text += line_of(group);
  return text;
}

std::string pictures_line(const Group& group) {
  const Totals t(group.records);
  const double tags = t.sum(&Record::tags), corners = t.sum(&Record::corners);
  const double known = corners - t.sum(&Record::corners_without_covariance);
  double squares = 0;
  int claims = 0;
  for (const Record& r : t.records) {
    if (std::isnan(r.f_ratio)) continue;
    squares += r.f_ratio * r.f_ratio;
    ++claims;
  }
  std::string text =
      fmt::format("| {} | {} | {:.0f} | {:.1f} | {:.1f} ", group.name, t.records.size(), corners,
                  100 * tags / t.sum(&Record::tags_visible), 100 * known / corners);
  text += fmt::format("| {:.2f} | {:.2f} | {} ", t.quantile(0.5, corner_root_nees),
                      t.quantile(1, corner_root_nees),
                      share_text(t.sum(&Record::corners_beyond), known));
  return text + fmt::format("| {} | {:.2f} | {} |\n", claims, std::sqrt(squares / claims),
                            t.wrong(Wrong::focal));
}

}  // namespace

std::string by_defect(const std::vector<Record>& records) {
  const auto name_of = [](const Record& r) -> std::string {
    if (r.defects.empty()) return "none";
    return r.defects.find('+') == std::string::npos ? r.defects : "several";
  };
  return table_of(
      "defect", grouped(records, {"none", "bend", "twist", "aspect", "rows", "several"}, name_of));
}

std::string by_corners(const std::vector<Record>& records) {
  const auto name_of = [](const Record& r) -> std::string {
    return std::string(r.covariances ? "with covariances" : "without") +
           (r.gross > 0 ? ", outliers" : "");
  };
  return table_of("corners", grouped(records,
                                     {"with covariances", "with covariances, outliers", "without",
                                      "without, outliers"},
                                     name_of));
}

std::string by_light(const std::vector<Record>& records) {
  return table_of("light", grouped(records, {"even", "uneven"}, [](const Record& r) {
                    return std::string(r.uneven_light ? "uneven" : "even");
                  }));
}

std::string by_pictures(const std::vector<Record>& records) {
  if (std::ranges::all_of(records, [](const Record& r) { return r.pictures.empty(); })) return "";
  std::string text =
      "\n| pictures | worlds | corners | tags found, % | with covariance, % | root NEES of "
      "corners, "
      "median world | worst world | beyond 5 sigma, in 10,000 | claims of f | root NEES of f | f "
      "beyond 5 sd |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  std::vector<std::string> names = picture_kinds();
  names.emplace_back("as rendered");
  const auto name_of = [](const Record& r) -> std::string {
    return r.pictures.empty() ? "as rendered" : r.pictures;
  };
  for (const Group& group : grouped(records, names, name_of)) text += pictures_line(group);
  return text;
}

}  // namespace tagcal
