#include "study/atlas/atlas_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "study/plot/plot_text.hpp"

namespace tagcal::study {
namespace {

// For everyone (Okabe & Ito 2008), light to dark in their harm; by StabilityOutcome.
constexpr std::array<const char*, kNumOutcomes> kColours = {"#0072B2", "#D0D0D0", "#D55E00",
                                                            "#F0E442"};
constexpr std::array<const char*, kNumOutcomes> kWords = {
    "right and said so", "refused, both poses given, or with a warning", "wrong and silent",
    "refused what could be known"};
// From below to above in a cell.
constexpr std::array<StabilityOutcome, kNumOutcomes> kStack = {
    StabilityOutcome::right_and_said, StabilityOutcome::wrong_and_said,
    StabilityOutcome::right_but_refused, StabilityOutcome::wrong_and_silent};

// Pixels of the picture.
constexpr double kWidth = 900, kRight = 12, kGapX = 16, kHead = 84, kCellHeight = 24;
constexpr double kLetter = 5.6, kLegendLine = 18, kFoot = 14, kLeastHeight = 84;

class Picture {
 public:
  Picture(const StabilityMap& map, const StabilityResult& result,
          std::span<const std::string> origin)
      : map_(map), result_(result) {
    y_ = map.axes.size() > 1 && map.axes[0].names.empty() ? 1 : 0;
    x_ = map.axes.size() > 1 ? 1 - y_ : 0;
    for (std::size_t m = 0; m < map.methods.size(); ++m)
      if (map.methods[m].drawn) methods_.push_back(m);
    std::size_t longest_y = 0, longest_x = 0;
    for (std::size_t i = 0; i < rows(); ++i) longest_y = std::max(longest_y, y_label(i).size());
    for (std::size_t i = 0; i < columns(); ++i)
      longest_x = std::max(longest_x, map.axes[x_].label(i).size());
    left_ = 34 + kLetter * static_cast<double>(longest_y);
    panel_height_ = std::max(kLeastHeight, kCellHeight * static_cast<double>(rows()));
    ticks_ = 10 + kLetter * static_cast<double>(longest_x);
    std::string all;
    for (const std::string& line : origin) all += (all.empty() ? "" : " · ") + line;
    foot_ = wrapped(all, 150);
    height_ = kHead + panel_height_ + ticks_ + 26 + 2 * kLegendLine +
              kFoot * static_cast<double>(foot_.size()) + 12;
    const auto n = static_cast<double>(methods_.size());
    panel_width_ = (kWidth - left_ - kRight - (n - 1) * kGapX) / n;
  }

  std::string script() const {
    std::string text = fmt::format(
        "set terminal pngcairo size {},{} noenhanced font 'DejaVu Sans,8.5' fontscale 2 linewidth "
        "2 background '#ffffff'\nset encoding utf8\nset multiplot\nunset key\n"
        "set border lc rgb '#777777' lw 0.8\nset tics scale 0 textcolor rgb '#444444'\n",
        2 * kWidth, 2 * height_);
    text += fmt::format("set xrange [0:{}]\nset yrange [0:{}]\n", columns(), rows());
    text += "set xtics rotate by 90 right offset 0,0.2 (" + ticks(x_, columns()) + ")\n";
    for (std::size_t i = 0; i < methods_.size(); ++i) text += panel(i);
    return text + around() + "unset multiplot\n";
  }

 private:
  bool flat() const { return map_.axes.size() < 2; }
  std::size_t columns() const { return map_.axes[x_].values.size(); }
  std::size_t rows() const { return flat() ? 1 : map_.axes[y_].values.size(); }
  std::string y_label(std::size_t i) const { return flat() ? "" : map_.axes[y_].label(i); }

  double across(double px) const { return px / kWidth; }
  double up(double px_from_above) const { return 1 - px_from_above / height_; }

  std::string text(double x, double y, const std::string& words, const std::string& how) const {
    return fmt::format("set label {} at screen {:.5f},{:.5f} {}\n", quoted(words), across(x), up(y),
                       how);
  }

  std::string ticks(std::size_t axis, std::size_t n) const {
    std::string list;
    for (std::size_t i = 0; i < n; ++i)
      list += fmt::format("{}{} {}", i ? ", " : "", quoted(map_.axes[axis].label(i)),
                          static_cast<double>(i) + 0.5);
    return list;
  }

  static std::string title_of(const StabilityAxis& axis) {
    return axis.quantity + (axis.unit.empty() ? "" : ", " + axis.unit);
  }

  std::string panel(std::size_t i) const {
    const double left = left_ + static_cast<double>(i) * (panel_width_ + kGapX);
    std::string script = "unset label\n";
    script += fmt::format(
        "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
        "set bmargin at screen {:.5f}\n",
        across(left), across(left + panel_width_), up(kHead), up(kHead + panel_height_));
    if (i == 0 && !flat())
      script += "set ytics (" + ticks(y_, rows()) + ")\n";
    else
      script += "unset ytics\n";
    const StabilityMethod& method = map_.methods[methods_[i]];
    const auto lines = wrapped(method.name, static_cast<std::size_t>(panel_width_ / 6));
    for (std::size_t l = 0; l < lines.size(); ++l)
      script +=
          text(left, kHead - 8 - 12 * static_cast<double>(lines.size() - 1 - l), lines[l],
               fmt::format("left font ',9'{}", method.ours ? " textcolor rgb '#0072B2'" : ""));
    return script + boxes(methods_[i]);
  }

  // The boxes of each outcome, one plot of its colour each.
  std::string boxes(std::size_t method) const {
    std::array<std::string, kNumOutcomes> data;
    for (const StabilityTally& tally : result_.tallies) {
      if (tally.method != method) continue;
      const std::vector<std::size_t> at = map_.indices(tally.cell);
      const auto x = static_cast<double>(at[x_]);
      double y = (flat() ? 0.0 : static_cast<double>(at[y_])) + 0.04;
      for (const StabilityOutcome outcome : kStack) {
        const double to = y + 0.92 * tally.share(outcome);
        if (to > y)
          data[static_cast<std::size_t>(outcome)] +=
              fmt::format("{0} {1} {2} {3} {4:.5f} {5:.5f}\n", x + 0.5, 0.5 * (y + to), x + 0.04,
                          x + 0.96, y, to);
        y = to;
      }
    }
    std::string blocks, plot;
    for (std::size_t k = 0; k < kNumOutcomes; ++k) {
      if (data[k].empty()) continue;
      blocks += fmt::format("$d{} << EOD\n{}EOD\n", k, data[k]);
      plot += fmt::format(
          "{}$d{} using 1:2:3:4:5:6 with boxxyerror fillstyle solid 1 noborder lc rgb '{}'",
          plot.empty() ? "plot " : ", ", k, kColours[k]);
    }
    return blocks + (plot.empty() ? "plot NaN" : plot) + "\n";
  }

  // All that is written beside the panels, on an empty plot.
  std::string around() const {
    std::string script =
        "unset label\nunset tics\nunset border\nset lmargin at screen 0\nset rmargin at screen 1\n"
        "set tmargin at screen 1\nset bmargin at screen 0\nset xrange [0:1]\nset yrange [0:1]\n";
    script += text(12, 20, map_.title, "left font ',12'");
    script += text(12, 40, "Shares of the trials in each cell. " + numbers(),
                   "left font ',8.5' textcolor rgb '#444444'");
    double y = kHead + panel_height_ + ticks_ + 12;
    script += text(left_ + (kWidth - left_ - kRight) / 2, y, title_of(map_.axes[x_]), "center");
    if (!flat())
      script +=
          fmt::format("set label {} at screen {:.5f},{:.5f} center rotate by 90\n",
                      quoted(title_of(map_.axes[y_])), across(12), up(kHead + panel_height_ / 2));
    y += 24;
    for (std::size_t k = 0; k < kNumOutcomes; ++k) {
      const auto outcome = static_cast<std::size_t>(kStack[k]);
      script +=
          text(12 + 14 + (k % 2 ? 230.0 : 0.0), y + kLegendLine * static_cast<double>(k / 2),
               kWords[outcome],
               fmt::format("left offset 1,0 point pt 5 ps 1.6 lc rgb '{}'", kColours[outcome]));
    }
    y += 2 * kLegendLine + 4;
    for (const std::string& line : foot_) {
      script += text(12, y, line, "left textcolor rgb '#666666' font ',7'");
      y += kFoot;
    }
    return script + "plot NaN notitle\n";
  }

  std::string numbers() const {
    int ours = 0, peers = 0;
    for (const StabilityTally& t : result_.tallies)
      (map_.methods[t.method].ours ? ours : peers) = t.trials;
    return fmt::format("Trials a cell: ours {}, others {}.", ours, peers);
  }

  const StabilityMap& map_;
  const StabilityResult& result_;
  std::size_t x_ = 0, y_ = 0;
  std::vector<std::size_t> methods_;
  std::vector<std::string> foot_;
  double left_ = 0, panel_height_ = 0, panel_width_ = 0, ticks_ = 0, height_ = 0;
};

}  // namespace

std::string atlas_picture(const StabilityMap& map, const StabilityResult& result,
                          std::span<const std::string> origin) {
  return Picture(map, result, origin).script();
}

}  // namespace tagcal::study
