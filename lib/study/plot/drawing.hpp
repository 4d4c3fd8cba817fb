#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

// A chart as data: lines, areas and texts in pixels from its upper left corner. tools/draw paints
// it. Private to study and the tools.

namespace tagcal::study {

// Colours that colour-blind readers can distinguish (Okabe & Ito 2008), and a grey for remarks.
inline constexpr std::string_view kBlue = "#0072B2", kSkyBlue = "#56B4E9", kGreen = "#009E73",
                                  kYellow = "#F0E442", kOrange = "#E69F00", kVermilion = "#D55E00",
                                  kPurple = "#CC79A7", kBlack = "#000000", kDarkGrey = "#444444";

struct Path {
  std::vector<Eigen::Vector2d> points;
  std::string colour = std::string(kBlack);  // "#RRGGBB"
  double width = 0;                          // of the line; 0: the closed path is filled
  double opacity = 1;
  double dash = 0;  // length of a dash and of the gap after it; 0: solid
};

struct Text {
  enum class At { left, middle, right };
  Eigen::Vector2d place;  // of the middle of its height
  std::string text;
  double size = 8.5;
  std::string colour = std::string(kBlack);
  At at = At::left;
  bool upwards = false;  // turned by a quarter
  double halo = 0;       // width of a white line around the letters
};

struct Drawing {
  double width = 0, height = 0;
  std::vector<std::variant<Path, Text>> items = {};

  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::string_view colour,
            double width_px, double opacity = 1, double dash = 0);
  void area(double left, double top, double right, double bottom, std::string_view colour);
  void text(double x, double y, std::string_view text, double size,
            std::string_view colour = kBlack, Text::At at = Text::At::left, bool upwards = false);
  // Lines of text below each other.
  void texts(double x, double y, double line_height, std::span<const std::string> lines,
             double size, std::string_view colour);

  void add(const Drawing& part, const Eigen::Vector2d& place);  // place: of its upper left corner

  bool has_text(std::string_view text) const;
};

// The shapes of marks.
enum class Mark { disc, square, triangle, wedge, diamond, plus, cross };

// A mark about a place; open ones have a line only.
void add_mark(Mark mark, bool filled, const Eigen::Vector2d& place, double radius,
              std::string_view colour, Drawing& drawing);

// Breaks a text at its spaces into lines of at most `width` bytes; a longer word stays whole.
std::vector<std::string> wrapped(std::string_view text, std::size_t width);
// The lines of the footnote that says how the numbers were made.
std::vector<std::string> footnote(std::span<const std::string> origin);

}  // namespace tagcal::study
