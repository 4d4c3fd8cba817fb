#include "study/plot/plot_script.hpp"

#include <algorithm>

namespace tagcal::study {

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> lines(1);
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width)
      lines.emplace_back();
    lines.back().append(lines.back().empty() ? "" : " ").append(word);
    text.remove_prefix(std::min(word.size() + 1, text.size()));
  }
  return lines;
}

std::vector<std::string> footnote(std::span<const std::string> origin) {
  return wrapped(fmt::format("{}", fmt::join(origin, " · ")), 150);
}

std::string quoted(std::string_view text) {
  std::string result = "'";
  for (const char c : text) result.append(c == '\'' ? 2 : 1, c);
  return result + "'";
}

std::string left_aligned(double font_size, std::string_view colour) {
  return fmt::format("left textcolor rgb '{}' font ',{}'", colour, font_size);
}

void PlotScript::begin_panel(double left, double top, double width, double height) {
  add("unset label\nset lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\n"
      "set tmargin at screen {:.5f}\nset bmargin at screen {:.5f}",
      left / width_, (left + width) / width_, 1 - top / height_, 1 - (top + height) / height_);
}

void PlotScript::begin_surroundings() {
  begin_panel(0, 0, width_, height_);
  add("unset tics\nunset border\nunset grid\nunset logscale\nset xrange [0:1]\nset yrange [0:1]");
}

void PlotScript::label(double x, double y, std::string_view text, std::string_view style) {
  add("set label {} at screen {:.5f},{:.5f} {}", quoted(text), x / width_, 1 - y / height_, style);
}

void PlotScript::labels(double x, double y, double line_height, std::span<const std::string> lines,
                        std::string_view style) {
  for (std::size_t i = 0; i < lines.size(); ++i)
    label(x, y + line_height * static_cast<double>(i), lines[i], style);
}

void PlotScript::plot(std::span<const std::string> curves) {
  add("plot {}", curves.empty() ? "NaN notitle" : fmt::format("{}", fmt::join(curves, ", ")));
}

std::string PlotScript::text(std::string_view terminal, double scale) const {
  return fmt::format(
      "set terminal {} size {},{} noenhanced background '#ffffff'\nset encoding utf8\n"
      "set multiplot\nset border lc rgb '#777777' lw 0.8\nunset key\n{}unset multiplot\n",
      terminal, scale * width_, scale * height_, commands_);
}

}  // namespace tagcal::study
