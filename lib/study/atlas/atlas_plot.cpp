#include "study/atlas/atlas_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "study/plot/plot_script.hpp"

namespace tagcal::study {
namespace {

// By StabilityOutcome.
constexpr std::array<const char*, kNumOutcomes> kColours = {kBlue, "#D0D0D0", kVermilion, kYellow};
constexpr std::array<const char*, kNumOutcomes> kWords = {
    "right and said so", "refused, both poses given, or with a warning", "wrong and silent",
    "refused what could be known"};
// From the lower to the upper end of a cell.
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
    left_ = 34 + (flat() ? 0 : kLetter * longest_label(y_));
    panel_height_ = std::max(kLeastHeight, kCellHeight * static_cast<double>(rows()));
    ticks_ = 10 + kLetter * longest_label(x_);
    foot_ = footnote(origin);
    height_ = kHead + panel_height_ + ticks_ + 26 + 2 * kLegendLine +
              kFoot * static_cast<double>(foot_.size()) + 12;
    const auto n = static_cast<double>(methods_.size());
    panel_width_ = (kWidth - left_ - kRight - (n - 1) * kGapX) / n;
  }

  std::string png() const {
    PlotScript script(kWidth, height_);
    script.add("set tics scale 0 textcolor rgb '{}'", kDarkGrey);
    script.add("set xrange [0:{}]\nset yrange [0:{}]", columns(), rows());
    script.add("set xtics rotate by 90 right offset 0,0.2 ({})", ticks(x_));
    for (std::size_t i = 0; i < methods_.size(); ++i) add_panel(i, script);
    add_surroundings(script);
    return script.png();
  }

 private:
  bool flat() const { return map_.axes.size() < 2; }
  std::size_t columns() const { return map_.axes[x_].values.size(); }
  std::size_t rows() const { return flat() ? 1 : map_.axes[y_].values.size(); }

  double longest_label(std::size_t axis) const {
    std::size_t longest = 0;
    for (std::size_t i = 0; i < map_.axes[axis].values.size(); ++i)
      longest = std::max(longest, map_.axes[axis].label(i).size());
    return static_cast<double>(longest);
  }

  std::string ticks(std::size_t axis) const {
    std::string list;
    for (std::size_t i = 0; i < map_.axes[axis].values.size(); ++i)
      list += fmt::format("{}{} {}", i ? ", " : "", quoted(map_.axes[axis].label(i)),
                          static_cast<double>(i) + 0.5);
    return list;
  }

  static std::string title_of(const StabilityAxis& axis) {
    return axis.quantity + (axis.unit.empty() ? "" : ", " + axis.unit);
  }

  void add_panel(std::size_t i, PlotScript& script) const {
    const double left = left_ + static_cast<double>(i) * (panel_width_ + kGapX);
    script.begin_panel(left, kHead, panel_width_, panel_height_);
    script.add("{}", i == 0 && !flat() ? "set ytics (" + ticks(y_) + ")" : "unset ytics");
    const StabilityMethod& method = map_.methods[methods_[i]];
    const auto name = wrapped(method.name, static_cast<std::size_t>(panel_width_ / 6));
    script.labels(left, kHead - 8 - 12 * static_cast<double>(name.size() - 1), 12, name,
                  left_aligned(9, method.ours ? kBlue : kBlack));
    add_boxes(methods_[i], script);
  }

  // Adds the boxes of each outcome as one curve.
  void add_boxes(std::size_t method, PlotScript& script) const {
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
              fmt::format("{0} {1} {2} {3} {4:.5f} {5:.5f}\n", x + 0.5, (y + to) / 2, x + 0.04,
                          x + 0.96, y, to);
        y = to;
      }
    }
    std::vector<std::string> curves;
    for (std::size_t k = 0; k < kNumOutcomes; ++k) {
      if (data[k].empty()) continue;
      script.add("$d{} << EOD\n{}EOD", k, data[k]);
      curves.push_back(fmt::format(
          "$d{} using 1:2:3:4:5:6 with boxxyerror fillstyle solid 1 noborder lc rgb '{}'", k,
          kColours[k]));
    }
    script.plot(curves);
  }

  void add_surroundings(PlotScript& script) const {
    script.begin_surroundings();
    script.label(12, 20, map_.title, left_aligned(12));
    script.label(12, 40, "Shares of the trials in each cell. " + numbers(),
                 left_aligned(8.5, kDarkGrey));
    double y = kHead + panel_height_ + ticks_ + 12;
    script.label(left_ + (kWidth - left_ - kRight) / 2, y, title_of(map_.axes[x_]), "center");
    if (!flat())
      script.label(12, kHead + panel_height_ / 2, title_of(map_.axes[y_]), "center rotate by 90");
    y += 24;
    for (std::size_t k = 0; k < kNumOutcomes; ++k) {
      const auto outcome = static_cast<std::size_t>(kStack[k]);
      script.label(12 + 14 + (k % 2 ? 230.0 : 0.0), y + kLegendLine * static_cast<double>(k / 2),
                   kWords[outcome],
                   fmt::format("left offset 1,0 point pt 5 ps 0.8 lc rgb '{}'", kColours[outcome]));
    }
    script.labels(12, y + 2 * kLegendLine + 4, kFoot, foot_, left_aligned(7, "#666666"));
    script.plot({});
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
  return Picture(map, result, origin).png();
}

}  // namespace tagcal::study
