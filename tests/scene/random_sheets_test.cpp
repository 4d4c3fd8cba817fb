// The renderer and the exact corners against rays; tools/studies/visibility takes 10,000 scenes.
#include "random_sheets.hpp"

#include <gtest/gtest.h>

#include "tagcal/detect/families.hpp"

namespace tagcal {
namespace {

TEST(RandomSheets, PicturesAndExactCornersShowWhatRaysMeetFirst) {
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  sheet_rays::Counts counts;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const long before = counts.wrong_pixels + counts.wrong_points;
    sheet_rays::compare(2, i, families, counts);
    EXPECT_EQ(counts.wrong_pixels + counts.wrong_points, before) << "scene " << i;
  }
  EXPECT_GT(counts.cut_scenes, 60);
  EXPECT_GT(counts.pixels, 1500000);
  EXPECT_GT(counts.points, 1500);
}

}  // namespace
}  // namespace tagcal
