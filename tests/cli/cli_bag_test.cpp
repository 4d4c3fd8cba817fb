// Bags among the pictures, and the choice of frames, from outside.
#include "cli_fixture.hpp"
#include "mcap_writer.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

class CliBag : public Cli {
 protected:
  // A bag of rendered pictures, at 10 Hz.
  void render(int views) {
    spill(root() / "scene.yaml",
          "camera: {image_size: [320, 240], model: f, f: 270}\n"
          "boards:\n"
          "  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: "
          "0.3}\n"
          "    world_from_board: {translation_m: [-0.2, -0.2, 0]}\n"
          "path: {type: ring, radius_m: 0.5, centre_m: [0, 0, 0.6], end_deg: 120}\n"
          "views: " +
              std::to_string(views) + "\nsensor: {blur_px: 0.6, noise_levels: 1}\n");
    good_run("render " + path("scene.yaml") + " --force --out " + path("set"));
    McapWriter bag("/camera/image_raw");
    double time_s = 1000;
    for (const fs::path& picture : list_pictures(root() / "set/images"))
      bag.add(McapWriter::message(read_image(picture), time_s += 0.1));
    spill(root() / "a.mcap", bag.bytes());
  }
};

TEST_F(CliBag, HasTheCornersOfItsPictures) {
  render(4);
  const std::string detect = "detect --target " + path("set/target.yaml") + " --no-cache --out ";
  ASSERT_EQ(run(detect + path("a.csv") + " " + path("set/images")).exit_code, 0);
  good_run(detect + path("b.csv") + " " + path("a.mcap") + ":/camera/image_raw");
  const std::string of_bag = slurp(root() / "b.csv");
  EXPECT_HAS(of_bag, ",time_s\na@000000,");
  EXPECT_HAS(of_bag, ",1000.300000\n");
  const std::string plain =
      std::regex_replace(std::regex_replace(of_bag, std::regex(",(time_s|1000\\.\\d+)\n"), "\n"),
                         std::regex("a@000"), "");
  EXPECT_EQ(plain, std::regex_replace(slurp(root() / "a.csv"), std::regex("\\.png"), ""));
  // The corners of a bag are a data set's.
  spill(root() / "set/dataset.yaml",
        "image_size: [320, 240]\ntarget: target.yaml\nobservations: ../b.csv\n");
  good_run("calibrate " + path("set") + " --model f");
}

TEST_F(CliBag, FramesThatAddMostAreUsed) {
  render(75);
  const std::string calibrate =
      "calibrate --target " + path("set/target.yaml") + " --model f --json --no-cache ";
  const Outcome out =
      good_run(calibrate + path("a.mcap") + " --keep " + path("used") + " --explain");
  const auto frames = nlohmann::json::parse(out.out).at("frames");
  EXPECT_EQ(frames.at("all"), 75);
  EXPECT_EQ(frames.at("with_board"), 75);
  const int used = frames.at("used");
  EXPECT_EQ(
      used + int{frames.at("fast")} + int{frames.at("no_pose")} + int{frames.at("add_nothing")},
      75);
  EXPECT_GT(used, 5);
  EXPECT_LE(used, 75);
  EXPECT_EQ(std::distance(fs::directory_iterator(root() / "used"), fs::directory_iterator()), used);
  EXPECT_HAS(out.err, "a@000074: ");
  // Fewer for a goal; all if they are named.
  const Outcome goal = run(calibrate + path("a.mcap") + " --until 1px");
  EXPECT_LT(int{nlohmann::json::parse(goal.out).at("frames").at("used")}, used) << goal.err;
  const Outcome all = run(calibrate + path("a.mcap") + " --frames all");
  EXPECT_TRUE(nlohmann::json::parse(all.out).at("frames").is_null());
  for (const std::string& option :
       {"--keep " + path("k"), std::string("--until 1px"), std::string("--explain")}) {
    const Outcome wrong = run(calibrate + path("a.mcap") + " --frames all " + option);
    EXPECT_EQ(wrong.exit_code, 2);
    EXPECT_HAS(wrong.err, "belongs to the frames that are chosen");
  }
}

TEST_F(CliBag, BadInputIsOneLine) {
  render(2);
  for (const auto& [arguments, message] :
       {std::pair{path("a.mcap") + ":/left",
                  std::string("has no topic /left: it has /camera/image_raw")},
        {path("b.mcap") + ":/left", "no such file"},
        {path("a.mcap") + " " + path("a.mcap"), "given twice"}}) {
    const Outcome out = run("detect " + arguments + " --target " + path("set/target.yaml") +
                            " --out " + path("none.csv"));
    EXPECT_EQ(out.exit_code, 2) << arguments << out.err;
    EXPECT_HAS(out.err, message);
    EXPECT_EQ(std::ranges::count(out.err, '\n'), 1) << out.err;
  }
  // The bag is not replaced by an answer about it.
  const Outcome same = run("detect " + path("a.mcap") + ":/camera/image_raw --target " +
                           path("set/target.yaml") + " --out " + path("a.mcap"));
  EXPECT_EQ(same.exit_code, 2) << same.err;
}

}  // namespace
}  // namespace tagcal::tools
