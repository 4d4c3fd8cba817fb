// The pictures of tagcal pose --draw.
#include <cmath>

#include "cli_pose_fixture.hpp"
#include "png_colours.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector3d;

TEST_F(PoseCli, DrawsTheAxesWhereTheyAre) {
  const fs::path drawings = root() / "drawings";
  spill(drawings / "notes.txt", "mine");
  good_run("pose " + set() + known() + " --draw " + drawings.string());
  const auto files = bytes_of(drawings);
  EXPECT_EQ(files.size(), 7u);
  EXPECT_EQ(files.at("notes.txt"), "mine");
  EXPECT_EQ(bytes_of(root() / "set").size(), 6u + 4u);  // the pictures are unchanged
  const Truth t = truth();
  const double length = (4 * 0.06 + 3 * 0.018) / 2;
  int seen[3] = {0, 0, 0};
  for (const auto& [image, camera_from_world] : t.camera_from_world) {
    const fs::path file = drawings / (fs::path(image).stem().string() + "-pose.png");
    ASSERT_EQ(read_image_size(file), (ImageSize{640, 400}));
    const std::vector<Rgb> colours = png_colours(file);
    for (int axis = 0; axis < 3; ++axis)
      for (const double share : {0.43, 0.55, 0.8}) {
        const auto pixel =
            project(t.camera.lens, camera_from_world * (share * length * Vector3d::Unit(axis)));
        if (!pixel || !contains(t.camera.image_size, *pixel)) continue;
        const Rgb& colour = colours[static_cast<std::size_t>(std::lround(pixel->y()) * 640 +
                                                             std::lround(pixel->x()))];
        const auto own = static_cast<std::size_t>(axis);
        // Other lines and corners may cover parts of it.
        seen[axis] +=
            colour[own] > colour[(own + 1) % 3] + 60 && colour[own] > colour[(own + 2) % 3] + 60;
      }
  }
  for (const int count : seen) EXPECT_GE(count, 9);
}

TEST_F(PoseCli, ThePageShowsWhatTheCommandDraws) {
  ASSERT_EQ(run(on_the_page(path("page-drawings")).arguments).exit_code, 0);
  const auto shown = png_colours(fs::path(TAGCAL_SOURCE_DIR) / "docs/tasks/pose.png");
  const auto drawn = png_colours(root() / "page-drawings" / "002-pose.png");
  ASSERT_EQ(shown.size(), drawn.size());
  int others = 0;  // rounding moves an edge by a little
  for (std::size_t i = 0; i < shown.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) others += std::abs(shown[i][c] - drawn[i][c]) > 8;
  EXPECT_LT(others, 200);
}

// Drawings among the pictures would be pictures of the next command.
TEST_F(PoseCli, DrawsNotIntoTheFolderOfThePictures) {
  expect_bad_input("pose " + path("set") + " --camera " + path("set/truth.yaml") + " --draw " +
                       path("set/images"),
                   {"--draw: ", "has the pictures"});
}

TEST_F(PoseCli, DrawsOnWhiteWithoutPictures) {
  const fs::path folder = exact_set("no-pictures");
  fs::remove_all(folder / "images");
  const fs::path drawings = root() / "white";
  good_run("pose " + folder.string() + known() + " --view 000.png --draw " + drawings.string() +
           "/");
  ASSERT_EQ(bytes_of(drawings).size(), 1u);
  const Image8 grey = read_image(drawings / "000-pose.png");
  const auto white = std::ranges::count(grey.pixels(), 255);
  EXPECT_GT(white, 640 * 400 * 8 / 10);
  EXPECT_LT(white, 640 * 400 * 99 / 100);
}

TEST_F(PoseCli, NamesThatArePathsStayInTheFolder) {
  const fs::path folder = exact_set("paths");
  std::string csv = slurp(folder / "observations_exact.csv");
  for (const char* name : {"000.png", "001.png"})
    for (std::size_t at; (at = csv.find(name)) != std::string::npos;)
      csv.replace(at, 7, name[2] == '0' ? "../a/b.x" : ".._a_b.x");
  spill(folder / "observations_exact.csv", csv);
  const std::string camera = known();  // writes its file
  const auto before = names();
  good_run("pose " + folder.string() + camera + " --draw " + (folder / "out").string());
  EXPECT_EQ(names(), before);
  const auto files = bytes_of(folder / "out");
  EXPECT_EQ(files.size(), 6u);
  EXPECT_TRUE(files.contains(".._a_b.x-pose.png"));
  EXPECT_TRUE(files.contains(".._a_b.x-2-pose.png"));
}

// With corners from a file, an unreadable picture is found only when it is drawn.
TEST_F(PoseCli, DrawingsAreWrittenAllOrNone) {
  const fs::path folder = root() / "damaged";
  fs::copy(root() / "set", folder, fs::copy_options::recursive);
  const std::string picture = slurp(folder / "images/004.png");
  spill(folder / "images/004.png", picture.substr(0, picture.size() / 2));
  spill(root() / "kept/000-pose.png", "old");
  const auto before = names();
  expect_bad_input("pose " + folder.string() + exact() + known() + " --draw " + path("kept"),
                   {"004.png"});
  EXPECT_EQ(names(), before);
  const auto files = bytes_of(root() / "kept");
  EXPECT_EQ(files.size(), 1u);
  EXPECT_EQ(files.at("000-pose.png"), "old");
}

}  // namespace
}  // namespace tagcal::tools
