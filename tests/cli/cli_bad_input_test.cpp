// Bad input gets one clear line and exit 2, and nothing half-written.
#include <sstream>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

TEST_F(Cli, UsageErrorsAreOneLineWithAHint) {
  expect_bad_input("rendr x", {"rendr", "unknown command", "did you mean render"});
  expect_bad_input("render x.yaml --out y --viewz 3",
                   {"--viewz", "did you mean --views", "--help"});
  expect_bad_input("render x.yaml", {"needs --out"});
  expect_bad_input("render x.yaml --out y --views 0", {"--views", "1 or more", "got 0"});
  expect_bad_input("render x.yaml --out y --views -3", {"--views", "got -3"});
  expect_bad_input("render x.yaml --out y --seed 1.5", {"--seed", "whole number", "got 1.5"});
  expect_bad_input("render x.yaml --out y --threads many", {"--threads", "got many"});
  expect_bad_input("detect " + path("set") + " --threads -1", {"--threads", "0 or more", "-1"});
  for (const std::string sigma : {"0", "nan", "inf", "-1", "0.1x"}) {
    expect_bad_input("calibrate set --sigma-px " + sigma, {"--sigma-px", "> 0", "got " + sigma});
  }
  expect_bad_input("calibrate " + path("set") + " --model opencv6",
                   {"opencv6", "opencv5", "fisheye4"});
  const std::string convert = "convert " + path("set/truth.yaml") + " " + path("x.bag");
  expect_bad_input(convert, {"choose one by --to: tagcal, opencv, ", " or tum"});
  expect_bad_input(convert + " --to roz", {"did you mean ros?"});
  const Outcome other_word = run(convert + " --to foo");  // shares one letter with ros
  EXPECT_LACKS(other_word.err, "did you mean");
  expect_bad_input("pose " + path("set") + " extra --camera c.yaml", {"extra", "one DATASET"});
  expect_bad_input("calibrate --target " + path("set/target.yaml"), {"needs DATASET|IMAGE"});
  expect_bad_input("detect " + path("set/images/000.png"), {"000.png", "--target"});
}

TEST_F(Cli, ForgottenValuesAndNamesOfTheOtherKindAreNamed) {
  const std::string straight =
      "reproject " + path("set/images/000.png") + " --camera " + path("set/truth.yaml");
  expect_bad_input(straight + " --undistort --out " + path("new"),
                   {"--undistort: needs a value before --out"});
  expect_bad_input(straight + " --undistort all --out " + path("new.jpg"),
                   {"new.jpg: must be a folder, got the name of a picture"});
  const std::string charuco =
      "target_type: charuco\nsquareCols: 7\nsquareRows: 5\nsquareSize: 30mm\nmarkerSize: 20mm\n";
  spill(root() / "squares.yaml", charuco + "dictionary: 4x4_50\n");
  expect_bad_input("board " + path("squares.yaml") + " --out " + path("squares.pdf"),
                   {"squares.yaml: dictionary: must be one of DICT_4X4_50, "});
}

TEST_F(Cli, OptionsWithoutEffectAreRefused) {
  const std::string set = path("set"), camera = path("set/truth.yaml"), page = path("page.html");
  const std::string corners = " --observations " + path("set/observations_exact.csv");
  for (const std::string& command : {std::string("calibrate "), "pose --camera " + camera + " "})
    expect_bad_input(command + set + corners + " --refinement edges",
                     {"--refinement: belongs to corners found in pictures"});
  expect_bad_input("calibrate " + set + " --frames all",
                   {"--frames: belongs to videos and bags, " + set});
  expect_bad_input("calibrate " + exact_set("exact").string() + " --refinement edges",
                   {"--refinement: belongs to corners found in pictures", "observations_exact"});
  expect_bad_input("report " + camera + " " + camera + " --camera " + camera + " --out " + page,
                   {"--camera: only for the poses"});
  expect_bad_input("report " + camera + " --distance 4 --out " + page,
                   {"--distance: needs two calibrations"});
  spill(root() / "poses.json", "{\"views\": []}\n");
  expect_bad_input("report " + path("poses.json") + " --camera " + camera + " --out " + page,
                   {"--camera: shows residuals, which need --dataset or --target"});
  EXPECT_FALSE(fs::exists(page));
  for (const std::string& input : {set, camera})
    expect_bad_input("view " + input + " --seed 0", {"--seed: belongs to a scene"});
  expect_bad_input("board " + path("set/target.yaml") + " --dpi 90 --out " + path("b.pdf"),
                   {"--dpi: belongs to a picture", "b.pdf"});
}

TEST_F(Cli, MessagesNameTheFileOrOptionThatIsWrong) {
  const std::string set = path("set"), camera = path("set/truth.yaml");
  spill(root() / "small.pgm", "P5\n8 8\n255\n" + std::string(64, 'x'));
  expect_bad_input(
      "pose --target " + path("set/target.yaml") + " " + path("small.pgm") + " --camera " + camera,
      {"truth.yaml: image size must be 8x8 as in " + path("small.pgm")});
  for (const std::string command : {"detect ", "calibrate "})
    expect_bad_input(command + set + " --exclude '*'", {"--exclude: leaves no picture"});
  expect_bad_input("detect " + set + " --family tag36h11",
                   {"set: is a data set: name its folder of pictures"});
  expect_bad_input("view " + set + "/images", {"has pictures, but no dataset.yaml\n"});
  fs::create_directory(root() / "own");
  fs::copy_file(root() / "set/images/000.png", root() / "own/000.png");
  expect_bad_input("calibrate " + path("own"), {"need their board, --target T.yaml)"});
  fs::copy_file(root() / "set/target.yaml", root() / "own/target.yaml");
  expect_bad_input("calibrate " + path("own"),
                   {"need their board, --target " + path("own/target.yaml") + ")"});
  fs::create_directory(root() / "bags");
  spill(root() / "bags/run.bag", "#ROSBAG V2.0\nop=3");
  for (const std::string command : {"calibrate ", "detect ", "pose --unknown-focal "})
    expect_bad_input(command + path("bags"), {"bags/run.bag: is a ROS bag", "@000123"});
  spill(root() / "ids.yaml",
        replaced(slurp(root() / "set/target.yaml"), "first_id: 0", "first_id: 580"));
  expect_bad_input("detect --target " + path("ids.yaml") + " " + set + "/images",
                   {"ids.yaml: board: tag id: must be in 0..586 of tag36h11, got 587"});
  expect_bad_input("detect -x.png", {"-x.png: unknown option"});
  spill(root() / "wide.yaml", replaced(slurp(camera), "640", "700"));
  expect_bad_input(
      "diff " + camera + " " + path("wide.yaml"),
      {path("wide.yaml") + ": image size must be 640x400 as in " + camera, "--resize"});
  const std::string target = " --target " + set + "/target.yaml";
  expect_bad_input("calibrate" + target + target + " " + set + "/images",
                   {"--target: takes one value only, a data set has several boards"});
  expect_bad_input("convert " + camera + " -", {"standard output has no name", "--to: tagcal"});
  const std::string plane = "reproject --camera " + camera + " --plane --view 000.png --maps" +
                            " --rectangle 0,0,1,1 --out " + path("plane") + " --m-per-px ";
  expect_bad_input(plane + "1e300", {"--m-per-px: no pixel is in the rectangle"});
  spill(root() / "tele.yaml",
        "image_width: 640\nimage_height: 400\n"
        "camera_matrix: {rows: 3, cols: 3, dt: d, data: [1e-300, 0, 317, 0, 500, 203, 0, 0, 1]}\n"
        "distortion_coefficients: {rows: 1, cols: 5, dt: d, data: [0, 0, 0, 0, 0]}\n");
  expect_bad_input(
      "reproject --camera " + path("tele.yaml") + " --undistort all --maps --out " + path("plane"),
      {path("tele.yaml") + ": --undistort all gives no camera: lens: fx must be > 0"});
  spill(root() / "far.yaml", replaced(kScene, "max_distance_m: 0.6", "max_distance_m: 1e300"));
  expect_bad_input("view " + path("far.yaml"), {path("far.yaml") + ": "});
  expect_bad_input("render " + path("far.yaml") + " --out " + path("far"),
                   {path("far.yaml") + ": "});
  EXPECT_FALSE(fs::exists(root() / "far"));
}

TEST_F(Cli, BadScenesAreNamed) {
  const struct {
    const char* from;
    const char* to;
    std::vector<std::string> parts;
  } cases[] = {
      {"views: 6", "views: 0", {"views", "0"}},
      {"views: 6", "views: six", {"views", "six"}},
      {"views: 6", "vews: 6", {"vews"}},
      {"f: 520", "f: .nan", {"camera", "f", "nan"}},
      {"f: 520", "f: .inf", {"camera", "f", "inf"}},
      {"f: 520", "f: -520", {"camera", "f", "-520"}},
      {"model: radial1", "model: radial7", {"model", "radial7"}},
      {"[640, 400]", "[640, -400]", {"image_size", "-400"}},
      {"tagSize: 0.06", "tagSize: -0.06", {"boards[0]", "tagSize", "-0.06"}},
      {"type: dome", "type: spiral", {"path", "type", "spiral"}},
      {"boards:", "boards: [", {"bad.yaml"}},
  };
  for (const auto& c : cases) {
    spill(root() / "bad.yaml", replaced(kScene, c.from, c.to));
    std::vector<std::string> parts = c.parts;
    parts.emplace_back("bad.yaml");
    expect_bad_input("render " + path("bad.yaml") + " --out " + path("bad"), parts);
    EXPECT_FALSE(fs::exists(root() / "bad"));
  }
}

TEST_F(Cli, WhatIsTooLargeIsRefusedBeforeTheWork) {
  spill(root() / "large.yaml", replaced(kScene, "[640, 400]", "[20000, 20000]"));
  expect_bad_input("render " + path("large.yaml") + " --out " + path("large"),
                   {"large.yaml", "camera", "100000000", "20000x20000"});
  expect_bad_input("render " + path("scene.yaml") + " --out " + path("large") + " --views 100001",
                   {"--views", "100000", "got 100001"});
  const std::string camera = path("set/truth.yaml");
  const std::string reproject =
      "reproject " + path("set/images/000.png") + " --camera " + camera + " --out " + path("large");
  expect_bad_input(reproject + " --pinholes 361", {"--pinholes", "360", "got 361"});
  expect_bad_input(reproject + " --undistort all --tiles 1x1", {"--tiles", "100000 folders"});
  EXPECT_FALSE(fs::exists(root() / "large"));
  spill(root() / "wall.yaml", replaced(slurp(root() / "set/target.yaml"), "0.06", "60"));
  expect_bad_input("board " + path("wall.yaml") + " --tile a4 --out " + path("wall.pdf"),
                   {"--tile", "500 pages of a4"});
}

TEST_F(Cli, BadPicturesAreNamed) {
  spill(root() / "empty.png", "");
  spill(root() / "text.png", "not a picture");
  spill(root() / "small.pgm", "P5 64 48 255\n" + std::string(64 * 48, '\0'));
  const std::string png = slurp(root() / "set/images/000.png");
  spill(root() / "cut.png", png.substr(0, png.size() / 2));
  const std::string detect =
      "detect --target " + path("set/target.yaml") + " " + path("set/images/001.png") + " ";
  spill(root() / "cut.jpg", std::string("\xff\xd8\xff\xe0\0\x10JFIF", 10));
  spill(root() / "cut.pgm", "P5 640 400 255\n" + std::string(1000, '\x80'));
  spill(root() / "deep.pgm", "P2 640 400 65535\n1 2 3");
  for (const std::string bad :
       {"empty.png", "text.png", "cut.png", "missing.png", "cut.jpg", "cut.pgm", "deep.pgm"}) {
    expect_bad_input(detect + path(bad) + " --strict", {bad});
    expect_bad_input(detect + path(bad) + " --strict --out " + path("never.csv"), {bad});
  }
  spill(root() / "list.txt", path("set/images/000.png") + std::string("\0x\n", 3));
  expect_bad_input(detect + "@" + path("list.txt"), {"list.txt", "line 1", "binary data"});
  expect_bad_input(detect + path("small.pgm"), {"small.pgm", "640x400", "64x48"});
  expect_bad_input(detect + path("set/images/001.png"), {"001.png", "given twice"});
  expect_bad_input(detect + path("set"), {"set"});
  EXPECT_FALSE(fs::exists(root() / "never.csv"));
  expect_bad_input("detect " + path("set") + " --out " + path("no/such/corners.csv"), {"no/such"});
  expect_bad_input("detect " + path("set") + " --out " + path("set"), {"set", "folder"});
}

TEST_F(Cli, BadDatasetsAreNamed) {
  const struct {
    const char* file;
    const char* from;
    const char* to;
    std::vector<std::string> parts;
  } cases[] = {
      {"dataset.yaml", "target:", "targets:", {"dataset.yaml", "targets"}},
      {"dataset.yaml", "[640, 400]", "[640]", {"dataset.yaml", "image_size"}},
      {"dataset.yaml", "[640, 400]", "[.nan, 400]", {"dataset.yaml", "image_size", "nan"}},
      {"dataset.yaml", "observations_exact.csv", "nothing.csv", {"nothing.csv"}},
      {"target.yaml", "tagRows: 3", "tagRows: none", {"target.yaml", "tagRows", "none"}},
      {"target.yaml",
       "tagRows: 3",
       "tagRows: 3\nflatness: bronze",
       {"target.yaml: flatness: must be paper, aluminium, glass or a share", "bronze"}},
      {"target.yaml",
       "tagRows: 3",
       "tagRows: 3\nprint: -0.001",
       {"target.yaml: print: must be paper, aluminium, glass or a share", "-0.001"}},
      {"target.yaml", "tagCols: 4", "tagCols: 2", {"observations_exact.csv"}},
      {"observations_exact.csv", "image,tag_id", "image,tag", {"observations_exact.csv"}},
      {"observations_exact.csv",
       "000.png,0,0,",
       "000.png,0,0,nan",
       {"observations_exact.csv", "nan"}},
      {"observations_exact.csv", "000.png,0,0,", "000.png,0,0,7,", {"observations_exact.csv"}},
      {"observations_exact.csv",
       "000.png,0,1,",
       "000.png,0,0,",
       {"observations_exact.csv", "000.png"}},
      {"observations_exact.csv", "000.png,0,0,", "000.png,99,0,", {"observations_exact.csv", "99"}},
      {"observations_exact.csv", "000.png,0,0,", "000.png,0,4,", {"observations_exact.csv", "4"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(std::string(c.file) + ": " + c.to);
    const fs::path folder = exact_set("broken");
    spill(folder / c.file, replaced(slurp(folder / c.file), c.from, c.to));
    const std::string out = path("never.yaml");
    expect_bad_input("calibrate " + folder.string() + " --json --out " + out, c.parts);
    EXPECT_FALSE(fs::exists(out));
  }
  expect_bad_input("calibrate " + path("nowhere"), {"nowhere"});
}

TEST_F(Cli, TwelveCornersAreNeeded) {
  const fs::path folder = exact_set("few");
  std::istringstream lines(slurp(folder / "observations_exact.csv"));
  std::string few;
  std::string line;
  for (int i = 0; i < 12 && std::getline(lines, line); ++i) few += line + "\n";
  spill(root() / "few.csv", few);
  expect_bad_input("calibrate " + folder.string() + " --observations " + path("few.csv"),
                   {"few.csv", "12", "11"});
  spill(folder / "observations_exact.csv", few);
  expect_bad_input("calibrate " + folder.string(), {"observations_exact.csv", "12", "11"});
}

TEST_F(Cli, TwoBoardsMustNotShareIds) {
  const fs::path folder = exact_set("shared_ids");
  spill(folder / "dataset.yaml", replaced(slurp(folder / "dataset.yaml"), "target: target.yaml",
                                          "target: [{file: target.yaml}, {file: target.yaml}]"));
  expect_bad_input("calibrate " + folder.string(), {"dataset.yaml", "id"});
}

}  // namespace
}  // namespace tagcal::tools
