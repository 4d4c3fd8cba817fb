#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "record.hpp"
#include "study/quantile.hpp"

// Counts and quantiles of records, and tables of them.

namespace tagcal {

inline constexpr double kAllowed = 5;  // standard deviations; larger errors count as wrong

// The ways in which the answer of a world can be wrong; `worst` sorts by one of them.
enum class Wrong { beyond, focal, region, image, corners, refused, diagnosis };
Wrong wrong_named(std::string_view name);  // throws Error for an unknown one

// How wrong a record is in this way: ratios divided by the five standard deviations that are
// allowed, so that wrong ones are above 1.
double wrongness(const Record& record, Wrong kind);

bool answered(const Record& r);
bool own_answered(const Record& r);         // the model that made the data, asked for by name
double region_ratio(const Record& r);       // the larger one of both distances
double own_region_ratio(const Record& r);   // the same of the model that made the data
bool is_uncertain_answer(const Record& r);  // `ok` with a focal length of more than 10 % sd

// The claim of `auto` over that of the model that made the data; NaN if one has no claim.
double f_claim(const Record& r);
double region_claim(const Record& r);
double image_claim(const Record& r);

// sqrt(sum d^2 / 2 n) over the corners with a covariance, of their Mahalanobis distances d: 1 if
// the covariances are right; NaN without such corners.
double corner_root_nees(const Record& r);

struct Totals {
  explicit Totals(std::vector<Record> all);

  template <typename Value>
  double sum(const Value& value) const {
    double total = 0;
    for (const Record& r : records) total += static_cast<double>(std::invoke(value, r));
    return total;
  }
  int wrong(Wrong kind) const;

  // The value that this share of the records does not exceed, of those that are not NaN.
  template <typename Value>
  double quantile(double share, const Value& value) const {
    std::vector<double> values;
    for (const Record& r : records) values.push_back(std::invoke(value, r));
    std::erase_if(values, [](double v) { return std::isnan(v); });
    return study::quantile(std::move(values), share);
  }

  std::vector<Record> records;
  int answers = 0;
};

// The kinds of false diagnoses in this record, each once: findings that blame what is right in its
// world. A bent board in a world with a bend is no false diagnosis.
std::vector<std::string_view> false_diagnoses(const Record& record);

// Tables of records by one of their properties, in Markdown.
std::string by_defect(const std::vector<Record>& records);   // a world of two or more is "several"
std::string by_corners(const std::vector<Record>& records);  // what is given: covariances, outliers
std::string by_light(const std::vector<Record>& records);    // of pixel mode
std::string by_pictures(const std::vector<Record>& records);  // of pixel mode, corners and f

// Markdown tables for each mode: of all records, by defect, and by what corners or pictures are.
std::string summary(const std::vector<Record>& records);

// One line that describes a world and its result.
std::string one_line(const Record& record);

}  // namespace tagcal
