#pragma once

#include <array>
#include <string_view>

namespace tagcal::tools {

// A sheet of paper in portrait, in millimetres (ISO 216; ANSI A).
struct Paper {
  std::string_view name;
  double width_mm = 0;
  double height_mm = 0;

  Paper landscape() const { return {name, height_mm, width_mm}; }
};

inline constexpr std::array kPapers = {Paper{"a4", 210, 297}, Paper{"letter", 215.9, 279.4},
                                       Paper{"a3", 297, 420}};

}  // namespace tagcal::tools
