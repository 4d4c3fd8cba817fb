// tagcal detect --explain and --draw, from outside.
#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

TEST_F(Cli, DrawWritesAPictureOfEachView) {
  const Outcome outcome = run("detect " + path("set") + " --draw " + path("drawn"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, run("detect " + path("set")).out);
  const auto drawn = bytes_of(root() / "drawn");
  EXPECT_EQ(drawn.size(), 6u);
  const Image8 before = read_image(root() / "set/images/000.png");
  const Image8 after = read_image(root() / "drawn/000.png");
  ASSERT_EQ(after.size(), before.size());
  int changed = 0;
  for (std::size_t i = 0; i < before.pixels().size(); ++i)
    changed += std::abs(before.pixels()[i] - after.pixels()[i]) > 20;
  EXPECT_GT(changed, 1000);
  EXPECT_LT(changed, 640 * 400 / 4);
  expect_bad_input("detect " + path("set") + " --draw " + path("scene.yaml"), {"scene.yaml"});
}

TEST_F(Cli, TwoPicturesOfOneNameAreNotDrawnOverEachOther) {
  fs::create_directories(root() / "a");
  fs::create_directories(root() / "b");
  fs::copy_file(root() / "set/images/000.png", root() / "a/x.png");
  fs::copy_file(root() / "set/images/001.png", root() / "b/x.png");
  expect_bad_input("detect --target " + path("set/target.yaml") + " " + path("a/x.png") + " " +
                       path("b/x.png") + " --draw " + path("over"),
                   {"x.png", "two pictures"});
  EXPECT_FALSE(fs::exists(root() / "over"));
}

TEST_F(Cli, ExplainNamesTheMistakeOnStderr) {
  const std::string target = slurp(root() / "set/target.yaml");
  spill(root() / "kalibr.yaml", replaced(target, "border_bits: 1", "border_bits: 2"));
  const std::string picture = path("set/images/000.png");
  const Outcome good =
      run("detect --target " + path("set/target.yaml") + " " + picture + " --explain");
  ASSERT_EQ(good.exit_code, 0) << good.err;
  EXPECT_EQ(good.out, run("detect --target " + path("set/target.yaml") + " " + picture).out);
  EXPECT_NE(good.err.find("four-sided shapes"), std::string::npos) << good.err;
  EXPECT_EQ(good.err.find("wrong"), std::string::npos) << good.err;
  const Outcome bad = run("detect --target " + path("kalibr.yaml") + " " + picture + " --explain");
  EXPECT_EQ(bad.exit_code, 0);
  EXPECT_NE(bad.err.find("wrong border: "), std::string::npos) << bad.err;
}

}  // namespace
}  // namespace tagcal::tools
