#pragma once

#include <optional>

#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/image.hpp"

// Private to detect.
namespace tagcal::internal {

// A picture of a tag and what is about it, upright and from the front, in which its sides are
// straight whatever the lens.
class StraightTag {
 public:
  // `margin_cells`: what is shown about the tag, whose sides have `width_at_border` cells. No value
  // if the view does not show the tag.
  static std::optional<StraightTag> of(const ImageView8& image, const PlacedTag& tag,
                                       const PlaneView& view, int width_at_border,
                                       double margin_cells);

  const Image8& image() const { return image_; }
  const Quad& expected() const { return expected_; }     // the tag's corners in image()
  const Quad& in_picture() const { return predicted_; }  // and in the picture
  // Corners in the picture from those in image(), and back.
  std::optional<Quad> in_picture(const Quad& corners) const;
  std::optional<Quad> straightened(const Quad& corners) const;

 private:
  explicit StraightTag(const PlaneView& view) : view_(view) {}
  Eigen::Vector2d on_plane(const Eigen::Vector2d& pixel) const;

  PlaneView view_;
  Image8 image_;
  Quad expected_, predicted_;
  Eigen::Vector2d upper_left_, right_, down_;  // of image(), and its steps on the panel
};

}  // namespace tagcal::internal
