#include "study/atlas/atlas_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace tagcal::study {
namespace {

// By StabilityOutcome.
constexpr std::array<std::string_view, kNumOutcomes> kColours = {kBlue, "#D0D0D0", kVermilion,
                                                                 kYellow};
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

  Drawing drawing() const {
    Drawing drawing{kWidth, height_};
    for (std::size_t i = 0; i < methods_.size(); ++i) add_panel(i, drawing);
    add_surroundings(drawing);
    return drawing;
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

  static std::string title_of(const StabilityAxis& axis) {
    return axis.quantity + (axis.unit.empty() ? "" : ", " + axis.unit);
  }

  void add_panel(std::size_t i, Drawing& drawing) const {
    const double left = left_ + static_cast<double>(i) * (panel_width_ + kGapX);
    const double bottom = kHead + panel_height_;
    const StabilityMethod& method = map_.methods[methods_[i]];
    const auto name = wrapped(method.name, static_cast<std::size_t>(panel_width_ / 6));
    drawing.texts(left, kHead - 8 - 12 * static_cast<double>(name.size() - 1), 12, name, 9,
                  method.ours ? kBlue : kBlack);
    for (std::size_t c = 0; c < columns(); ++c)
      drawing.text(left + cell_width() * (static_cast<double>(c) + 0.5), bottom + 5,
                   map_.axes[x_].label(c), 8, kDarkGrey, Text::At::right, true);
    for (std::size_t r = 0; i == 0 && !flat() && r < rows(); ++r)
      drawing.text(left - 5, bottom - cell_height() * (static_cast<double>(r) + 0.5),
                   map_.axes[y_].label(r), 8, kDarkGrey, Text::At::right);
    add_boxes(methods_[i], left, drawing);
    drawing.items.emplace_back(Path{{{left, kHead},
                                     {left + panel_width_, kHead},
                                     {left + panel_width_, bottom},
                                     {left, bottom},
                                     {left, kHead}},
                                    "#777777",
                                    0.8});
  }

  double cell_width() const { return panel_width_ / static_cast<double>(columns()); }
  double cell_height() const { return panel_height_ / static_cast<double>(rows()); }

  // In each cell the shares of the outcomes, from its lower to its upper end.
  void add_boxes(std::size_t method, double left, Drawing& drawing) const {
    const double w = cell_width(), h = cell_height();
    for (const StabilityTally& tally : result_.tallies) {
      if (tally.method != method) continue;
      const std::vector<std::size_t> at = map_.indices(tally.cell);
      const double x = left + w * (static_cast<double>(at[x_]) + 0.04);
      const double row = flat() ? 0 : static_cast<double>(at[y_]);
      double y = kHead + panel_height_ - h * (row + 0.04);
      for (const StabilityOutcome outcome : kStack) {
        const double to = y - 0.92 * h * tally.share(outcome);
        if (to < y)
          drawing.area(x, to, x + 0.92 * w, y, kColours[static_cast<std::size_t>(outcome)]);
        y = to;
      }
    }
  }

  void add_surroundings(Drawing& drawing) const {
    drawing.text(12, 20, map_.title, 12);
    drawing.text(12, 40, "Shares of the trials in each cell. " + numbers(), 8.5, kDarkGrey);
    double y = kHead + panel_height_ + ticks_ + 12;
    drawing.text(left_ + (kWidth - left_ - kRight) / 2, y, title_of(map_.axes[x_]), 9, kBlack,
                 Text::At::middle);
    if (!flat())
      drawing.text(12, kHead + panel_height_ / 2, title_of(map_.axes[y_]), 9, kBlack,
                   Text::At::middle, true);
    y += 24;
    for (std::size_t k = 0; k < kNumOutcomes; ++k) {
      const auto outcome = static_cast<std::size_t>(kStack[k]);
      const double x = 26 + (k % 2 ? 230.0 : 0.0);
      const double line = y + kLegendLine * static_cast<double>(k / 2);
      drawing.area(x - 4, line - 4, x + 4, line + 4, kColours[outcome]);
      drawing.text(x + 10, line, kWords[outcome], 8.5);
    }
    drawing.texts(12, y + 2 * kLegendLine + 4, kFoot, foot_, 7, "#666666");
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

Drawing atlas_picture(const StabilityMap& map, const StabilityResult& result,
                      std::span<const std::string> origin) {
  return Picture(map, result, origin).drawing();
}

}  // namespace tagcal::study
