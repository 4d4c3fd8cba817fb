#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {

// Places names beside points of a picture, so that no name covers another one or a marked point:
// each at the nearest free place around its point, with a line to it if that is not beside it. A
// name without a free place is left out.
class SvgLabels {
 public:
  explicit SvgLabels(const Window& area) : area_(area) {}

  double height() const { return area_.top; }

  void keep_free(const Eigen::Vector2d& point);
  void add(std::string_view text, const Eigen::Vector2d& point, std::string_view colour);

  // Places all names, those that were added first at the best places.
  std::string svg();

 private:
  struct Name {
    std::string text;
    Eigen::Vector2d point;
    std::string_view colour;
  };

  void place(const Name& name);
  bool is_free(const Window& box, const Segment2& leader) const;
  void draw(const Name& name, const Window& box, const Segment2& leader);

  Window area_;
  std::vector<Name> names_;
  std::vector<Window> taken_;
  std::vector<Segment2> leaders_;
  std::string svg_;
};

}  // namespace tagcal::tools
