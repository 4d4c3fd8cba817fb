// Holds the renderer and the exact corners to rays, in random scenes of 2 to 12 sheets that cut
// each other, hide each other in rings, share edges or lie in one plane, through perspective,
// fisheye and parallel lenses: every pixel at least 1 px from a visible border or intersection of
// sheets.
//   visibility [SCENES, default 10000 [FIRST, default 0]]

#include <cstdio>
#include <cstdlib>

#include "random_sheets.hpp"
#include "tagcal/detect/families.hpp"

int main(int argc, char** argv) {
  using namespace tagcal;
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 10000;
  const int first = argc > 2 ? std::atoi(argv[2]) : 0;
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", 1)}};
  sheet_rays::Counts counts;
  for (int i = first; i < first + scenes; ++i) {
    const sheet_rays::Counts before = counts;
    sheet_rays::compare(1, static_cast<std::uint64_t>(i), families, counts);
    const long pixels = counts.wrong_pixels - before.wrong_pixels;
    const long points = counts.wrong_points - before.wrong_points;
    if (pixels + points > 0)
      std::printf("scene %d: %ld pixels, %ld points wrong\n", i, pixels, points);
  }
  std::printf(
      "%d scenes from %d, %ld with sheets that cut each other\n"
      "pixels: %ld compared, %ld wrong\npoints: %ld compared, %ld wrong\n",
      scenes, first, counts.cut_scenes, counts.pixels, counts.wrong_pixels, counts.points,
      counts.wrong_points);
  return counts.wrong_pixels + counts.wrong_points > 0 ? 1 : 0;
}
