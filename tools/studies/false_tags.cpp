// Counts tags reported in pictures without tags.
//   false_tags [PICTURES, default 1000 [FIRST_SEED, default 1]]
// Pictures of 640x480: noise, smoothed noise, rows of letter-like strokes, checkerboards, and
// clutter of dark frames with random bits, in turn. Targets: a Kalibr board, and plain boards of
// every family.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "false_tag_pictures.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"

int main(int argc, char** argv) {
  using namespace tagcal;
  const int wanted = argc > 1 ? std::atoi(argv[1]) : 1000;
  const int first = argc > 2 ? std::atoi(argv[2]) : 1;
  std::vector<std::pair<std::string, Board>> targets = {
      {"tag36h11 border 2", make_board(AprilGrid{6, 6, 0.088, 0.3, 0})}};
  for (const std::string& family : tag_family_names()) {
    const int ids = std::min(36, static_cast<int>(tag_family(family, 1).codes.size()));
    targets.emplace_back(family + " border 1",
                         make_board(AprilGrid{6, ids / 6, 0.04, 1.2, 0, family, 1, false}));
  }
  std::printf("%-26s %9s %14s %10s\n", "target", "pictures", "with a tag", "tags");
  for (const auto& [name, board] : targets) {
    std::vector<ImageSource> images;
    for (int seed = first; seed < first + wanted; ++seed) {
      images.push_back({std::to_string(seed),
                        [seed] { return picture_without_tags(static_cast<std::uint64_t>(seed)); }});
    }
    int pictures = 0;
    std::size_t tags = 0;
    for (const View& view : views_of(detect_all(images, {{board, Pose()}}))) {
      pictures += !view.observations.empty();
      tags += view.observations.size() / 4;
    }
    std::printf("%-26s %9d %14d %10zu\n", name.c_str(), wanted, pictures, tags);
    std::fflush(stdout);
  }
}
