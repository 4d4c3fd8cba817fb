#pragma once

#include <fmt/format.h>

#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Writes pictures of several panels as scripts for gnuplot (5.4). Private to study.

namespace tagcal::study {

// Colours that colour-blind readers can distinguish (Okabe & Ito 2008), and a grey for remarks.
inline constexpr const char *kBlue = "#0072B2", *kSkyBlue = "#56B4E9", *kGreen = "#009E73",
                            *kYellow = "#F0E442", *kOrange = "#E69F00", *kVermilion = "#D55E00",
                            *kPurple = "#CC79A7", *kBlack = "#000000", *kDarkGrey = "#444444";

// Breaks a text at its spaces into lines of at most `width` bytes; a longer word stays whole.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);
// The lines of the footnote that says how the numbers were made.
std::vector<std::string> footnote(std::span<const std::string> origin);
// The text as a string in gnuplot's single quotes.
std::string quoted(std::string_view text);
// Style of a label that is aligned to the left.
std::string left_aligned(double font_size, std::string_view colour = kBlack);

// Collects the commands of one picture. Positions are pixels from its upper left corner.
class PlotScript {
 public:
  PlotScript(double width_px, double height_px) : width_(width_px), height_(height_px) {}

  // Adds one command, formatted by fmt.
  template <typename... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(commands_), format, std::forward<Arguments>(arguments)...);
    commands_ += '\n';
  }

  // Begins a panel with this plotting area; labels of the last panel are removed.
  void begin_panel(double left, double top, double width, double height);
  // Begins an empty panel over the whole picture, for the labels outside of the other panels.
  void begin_surroundings();
  void label(double x, double y, std::string_view text, std::string_view style);
  void labels(double x, double y, double line_height, std::span<const std::string> lines,
              std::string_view style);
  // Draws the panel: its labels and its curves, each as an argument of gnuplot's `plot`.
  void plot(std::span<const std::string> curves);

  std::string svg() const { return text("svg font 'DejaVu Sans,11'", 1); }
  std::string png() const {  // with twice as many pixels
    return text("pngcairo font 'DejaVu Sans,8.5' fontscale 2 linewidth 2 pointscale 2", 2);
  }

 private:
  std::string text(std::string_view terminal, double scale) const;

  double width_, height_;
  std::string commands_;
};

}  // namespace tagcal::study
