// Borders that are not where they were printed: ink that has spread, grey levels that are a power
// of light. Corners stay where they would be without.

#include <gtest/gtest.h>

#include <cmath>

#include "corner_tally.hpp"
#include "rendered_tag.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/tag_fit/picture_processing.hpp"

namespace tagcal {
using namespace internal;
namespace {

struct Print {
  double ink_px = 0;  // that black has grown
  double gamma = 1;
  double side_px = 40;
  double blur_px = 0.8;
};

// Tags tilted by up to 60 degrees.
class PrintedTags {
 public:
  explicit PrintedTags(const Print& print) : print_(print) {}

  TagView next() {
    const double side = print_.side_px, middle = 1.495 * side;
    TagScene tag({side, random_.uniform(0, 60), print_.blur_px, 2}, random_);
    const int width = static_cast<int>(3 * side);
    tag.scene.camera = {pinhole(900, 900, middle, middle), {width, width}};
    tag.scene.ink_spread_m = print_.ink_px / side;  // the tag's side is 1 m
    tag.scene.sensor.gamma = print_.gamma;
    tag.scene.paper_level = std::pow(220 / 255.0, 1 / print_.gamma);
    tag.scene.ink_level = std::pow(30 / 255.0, 1 / print_.gamma);
    const Pose pose = tag_pose(Eigen::Vector3d::UnitZ(), 900 / side, random_.uniform(0, 60),
                               random_turns(random_));
    return tag.view(pose, random_);
  }

  Random& random() { return random_; }

 private:
  Print print_;
  Random random_{77};
};

Trials trials(const Print& print, TagFitOptions options) {
  PrintedTags tags(print);
  const TagFamily family = tag_family("tag36h11", 1);
  Tally tally;
  for (int i = 0; i < 40; ++i) {
    const TagView view = tags.next();
    const Corners start = moved(view.corners, 0.2, tags.random());
    tally.add(refine_tag(view.image, tag_pattern(family, view.id, 1), start, options),
              view.corners);
  }
  return tally.result();
}

TagFitOptions straight_lines() {
  TagFitOptions options;
  options.bend_sd_per_px = 0;
  return options;
}

TEST(EdgeShift, CornersStayWhereInkHasSpread) {
  TagFitOptions options = straight_lines();
  options.shift_sd_px = 0.1;
  for (const double ink_px : {-0.3, -0.15, 0.0, 0.15, 0.3}) {
    const Trials t = trials({ink_px, 1}, options);
    EXPECT_EQ(t.failed, 0) << ink_px;
    EXPECT_LT(std::abs(t.outwards), 0.005) << ink_px;
    EXPECT_LT(t.rms, 0.008) << ink_px;
    EXPECT_NEAR(t.nees, 1, 0.3) << ink_px;
  }
  EXPECT_GT(trials({0.15, 1}, straight_lines()).outwards, 0.03);
}

// Large tags are fitted corner by corner, with the shift that few rows of the whole tag show.
TEST(EdgeShift, CornersOfLargeTagsStayWhereInkHasSpread) {
  TagFitOptions options;
  options.shift_sd_px = 0.1;
  for (const double blur_px : {0.3, 0.8})
    for (const double ink_px : {-0.3, 0.3}) {
      const Trials t = trials({ink_px, 1, 160, blur_px}, options);
      EXPECT_EQ(t.failed, 0) << ink_px;
      EXPECT_LT(std::abs(t.outwards), 0.005) << ink_px << " " << blur_px;
      EXPECT_NEAR(t.nees, 1, 0.3) << ink_px << " " << blur_px;
    }
}

TEST(EdgeShift, CornersStayUnderGamma) {
  TagFitOptions options = straight_lines();
  options.shift_sd_px = 0.1;
  EXPECT_GT(trials({0, 0.45}, options).nees, 1.4);  // what the residuals show widens the claims
  options.processing.gamma = 0.45;
  for (const double ink_px : {0.0, 0.1}) {
    const Trials t = trials({ink_px, 0.45}, options);
    EXPECT_EQ(t.failed, 0) << ink_px;
    EXPECT_LT(std::abs(t.outwards), 0.005) << ink_px;
    EXPECT_NEAR(t.nees, 1, 0.3) << ink_px;
  }
}

TEST(EdgeShift, APictureShowsItsGamma) {
  const TagFamily family = tag_family("tag36h11", 1);
  for (const double gamma : {1.0, 0.7, 0.45}) {
    PrintedTags tags({0.1, gamma});
    for (int i = 0; i < 5; ++i) {
      const TagView view = tags.next();
      const TagPattern pattern = tag_pattern(family, view.id, 1);
      EXPECT_NEAR(processing_of_picture(view.image, {{&pattern, view.corners}}).gamma, gamma, 0.1);
    }
  }
}

}  // namespace
}  // namespace tagcal
