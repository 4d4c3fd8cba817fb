#include "study/chart/chart_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "study/chart/chart_failures.hpp"
#include "study/chart/pareto.hpp"
#include "study/plot/plot_text.hpp"

namespace tagcal::study {
namespace {

// Colours for everyone (Okabe & Ito 2008), told apart by shape as well: gnuplot's point types.
struct Marker {
  int type;
  const char* colour;
};
constexpr Marker kOurs[] = {{7, "#0072B2"}, {5, "#56B4E9"}, {9, "#56B4E9"}, {11, "#56B4E9"}};
constexpr Marker kPeers[] = {{4, "#D55E00"},  {6, "#009E73"},  {8, "#CC79A7"}, {10, "#E69F00"},
                             {12, "#D55E00"}, {14, "#000000"}, {1, "#009E73"}, {2, "#CC79A7"},
                             {3, "#000000"},  {6, "#E69F00"},  {4, "#009E73"}, {8, "#000000"},
                             {13, "#CC79A7"}, {15, "#E69F00"}};

// Pixels of the picture.
constexpr double kWidth = 900, kLeft = 58, kRight = 12, kGapX = 34, kPanel = 168, kGapY = 74;
constexpr double kHead = 92, kLegendLine = 19, kFoot = 15;
constexpr int kLegendColumns = 3;
constexpr double kMostOverBound = 20;  // more is drawn at the upper border

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  void add(double v) {
    if (v > 0 && std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
};

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
    height_ = legend_top() + kLegendLine * legend_lines() +
              kFoot * static_cast<double>(foot().size()) + 8;
  }

  std::string svg() const {
    return fmt::format(
               "set terminal svg size {},{} noenhanced font 'DejaVu Sans,11' background "
               "'#ffffff'\n",
               kWidth, height_) +
           body();
  }
  std::string png() const {
    return fmt::format(
               "set terminal pngcairo size {},{} noenhanced font 'DejaVu Sans,8.5' fontscale 2 "
               "linewidth 2 pointscale 2 background '#ffffff'\n",
               2 * kWidth, 2 * height_) +
           body();
  }

 private:
  template <typename T>
  static void add_once(const T& value, std::vector<T>& values) {
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }

  double panels_bottom() const {
    return kHead + static_cast<double>(rows_.size()) * (kPanel + kGapY) - kGapY;
  }
  double legend_top() const { return panels_bottom() + 68; }
  int legend_lines() const {
    return (static_cast<int>(methods_.size()) + kLegendColumns - 1) / kLegendColumns;
  }
  bool ours(int method) const { return result_.methods[static_cast<std::size_t>(method)].ours; }

  // Of all methods of the result, so that all pages agree.
  Marker marker(int method) const {
    std::size_t before = 0;
    for (int i = 0; i < method; ++i) before += ours(i) == ours(method);
    return ours(method) ? kOurs[before % std::size(kOurs)] : kPeers[before % std::size(kPeers)];
  }

  double across(double px) const { return px / kWidth; }
  double up(double px_from_above) const { return 1 - px_from_above / height_; }

  std::string text(double x, double y, const std::string& words, const char* how) const {
    return fmt::format("set label {} at screen {:.5f},{:.5f} {}\n", quoted(words), across(x), up(y),
                       how);
  }

  std::vector<std::string> foot() const {
    std::string all;
    for (const std::string& line : result_.origin) {
      if (!all.empty()) all += " · ";
      all += line;
    }
    return wrapped(all, 150);
  }

  std::string body() const {
    std::string script =
        "set encoding utf8\nset multiplot\nset border lc rgb '#777777' lw 0.8\nunset key\n"
        "set logscale xy\nset tics nomirror scale 0.5\nset mxtics 10\nset mytics 10\n" +
        fmt::format("set xrange [{:.4g}:{:.4g}]\nset yrange [{:.4g}:{:.4g}]\n", time_.low,
                    time_.high, error_.low, error_.high) +
        "set xtics ('0.1 µs' 0.1, '1 µs' 1, '10 µs' 10, '100 µs' 100, '1 ms' 1e3, '10 ms' 1e4, "
        "'100 ms' 1e5, '1 s' 1e6, '10 s' 1e7) textcolor rgb '#444444'\n"
        "set ytics ('0.5' 0.5, '1' 1, '2' 2, '5' 5, '10' 10, '20' 20) textcolor rgb '#444444'\n"
        "set grid x y lc rgb '#e6e6e6' lw 0.6 lt 1\n";
    for (const int panel : panels_) script += panel_script(panel);
    return script + around() + "unset multiplot\n";
  }

  // All that is written and drawn beside the panels, on an empty plot.
  std::string around() const {
    std::string script =
        "unset label\nunset tics\nunset border\nunset grid\nunset logscale\nunset title\n"
        "set lmargin at screen 0\nset rmargin at screen 1\nset tmargin at screen 1\n"
        "set bmargin at screen 0\nset xrange [0:1]\nset yrange [0:1]\n";
    script += text(kLeft, 18, headline(), "left font ',13'");
    script += text(
        kLeft, 37,
        fmt::format("Lower left is better. Whiskers: 5-95 % of the trials. Dotted: Pareto front. "
                    "Line at 1: {}.",
                    result_.bound_name),
        "left textcolor rgb '#444444' font ',9'");
    script +=
        text(kWidth / 2, panels_bottom() + 38, "processor time of one call, median", "center");
    script += fmt::format("set label {} at screen {:.5f},{:.5f} center rotate by 90\n",
                          quoted("error, multiple of the bound (RMS)"), across(12),
                          up(0.5 * (kHead + panels_bottom())));
    double y = legend_top();
    for (std::size_t i = 0; i < methods_.size(); ++i) script += legend_entry(i, y);
    y += kLegendLine * legend_lines() + 4;
    for (const std::string& line : foot()) {
      script += text(kLeft, y, line, "left textcolor rgb '#666666' font ',7.5'");
      y += kFoot;
    }
    return script + "plot NaN notitle\n";
  }

  std::string headline() const {
    return fmt::format("tagcal chart {}{}{}", result_.job, title_.empty() ? "" : ": ", title_);
  }

  std::string legend_entry(std::size_t i, double top) const {
    const auto per_column = static_cast<std::size_t>(legend_lines());
    const double x =
        kLeft + 8 + static_cast<double>(i / per_column) * (kWidth - kLeft) / kLegendColumns;
    const double y = top + kLegendLine * static_cast<double>(i % per_column);
    const int method = methods_[i];
    const Marker m = marker(method);
    return text(x, y, result_.methods[static_cast<std::size_t>(method)].name,
                fmt::format("left offset 1.2,0 point pt {} ps {} lw 1.4 lc rgb '{}'{}", m.type,
                            ours(method) ? 1.3 : 0.9, m.colour,
                            ours(method) ? " textcolor rgb '#0072B2'" : "")
                    .c_str());
  }

  std::string panel_script(int number) const {
    const ChartPanel& panel = result_.panels[static_cast<std::size_t>(number)];
    const std::vector<ChartPoint> points = points_of_panel(points_, number);
    const double c = static_cast<double>(std::find(columns_.begin(), columns_.end(), panel.column) -
                                         columns_.begin());
    const double r =
        static_cast<double>(std::find(rows_.begin(), rows_.end(), panel.row) - rows_.begin());
    const double n = static_cast<double>(columns_.size());
    const double width = (kWidth - kLeft - kRight - (n - 1) * kGapX) / n;
    const double left = kLeft + c * (width + kGapX), top = kHead + r * (kPanel + kGapY);
    std::string script = "unset label\n";
    script += fmt::format(
        "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
        "set bmargin at screen {:.5f}\n",
        across(left), across(left + width), up(top), up(top + kPanel));
    script +=
        text(left, top - 32,
             panel.row.empty() ? panel.column : fmt::format("{}, {}", panel.column, panel.row),
             "left font ',9'");
    const auto lines =
        wrapped(failures_text(result_, points), static_cast<std::size_t>(width / 4.9));
    for (std::size_t i = 0; i < std::min<std::size_t>(lines.size(), 2); ++i)
      script += text(left, top - 18 + 10 * static_cast<double>(i),
                     lines[i] + (i == 1 && lines.size() > 2 ? " .." : ""),
                     "left textcolor rgb '#A04000' font ',7'");
    return script + off_scale(points) + data(points) + plot(points);
  }

  // Arrows of what lies above the picture.
  std::string off_scale(const std::vector<ChartPoint>& points) const {
    std::string script;
    double lines = 0;  // below each other
    for (const ChartPoint& p : points) {
      if (!(p.rms_over_bound > kMostOverBound)) continue;
      const bool right = p.time_us.median * p.time_us.median > time_.low * time_.high;
      script += fmt::format(
          "set label '{}' at first {:.5g},{:.5g} {} offset {},{} textcolor rgb '#444444' font "
          "',7'\n",
          p.rms_over_bound > 1000 ? "↑ over 1000" : fmt::format("↑ {:.0f}", p.rms_over_bound),
          p.time_us.median, kMostOverBound, right ? "right" : "left", right ? -0.9 : 0.9,
          -0.9 * lines++);
    }
    return script;
  }

  std::string data(const std::vector<ChartPoint>& points) const {
    std::string script;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ChartPoint& p = points[i];
      script +=
          fmt::format("$p{} << EOD\n{:.5g} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g}\nEOD\n", i,
                      p.time_us.median, std::min(p.rms_over_bound, kMostOverBound), p.time_us.low,
                      p.time_us.high, std::clamp(p.over_bound.low, error_.low, error_.high),
                      std::clamp(p.over_bound.high, error_.low, error_.high));
    }
    script += "$front << EOD\n";
    double error = error_.high;
    for (const std::size_t i : pareto_front(points)) {
      const double e = std::min(points[i].rms_over_bound, kMostOverBound);
      script +=
          fmt::format("{0:.5g} {1:.5g}\n{0:.5g} {2:.5g}\n", points[i].time_us.median, error, e);
      error = e;
    }
    return script + fmt::format("{:.5g} {:.5g}\nEOD\n", time_.high, error);
  }

  std::string plot(const std::vector<ChartPoint>& points) const {
    std::string whiskers, marks;
    // Ours last: on top.
    for (const bool of_ours : {false, true}) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (ours(points[i].method) != of_ours || !std::isfinite(points[i].rms_over_bound)) continue;
        const Marker m = marker(points[i].method);
        whiskers +=
            fmt::format(", $p{} using 1:2:3:4:5:6 with xyerrorbars pt -1 lw 0.7 lc rgb '#80{}'", i,
                        m.colour + 1);
        marks += fmt::format(", $p{} using 1:2 with points pt {} ps {} lw 1.4 lc rgb '{}'", i,
                             m.type, of_ours ? 1.3 : 0.9, m.colour);
      }
    }
    return "plot 1 lc rgb '#333333' lw 1.2 lt 1, $front using 1:2 with lines lc rgb '#888888' lw 1 "
           "dt 3" +
           whiskers + marks + "\n";
  }

  const ChartResult& result_;
  std::span<const ChartPoint> points_;
  std::string title_;
  std::vector<int> panels_, methods_;
  std::vector<std::string> rows_, columns_;
  Range time_, error_;
  double height_ = 0;
};

}  // namespace

std::vector<ChartPicture> chart_pictures(const ChartResult& result,
                                         std::span<const ChartPoint> points) {
  std::vector<std::string> pages;
  for (const ChartPanel& panel : result.panels)
    if (std::find(pages.begin(), pages.end(), panel.page) == pages.end())
      pages.push_back(panel.page);
  std::vector<ChartPicture> pictures;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    const Page page(result, points, pages[i]);
    const std::string name = i == 0 ? "chart" : fmt::format("chart-{}", i + 1);
    pictures.push_back({name + ".svg", page.svg()});
    pictures.push_back({name + ".png", page.png()});
  }
  return pictures;
}

}  // namespace tagcal::study
