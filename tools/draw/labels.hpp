#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "study/plot/drawing.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {

// Places names beside points of a picture, so that no name covers another one or a marked point:
// each at the nearest free place around its point, with a line to it if that is not beside it. A
// name without a free place is left out.
class Labels {
 public:
  explicit Labels(const Window& area) : area_(area) {}

  double height() const { return area_.top; }

  void keep_free(const Eigen::Vector2d& point);
  void add(std::string_view text, const Eigen::Vector2d& point, std::string_view colour);

  // Places all names, those that were added first at the best places.
  void draw(study::Drawing& drawing);

 private:
  bool is_free(const Window& box, const Segment2& leader) const;
  void place(study::Text name, study::Drawing& drawing);

  Window area_;
  std::vector<study::Text> names_;  // at their points
  std::vector<Window> taken_;
  std::vector<Segment2> leaders_;
};

}  // namespace tagcal::tools
