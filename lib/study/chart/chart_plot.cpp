#include "study/chart/chart_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "study/plot/drawing.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;

std::string percent(double share) {
  return fmt::format("{:.{}f}\u00a0%", 100 * share,
                     share < 0.1 ? 1 : 0);  // the space does not break
}

std::string short_name(const ChartResult& result, const ChartPoint& p) {
  std::string name = result.methods[static_cast<std::size_t>(p.method)].name;
  if (name.starts_with("OpenCV ")) name = name.substr(7);
  return name.substr(0, name.find(" ("));
}

// "fails: A 12 %; B 3 %; the others 1 %": the methods that fail in at least 0.5 % of the trials;
// empty if there are none.
std::string failures_text(const ChartResult& result, std::vector<ChartPoint> points) {
  std::stable_sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) {
    return a.failed_share() > b.failed_share();
  });
  if (points.empty() || points.front().failed_share() < 0.005) return "";
  const std::string least = percent(points.back().failed_share());
  std::string all = "fails: ";
  int with_least = 0;
  for (const ChartPoint& p : points) {
    if (percent(p.failed_share()) == least && points.size() > 1)
      ++with_least;
    else if (p.failed_share() >= 0.005)
      all += fmt::format("{} {}; ", short_name(result, p), percent(p.failed_share()));
  }
  if (with_least > 0 && points.back().failed_share() >= 0.005)
    all += fmt::format("{} {}; ",
                       with_least == 1 ? short_name(result, points.back()) : "the others", least);
  return all.substr(0, all.size() - 2);
}

struct Marker {
  Mark mark;
  bool filled;
  std::string_view colour;
};
constexpr Marker kOurs[] = {{Mark::disc, true, kBlue},
                            {Mark::square, true, kSkyBlue},
                            {Mark::triangle, true, kSkyBlue},
                            {Mark::wedge, true, kSkyBlue}};
constexpr Marker kPeers[] = {{Mark::square, false, kVermilion},  {Mark::disc, false, kGreen},
                             {Mark::triangle, false, kPurple},   {Mark::wedge, false, kOrange},
                             {Mark::diamond, false, kVermilion}, {Mark::diamond, false, kBlack},
                             {Mark::plus, false, kGreen},        {Mark::cross, false, kPurple},
                             {Mark::cross, false, kBlack},       {Mark::disc, false, kOrange},
                             {Mark::square, false, kGreen},      {Mark::triangle, false, kBlack},
                             {Mark::diamond, true, kPurple},     {Mark::square, true, kOrange}};

struct Tick {
  double value;
  const char* text;
};
constexpr Tick kTimes[] = {{0.1, "0.1 µs"}, {1, "1 µs"},   {10, "10 µs"},
                           {100, "100 µs"}, {1e3, "1 ms"}, {1e4, "10 ms"},
                           {1e5, "100 ms"}, {1e6, "1 s"},  {1e7, "10 s"}};
constexpr Tick kErrors[] = {{0.5, "0.5"}, {1, "1"}, {2, "2"}, {5, "5"}, {10, "10"}, {20, "20"}};

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

  Drawing drawing() const {
    Drawing drawing{kWidth, height_};
    for (const int panel : panels_) add_panel(panel, drawing);
    add_surroundings(drawing);
    return drawing;
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

  void add_marker(int number, const Vector2d& place, Drawing& drawing) const {
    const Marker& m = marker(number);
    add_mark(m.mark, m.filled, place, method(number).ours ? 4.2 : 3.2, m.colour, drawing);
  }

  void add_surroundings(Drawing& drawing) const {
    drawing.text(
        kLeft, 18,
        fmt::format("tagcal chart {}{}{}", result_.job, title_.empty() ? "" : ": ", title_), 13);
    drawing.text(
        kLeft, 37,
        fmt::format("Lower left is better. Whiskers: 5-95 % of the trials. Dotted: Pareto front. "
                    "Line at 1: {}.",
                    result_.bound_name),
        9, kDarkGrey);
    drawing.text(kWidth / 2, panels_bottom() + 38, "processor time of one call, median", 9, kBlack,
                 Text::At::middle);
    drawing.text(12, (kHead + panels_bottom()) / 2, "error, multiple of the bound (RMS)", 9, kBlack,
                 Text::At::middle, true);
    for (std::size_t i = 0; i < methods_.size(); ++i) {
      const auto [column, line] = std::div(static_cast<int>(i), legend_lines());
      const Vector2d place(kLeft + 8 + column * (kWidth - kLeft) / kLegendColumns,
                           legend_top() + kLegendLine * line);
      const ChartMethod& m = method(methods_[i]);
      add_marker(methods_[i], place, drawing);
      drawing.text(place.x() + 10, place.y(), m.name, 8.5, m.ours ? kBlue : kBlack);
    }
    drawing.texts(kLeft, legend_top() + kLegendLine * legend_lines() + 4, kFoot, foot_, 7.5,
                  "#666666");
  }

  void add_panel(int number, Drawing& drawing) const {
    const ChartPanel& panel = result_.panels[static_cast<std::size_t>(number)];
    const std::vector<ChartPoint> points = points_of_panel(points_, number);
    const double c = index_in(columns_, panel.column), r = index_in(rows_, panel.row);
    const double n = static_cast<double>(columns_.size());
    const double width = (kWidth - kLeft - kRight - (n - 1) * kGapX) / n;
    const double left = kLeft + c * (width + kGapX), top = kHead + r * (kPanel + kGapY);
    drawing.text(left, top - 32,
                 panel.row.empty() ? panel.column : fmt::format("{}, {}", panel.column, panel.row),
                 9);
    auto failures = wrapped(failures_text(result_, points), static_cast<std::size_t>(width / 4.9));
    if (failures.size() > 2) {
      failures.resize(2);
      failures.back() += " ..";
    }
    drawing.texts(left, top - 18, 10, failures, 7, "#A04000");
    const Axes axes{time_, error_, left, top, width};
    add_axes(axes, drawing);
    add_front(points, axes, drawing);
    add_points(points, axes, drawing);
  }

  // The plotted area of a panel; both axes are logarithmic.
  struct Axes {
    Range time, error;
    double left, top, width;

    double x(double time_us) const {
      return left + width * std::log(time_us / time.low) / std::log(time.high / time.low);
    }
    double y(double over_bound) const {
      return top +
             kPanel * (1 - std::log(over_bound / error.low) / std::log(error.high / error.low));
    }
  };

  void add_axes(const Axes& a, Drawing& drawing) const {
    constexpr std::string_view kGrid = "#e6e6e6", kBorder = "#777777";
    const double right = a.left + a.width, bottom = a.top + kPanel;
    for (const Tick& tick : kTimes) {
      if (tick.value < time_.low || tick.value > time_.high) continue;
      const double x = a.x(tick.value);
      drawing.line({x, a.top}, {x, bottom}, kGrid, 0.6);
      drawing.text(x, bottom + 10, tick.text, 7.5, kDarkGrey, Text::At::middle);
    }
    for (const Tick& tick : kErrors) {
      if (tick.value < error_.low || tick.value > error_.high) continue;
      const double y = a.y(tick.value);
      drawing.line({a.left, y}, {right, y}, tick.value == 1 ? "#333333" : kGrid,
                   tick.value == 1 ? 1.2 : 0.6);
      drawing.text(a.left - 5, y, tick.text, 7.5, kDarkGrey, Text::At::right);
    }
    drawing.line({a.left, a.top}, {a.left, bottom}, kBorder, 0.8);
    drawing.line({a.left, bottom}, {right, bottom}, kBorder, 0.8);
  }

  void add_front(const std::vector<ChartPoint>& points, const Axes& a, Drawing& drawing) const {
    Path front{{}, "#888888", 1, 1, 2};
    double error = error_.high;
    for (const std::size_t i : pareto_front(points)) {
      const double x = a.x(points[i].time_us.median);
      front.points.emplace_back(x, a.y(error));
      error = std::min(points[i].rms_over_bound, kMostOverBound);
      front.points.emplace_back(x, a.y(error));
    }
    front.points.emplace_back(a.x(time_.high), a.y(error));
    drawing.items.emplace_back(std::move(front));
  }

  // Whiskers, above them the marks, ours on top; errors above the plotted range as numbers, one
  // below the other.
  void add_points(const std::vector<ChartPoint>& points, const Axes& a, Drawing& drawing) const {
    const auto place = [&](const ChartPoint& p) {
      return Vector2d(a.x(p.time_us.median), a.y(std::min(p.rms_over_bound, kMostOverBound)));
    };
    const auto within = [&](double error) { return std::clamp(error, error_.low, error_.high); };
    std::vector<const ChartPoint*> drawn;
    for (const bool ours : {false, true})
      for (const ChartPoint& p : points)
        if (method(p.method).ours == ours && std::isfinite(p.rms_over_bound)) drawn.push_back(&p);
    double line = 0;
    for (const ChartPoint* p : drawn) {
      const Vector2d at = place(*p);
      const std::string_view colour = marker(p->method).colour;
      drawing.line({a.x(p->time_us.low), at.y()}, {a.x(p->time_us.high), at.y()}, colour, 0.7, 0.5);
      drawing.line({at.x(), a.y(within(p->over_bound.low))},
                   {at.x(), a.y(within(p->over_bound.high))}, colour, 0.7, 0.5);
      if (!(p->rms_over_bound > kMostOverBound)) continue;
      const bool right = at.x() > a.left + a.width / 2;
      drawing.text(
          at.x() + (right ? -8 : 8), at.y() + 9 * line++,
          p->rms_over_bound > 1000 ? "↑ over 1000" : fmt::format("↑ {:.0f}", p->rms_over_bound), 7,
          kDarkGrey, right ? Text::At::right : Text::At::left);
    }
    for (const ChartPoint* p : drawn) add_marker(p->method, place(*p), drawing);
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
    const std::string name = i == 0 ? "chart" : fmt::format("chart-{}", i + 1);
    pictures.push_back({name, Page(result, points, pages[i]).drawing()});
  }
  return pictures;
}

}  // namespace tagcal::study
