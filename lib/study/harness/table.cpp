#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "study/harness/study.hpp"
#include "study/quantile.hpp"

namespace tagcal::study {
namespace {

// NaN of none.
double total(const std::vector<double>& values) {
  if (values.empty()) return std::nan("");
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double mean(const std::vector<double>& values) {
  return total(values) / static_cast<double>(values.size());
}

// The figure of one number; empty for NaN.
Figure figure(const std::string& heading, int digits,
              const std::function<double(const Sample&)>& number) {
  return {heading, [=](const Sample& sample) {
            const double value = number(sample);
            return std::isnan(value) ? std::string() : fmt::format("{:.{}f}", value, digits);
          }};
}

// The values of the keys of a row.
std::vector<std::string> keys_of(const Study& study, const Table& table, const Row& row) {
  std::vector<std::string> keys;
  for (const std::string& key : table.keys)
    keys.push_back(Sample(study.columns, {&row}).texts(key).front());
  return keys;
}

void add_line(std::string& text, const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) text += "| " + cell + " ";
  text += "|\n";
}

std::string table_text(const Study& study, const Table& table, std::span<const Row> rows) {
  std::vector<std::string> head = table.keys;
  std::string rule;
  for (std::size_t i = 0; i < table.keys.size(); ++i) rule += "|---";
  for (const Figure& f : table.figures) head.push_back(f.heading), rule += "|--:";
  std::string text;
  add_line(text, head);
  text += rule + "|\n";
  std::vector<std::pair<std::vector<std::string>, std::vector<const Row*>>> lines;
  for (const Row& row : rows) {
    const std::vector<std::string> keys = keys_of(study, table, row);
    auto line = std::ranges::find(lines, keys, [](const auto& l) { return l.first; });
    if (line == lines.end()) line = lines.insert(lines.end(), {keys, {}});
    line->second.push_back(&row);
  }
  for (const auto& [keys, part] : lines) {
    std::vector<std::string> cells = keys;
    for (const Figure& f : table.figures) cells.push_back(f.text(Sample(study.columns, part)));
    add_line(text, cells);
  }
  return text;
}

}  // namespace

std::string tables_text(const Study& study, std::span<const Row> rows) {
  std::string text;
  for (const Table& table : study.tables) {
    if (!text.empty()) text += '\n';
    text += table_text(study, table, rows);
  }
  return text;
}

Figure rows_in(const std::string& heading) {
  return figure(heading, 0, [](const Sample& s) { return s.size(); });
}

Figure sum_of(const std::string& heading, const std::string& column, int digits) {
  return figure(heading, digits, [=](const Sample& s) { return total(s.numbers(column)); });
}

Figure mean_of(const std::string& heading, const std::string& column, int digits) {
  return figure(heading, digits, [=](const Sample& s) { return mean(s.numbers(column)); });
}

Figure rms_of(const std::string& heading, const std::string& column, int digits) {
  return figure(heading, digits, [=](const Sample& s) {
    std::vector<double> squares = s.numbers(column);
    for (double& v : squares) v *= v;
    return std::sqrt(mean(squares));
  });
}

Figure largest_of(const std::string& heading, const std::string& column, int digits) {
  return figure(heading, digits, [=](const Sample& s) {
    double largest = std::nan("");
    for (const double v : s.numbers(column)) largest = std::fmax(largest, std::abs(v));
    return largest;
  });
}

Figure quantile_of(const std::string& heading, const std::string& column, double share,
                   int digits) {
  return figure(heading, digits,
                [=](const Sample& s) { return quantile(s.numbers(column), share); });
}

Figure ratio_of(const std::string& heading, const std::string& a, const std::string& b,
                int digits) {
  return figure(heading, digits,
                [=](const Sample& s) { return total(s.numbers(a)) / total(s.numbers(b)); });
}

Figure root_ratio_of(const std::string& heading, const std::string& a, const std::string& b,
                     int digits) {
  return figure(heading, digits, [=](const Sample& s) {
    return std::sqrt(total(s.numbers(a)) / total(s.numbers(b)));
  });
}

Figure counts_of(const std::string& heading, const std::string& column) {
  return {heading, [=](const Sample& s) {
            std::map<std::string, int> counts;
            for (const std::string& text : s.texts(column)) ++counts[text];
            std::string line;
            for (const auto& [text, n] : counts)
              if (!text.empty()) line += fmt::format("{}{} {}", line.empty() ? "" : ", ", text, n);
            return line;
          }};
}

}  // namespace tagcal::study
