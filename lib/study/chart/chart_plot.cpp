#include "study/chart/chart_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "study/chart/chart_failures.hpp"
#include "study/chart/pareto.hpp"
#include "study/plot/plot_script.hpp"

namespace tagcal::study {
namespace {

// A method's colour and shape: gnuplot's point type.
struct Marker {
  int type;
  const char* colour;
};
constexpr Marker kOurs[] = {{7, kBlue}, {5, kSkyBlue}, {9, kSkyBlue}, {11, kSkyBlue}};
constexpr Marker kPeers[] = {{4, kVermilion},  {6, kGreen},  {8, kPurple}, {10, kOrange},
                             {12, kVermilion}, {14, kBlack}, {1, kGreen},  {2, kPurple},
                             {3, kBlack},      {6, kOrange}, {4, kGreen},  {8, kBlack},
                             {13, kPurple},    {15, kOrange}};

// Pixels of the picture.
constexpr double kWidth = 900, kLeft = 58, kRight = 12, kGapX = 34, kPanel = 168, kGapY = 74;
constexpr double kHead = 92, kLegendLine = 19, kFoot = 15;
constexpr int kLegendColumns = 3;
constexpr double kMostOverBound = 20;  // larger errors are drawn at the upper border

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  void add(double v) {
    if (v > 0 && std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
};

template <typename T>
void add_once(const T& value, std::vector<T>& values) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

class Page {
 public:
  Page(const ChartResult& result, std::span<const ChartPoint> points, const std::string& page)
      : result_(result), points_(points), title_(page) {
    for (std::size_t i = 0; i < result.panels.size(); ++i) {
      if (result.panels[i].page != page) continue;
      panels_.push_back(static_cast<int>(i));
      add_once(result.panels[i].row, rows_);
      add_once(result.panels[i].column, columns_);
    }
    for (const ChartPoint& p : points_) {
      if (std::find(panels_.begin(), panels_.end(), p.panel) == panels_.end()) continue;
      add_once(p.method, methods_);
      if (!std::isfinite(p.rms_over_bound)) continue;
      for (const double t : {p.time_us.low, p.time_us.high}) time_.add(t);
      for (const double e : {p.over_bound.low, p.rms_over_bound})
        error_.add(std::min(e, kMostOverBound));
    }
    std::sort(methods_.begin(), methods_.end());
    error_.low = std::clamp(error_.low, 0.3, 0.9);
    error_.high = std::clamp(1.25 * error_.high, 3.0, kMostOverBound * 1.25);
    time_ = {time_.low / 1.3, time_.high * 1.3};
    foot_ = footnote(result.origin);
    height_ =
        legend_top() + kLegendLine * legend_lines() + kFoot * static_cast<double>(foot_.size()) + 8;
  }

  PlotScript script() const {
    PlotScript script(kWidth, height_);
    script.add(
        "set logscale xy\nset tics nomirror scale 0.5\nset mxtics 10\nset mytics 10\n"
        "set xrange [{:.4g}:{:.4g}]\nset yrange [{:.4g}:{:.4g}]",
        time_.low, time_.high, error_.low, error_.high);
    script.add(
        "set xtics ('0.1 µs' 0.1, '1 µs' 1, '10 µs' 10, '100 µs' 100, '1 ms' 1e3, '10 ms' 1e4, "
        "'100 ms' 1e5, '1 s' 1e6, '10 s' 1e7) textcolor rgb '{0}'\n"
        "set ytics ('0.5' 0.5, '1' 1, '2' 2, '5' 5, '10' 10, '20' 20) textcolor rgb '{0}'\n"
        "set grid x y lc rgb '#e6e6e6' lw 0.6 lt 1",
        kDarkGrey);
    for (const int panel : panels_) add_panel(panel, script);
    add_surroundings(script);
    return script;
  }

 private:
  static double index_in(const std::vector<std::string>& titles, const std::string& title) {
    return static_cast<double>(std::find(titles.begin(), titles.end(), title) - titles.begin());
  }

  double panels_bottom() const {
    return kHead + static_cast<double>(rows_.size()) * (kPanel + kGapY) - kGapY;
  }
  double legend_top() const { return panels_bottom() + 68; }
  int legend_lines() const {
    return (static_cast<int>(methods_.size()) + kLegendColumns - 1) / kLegendColumns;
  }
  const ChartMethod& method(int i) const { return result_.methods[static_cast<std::size_t>(i)]; }

  // Numbered over all methods of the result, so that all pages agree.
  Marker marker(int number) const {
    const bool ours = method(number).ours;
    std::size_t before = 0;
    for (int i = 0; i < number; ++i) before += method(i).ours == ours;
    return ours ? kOurs[before % std::size(kOurs)] : kPeers[before % std::size(kPeers)];
  }

  std::string marker_style(int number) const {
    return fmt::format("pt {} ps {} lw 1.4 lc rgb '{}'", marker(number).type,
                       method(number).ours ? 1.3 : 0.9, marker(number).colour);
  }

  void add_surroundings(PlotScript& script) const {
    script.begin_surroundings();
    script.label(
        kLeft, 18,
        fmt::format("tagcal chart {}{}{}", result_.job, title_.empty() ? "" : ": ", title_),
        left_aligned(13));
    script.label(
        kLeft, 37,
        fmt::format("Lower left is better. Whiskers: 5-95 % of the trials. Dotted: Pareto front. "
                    "Line at 1: {}.",
                    result_.bound_name),
        left_aligned(9, kDarkGrey));
    script.label(kWidth / 2, panels_bottom() + 38, "processor time of one call, median", "center");
    script.label(12, (kHead + panels_bottom()) / 2, "error, multiple of the bound (RMS)",
                 "center rotate by 90");
    for (std::size_t i = 0; i < methods_.size(); ++i) {
      const auto [column, line] = std::div(static_cast<int>(i), legend_lines());
      const ChartMethod& m = method(methods_[i]);
      script.label(kLeft + 8 + column * (kWidth - kLeft) / kLegendColumns,
                   legend_top() + kLegendLine * line, m.name,
                   fmt::format("left offset 1.2,0 textcolor rgb '{}' point {}",
                               m.ours ? kBlue : kBlack, marker_style(methods_[i])));
    }
    script.labels(kLeft, legend_top() + kLegendLine * legend_lines() + 4, kFoot, foot_,
                  left_aligned(7.5, "#666666"));
    script.plot({});
  }

  void add_panel(int number, PlotScript& script) const {
    const ChartPanel& panel = result_.panels[static_cast<std::size_t>(number)];
    const std::vector<ChartPoint> points = points_of_panel(points_, number);
    const double c = index_in(columns_, panel.column), r = index_in(rows_, panel.row);
    const double n = static_cast<double>(columns_.size());
    const double width = (kWidth - kLeft - kRight - (n - 1) * kGapX) / n;
    const double left = kLeft + c * (width + kGapX), top = kHead + r * (kPanel + kGapY);
    script.begin_panel(left, top, width, kPanel);
    script.label(left, top - 32,
                 panel.row.empty() ? panel.column : fmt::format("{}, {}", panel.column, panel.row),
                 left_aligned(9));
    auto failures = wrapped(failures_text(result_, points), static_cast<std::size_t>(width / 4.9));
    if (failures.size() > 2) {
      failures.resize(2);
      failures.back() += " ..";
    }
    script.labels(left, top - 18, 10, failures, left_aligned(7, "#A04000"));
    add_off_scale(points, script);
    add_data(points, script);
    add_plot(points, script);
  }

  // Adds an arrow with the error of each point above the plotted range, one below the other.
  void add_off_scale(const std::vector<ChartPoint>& points, PlotScript& script) const {
    double lines = 0;
    for (const ChartPoint& p : points) {
      if (!(p.rms_over_bound > kMostOverBound)) continue;
      const bool right = p.time_us.median * p.time_us.median > time_.low * time_.high;
      script.add(
          "set label '{}' at first {:.5g},{:.5g} {} offset {},{} textcolor rgb '{}' font ',7'",
          p.rms_over_bound > 1000 ? "↑ over 1000" : fmt::format("↑ {:.0f}", p.rms_over_bound),
          p.time_us.median, kMostOverBound, right ? "right" : "left", right ? -0.9 : 0.9,
          -0.9 * lines++, kDarkGrey);
    }
  }

  void add_data(const std::vector<ChartPoint>& points, PlotScript& script) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ChartPoint& p = points[i];
      script.add("$p{} << EOD\n{:.5g} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g}\nEOD", i, p.time_us.median,
                 std::min(p.rms_over_bound, kMostOverBound), p.time_us.low, p.time_us.high,
                 std::clamp(p.over_bound.low, error_.low, error_.high),
                 std::clamp(p.over_bound.high, error_.low, error_.high));
    }
    script.add("$front << EOD");
    double error = error_.high;
    for (const std::size_t i : pareto_front(points)) {
      const double e = std::min(points[i].rms_over_bound, kMostOverBound);
      script.add("{0:.5g} {1:.5g}\n{0:.5g} {2:.5g}", points[i].time_us.median, error, e);
      error = e;
    }
    script.add("{:.5g} {:.5g}\nEOD", time_.high, error);
  }

  void add_plot(const std::vector<ChartPoint>& points, PlotScript& script) const {
    std::vector<std::string> curves = {"1 lc rgb '#333333' lw 1.2 lt 1",
                                       "$front using 1:2 with lines lc rgb '#888888' lw 1 dt 3"};
    std::vector<std::string> marks;          // above all whiskers
    for (const bool ours : {false, true}) {  // ours on top
      for (std::size_t i = 0; i < points.size(); ++i) {
        const int m = points[i].method;
        if (method(m).ours != ours || !std::isfinite(points[i].rms_over_bound)) continue;
        curves.push_back(
            fmt::format("$p{} using 1:2:3:4:5:6 with xyerrorbars pt -1 lw 0.7 lc rgb '#80{}'", i,
                        marker(m).colour + 1));
        marks.push_back(fmt::format("$p{} using 1:2 with points {}", i, marker_style(m)));
      }
    }
    curves.insert(curves.end(), marks.begin(), marks.end());
    script.plot(curves);
  }

  const ChartResult& result_;
  std::span<const ChartPoint> points_;
  std::string title_;
  std::vector<int> panels_, methods_;
  std::vector<std::string> rows_, columns_, foot_;
  Range time_, error_;
  double height_ = 0;
};

}  // namespace

std::vector<ChartPicture> chart_pictures(const ChartResult& result,
                                         std::span<const ChartPoint> points) {
  std::vector<std::string> pages;
  for (const ChartPanel& panel : result.panels) add_once(panel.page, pages);
  std::vector<ChartPicture> pictures;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    const PlotScript page = Page(result, points, pages[i]).script();
    const std::string name = i == 0 ? "chart" : fmt::format("chart-{}", i + 1);
    pictures.push_back({name + ".svg", page.svg()});
    pictures.push_back({name + ".png", page.png()});
  }
  return pictures;
}

}  // namespace tagcal::study
