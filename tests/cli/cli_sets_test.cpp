// Sets of pictures as they come: folders, patterns, lists, bad pictures, the corner cache,
// --select.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

using std::string_literals::operator""s;

class CliSets : public Cli {
 protected:
  static std::string detect(const std::string& inputs) {
    return "detect --target " + path("set/target.yaml") + " " + inputs;
  }
  static bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }
  // A copy of the rendered pictures.
  static fs::path photos(const std::string& name) {
    const fs::path folder = root() / name;
    fs::remove_all(folder);
    fs::copy(root() / "set/images", folder, fs::copy_options::recursive);
    return folder;
  }
};

TEST_F(CliSets, FoldersPatternsAndListsNameTheSamePictures) {
  const fs::path folder = photos("photos");
  spill(folder / "notes.txt", "no picture");
  const Outcome by_folder = good_run(detect(path("photos")));
  EXPECT_TRUE(has(by_folder.err, "6 of 6 pictures")) << by_folder.err;
  EXPECT_EQ(run(detect("'" + path("photos/*.png") + "'")).out, by_folder.out);
  spill(root() / "list.txt", "\xEF\xBB\xBF# a comment\n\nphotos/00[0-2].png\r\n" +
                                 path("photos/003.png") + "\n photos/004.png \nphotos/005.png");
  EXPECT_EQ(run(detect("@" + path("list.txt"))).out, by_folder.out);
  EXPECT_EQ(run("detect " + path("set")).out, by_folder.out);
}

TEST_F(CliSets, DrawingsReplaceNoPictures) {
  const fs::path folder = photos("drawn_over");
  const std::string before = slurp(folder / "000.png");
  expect_bad_input(detect(path("drawn_over")) + " --draw " + path("drawn_over"),
                   {"000.png", "would be replaced"});
  EXPECT_EQ(slurp(folder / "000.png"), before);
}

TEST_F(CliSets, EveryFormatIsTaken) {
  fs::create_directories(root() / "formats");
  const Image8 image = read_image(root() / "set/images/000.png");
  for (const char* name : {"a.png", "b.tif", "c.pgm"})
    write_picture(root() / "formats" / name, image);
  const Outcome found = good_run(detect(path("formats")));
  const auto lines_with = [&](const std::string& name) {
    std::string lines;
    std::istringstream all(found.out);
    for (std::string line; std::getline(all, line);)
      if (line.starts_with(name)) lines += line.substr(name.size()) + "\n";
    return lines;
  };
  EXPECT_NE(lines_with("a.png"), "");
  EXPECT_EQ(lines_with("a.png"), lines_with("b.tif"));
  EXPECT_EQ(lines_with("a.png"), lines_with("c.pgm"));
}

TEST_F(CliSets, WhatNamesNoPictureIsAnError) {
  expect_bad_input(detect("'" + path("none/*.png") + "'"), {"none/*.png", "matches no file"});
  fs::create_directories(root() / "hollow");
  expect_bad_input(detect(path("hollow")), {"hollow", "has no pictures"});
  spill(root() / "bad_list.txt", "\nset/images/000.png\nmissing.png\n");
  expect_bad_input(detect("@" + path("bad_list.txt")), {"bad_list.txt: line 3", "missing.png"});
  spill(root() / "empty_list.txt", "# nothing\n");
  expect_bad_input(detect("@" + path("empty_list.txt")), {"empty_list.txt", "names no pictures"});
  expect_bad_input(detect("@" + path("no_list.txt")), {"no_list.txt", "no such file"});
  expect_bad_input("detect " + path("set/images"), {"images", "--target"});
  expect_bad_input(detect(path("set/images") + " --exclude '*'"), {"--exclude"});
}

TEST_F(CliSets, BadPicturesAreNamedAndLeftOut) {
  const fs::path folder = photos("some_bad");
  const Outcome good = run(detect(path("some_bad")));
  spill(folder / "text.png", "not a picture");
  const std::string png = slurp(folder / "000.png");
  spill(folder / "cut.png", png.substr(0, png.size() / 2));  // its header is whole
  const Outcome some = good_run(detect(path("some_bad") + " --draw " + path("some_drawn")));
  EXPECT_EQ(some.out, good.out);
  EXPECT_TRUE(has(some.err, "warning: " + (folder / "text.png").string())) << some.err;
  EXPECT_TRUE(has(some.err, "warning: " + (folder / "cut.png").string())) << some.err;
  EXPECT_TRUE(has(some.err, "6 of 6 pictures")) << some.err;
  EXPECT_EQ(bytes_of(root() / "some_drawn").size(), 6u);
  expect_bad_input(detect(path("some_bad") + " --strict"), {"text.png"});
  expect_bad_input(detect(path("some_bad") + " --strict --exclude text.png"), {"cut.png"});
  EXPECT_EQ(run(detect(path("some_bad") + " --strict --exclude 't*' --exclude cut.png")).out,
            good.out);
  const Outcome typo = run(detect(path("some_bad") + " --exclude textt.png"));
  EXPECT_TRUE(has(typo.err, "--exclude: textt.png is the name of no picture")) << typo.err;
  expect_bad_input(detect(path("some_bad/text.png")), {"text.png", "is not a PNG"});
}

TEST_F(CliSets, DataSetsLeaveOutBadPicturesToo) {
  fs::copy(root() / "set", root() / "bad_set", fs::copy_options::recursive);
  spill(root() / "bad_set/images/003.png", "");
  const Outcome outcome = good_run("detect " + path("bad_set"));
  EXPECT_TRUE(has(outcome.err, "003.png: is empty")) << outcome.err;
  EXPECT_EQ(outcome.out, run("detect " + path("set") + " --exclude 003.png").out);
  expect_bad_input("detect " + path("bad_set") + " --strict", {"003.png", "is empty"});
}

TEST_F(CliSets, ADataSetOfARigTakesTheOptionsOfItsPictures) {
  good_run("render " TAGCAL_SOURCE_DIR "/data-synthetic/scenes/stereo.yaml --views 6 --out " +
           path("rig"));
  const std::string set = "rig " + path("rig");
  expect_bad_input(set + " --frames every:2", {"--frames: belongs to videos and bags", "rig"});
  expect_bad_input(set + " --refinement edges",
                   {"--refinement: belongs to corners found in pictures", "observations_exact"});
  expect_bad_input(set + " --exclude '*'", {"--exclude: leaves no picture of left"});
  const auto instants = [](const Outcome& out) {
    return nlohmann::json::parse(out.out).at("num_instants").get<int>();
  };
  const Outcome four = good_run(set + " --json --exclude 001.png --exclude 004.png");
  EXPECT_EQ(instants(four), 4);
  EXPECT_HAS(four.err,
             "right: the corners are those of " + path("rig/right/observations_exact.csv"));
  EXPECT_HAS(run(set + " --exclude x.png").err, "x.png is the name of no picture");
  spill(root() / "rig/dataset.yaml",
        "target: target.yaml\nrig:\n  cameras:\n    - {name: left, images: left/images}\n"
        "    - {name: right, images: right/images}\n");
  spill(root() / "rig/left/images/001.png", "");
  const Outcome some = good_run(set + " --json");
  EXPECT_HAS(some.err, "left/images/001.png: is empty; the picture is left out");
  EXPECT_EQ(nlohmann::json::parse(some.out)["cameras"][0]["num_views"], 5);
  expect_bad_input(set + " --strict", {"left/images/001.png: is empty"});
  const Outcome less = good_run(set + " --json --exclude '001*' --refinement stock");
  EXPECT_LACKS(less.err, "left out");
  EXPECT_NE(less.out, some.out);
  // A pattern may be that of one camera only: it is unused if it is so in all.
  const Outcome folders =
      good_run("rig " + path("rig/left/images") + " " + path("rig/right/images") + " --target " +
               path("rig/target.yaml") + " --exclude '*/left/images/00[14].png' --exclude x.png");
  EXPECT_HAS(folders.err, "warning: --exclude: x.png is the name of no picture");
  EXPECT_EQ(folders.err.find("--exclude"), folders.err.rfind("--exclude")) << folders.err;
}

TEST_F(CliSets, PicturesOfAnotherSizeAreNamedByTheMajority) {
  const fs::path folder = photos("mixed");
  write_png(folder / "000.png", Image8({400, 640}));
  write_png(folder / "zzz.png", Image8({64, 48}));
  expect_bad_input(detect(path("mixed")),
                   {"000.png is 400x640 (turned by 90 degrees), ", "zzz.png is 64x48",
                    "5 of 7 pictures are 640x400", "--exclude"});
  EXPECT_EQ(run(detect(path("mixed") + " --exclude 000.png --exclude zzz.png")).exit_code, 0);
}

// A JPEG whose Exif tag says how it is turned.
void write_turned(const fs::path& file, const Picture& picture, char orientation) {
  write_picture(file, picture);
  const std::string tag =
      "Exif\0\0MM\0*\0\0\0\10\0\1\1\22\0\3\0\0\0\1\0"s + orientation + "\0\0\0\0\0\0"s;
  const std::string bytes = slurp(file);
  const std::string segment = "\xff\xe1\0"s + static_cast<char>(tag.size() + 2) + tag;
  spill(file, bytes.substr(0, 2) + segment + bytes.substr(2));
}

TEST_F(CliSets, PicturesThatTheCameraTurnedByOtherAngles) {
  const fs::path folder = photos("turns");
  const Picture picture = read_picture(folder / "001.png");
  write_turned(folder / "same.jpg", picture, 1);
  EXPECT_FALSE(has(run(detect(path("turns"))).err, "Exif")) << "all of them upright";
  write_turned(folder / "upside_down.jpg", picture, 3);
  const Outcome outcome = good_run(detect(path("turns")));
  EXPECT_TRUE(has(outcome.err, "upside_down.jpg: its Exif orientation is 3, as that of 1 of 8"))
      << outcome.err;
  write_turned(folder / "upside_down.jpg", picture, 6);
  expect_bad_input(detect(path("turns")),
                   {"upside_down.jpg is 400x640 (turned by 90 degrees), ", "Exif orientation"});
}

TEST_F(CliSets, TheCornerCacheChangesNoAnswer) {
  photos("cached");
  const std::string command = detect(path("cached")) + " --out " + path("c.csv");
  const fs::path cache = path("c.csv.corners-cache");
  const Outcome without = run(command + " --no-cache");
  const std::string answer = slurp(path("c.csv"));
  EXPECT_TRUE(has(without.err, "wrote " + path("c.csv") + "\n")) << without.err;
  EXPECT_FALSE(fs::exists(cache));
  run(command);
  EXPECT_EQ(slurp(path("c.csv")), answer);
  ASSERT_TRUE(fs::exists(cache));
  const auto expect_reused = [&](const std::string& arguments, const std::string& said) {
    const Outcome again = good_run(command + arguments);
    EXPECT_EQ(slurp(path("c.csv")), answer);
    EXPECT_EQ(has(again.err, "corners of "), !said.empty()) << again.err;
    EXPECT_TRUE(has(again.err, said)) << again.err;
  };
  expect_reused("", "corners of 6 of 6 pictures");
  expect_reused(" --threads 1", "corners of 6 of 6 pictures");
  // Damage, another target and other options: all is detected again.
  const std::string whole = slurp(cache);
  spill(cache, replaced(whole, "0.", "1."));
  EXPECT_TRUE(has(run(command).err, "is damaged, the corners are detected again"));
  EXPECT_EQ(slurp(cache), whole);
  spill(cache, whole.substr(0, whole.size() / 2));
  expect_reused("", "");
  run(command + " --refinement edges");
  expect_reused("", "");
  // A changed picture alone is detected again.
  fs::copy_file(root() / "cached/001.png", root() / "cached/000.png",
                fs::copy_options::overwrite_existing);
  const Outcome changed = run(command);
  EXPECT_TRUE(has(changed.err, "corners of 5 of 6 pictures")) << changed.err;
  const std::string with_change = slurp(path("c.csv"));
  EXPECT_NE(with_change, answer);
  run(command + " --no-cache");
  EXPECT_EQ(slurp(path("c.csv")), with_change);
}

TEST_F(CliSets, CalibrationsAreTheSameWithTheCache) {
  const std::string command =
      "calibrate " + path("set") + " --model radial1 --out " + path("k.yaml");
  ASSERT_EQ(run(command + " --no-cache").exit_code, 0);
  const std::string answer = slurp(path("k.yaml"));
  ASSERT_EQ(run(command).exit_code, 0);
  const Outcome again = run(command);
  EXPECT_TRUE(has(again.err, "corners of 6 of 6 pictures")) << again.err;
  EXPECT_TRUE(has(again.err, "wrote " + path("k.yaml") + "\n")) << again.err;
  EXPECT_EQ(slurp(path("k.yaml")), answer);
}

// Four views: fewer do not tell displaced rows of the pictures from perspective, and these are
// refused.
TEST_F(CliSets, SelectKeepsTheMostInformativeViewsAndSaysWhy) {
  const std::string set = exact_set("to_select").string();
  const std::string command = "calibrate " + set + " --model radial1 --sigma-px 0.1 --select 4";
  const Outcome text = run(command);
  ASSERT_EQ(text.exit_code, 0) << text.out << text.err;
  EXPECT_TRUE(has(text.out, "selected   4 views")) << text.out;
  const auto json = nlohmann::json::parse(run(command + " --json").out);
  EXPECT_EQ(json.at("num_views"), 4);
  const auto& selection = json.at("selection");
  ASSERT_EQ(selection.at("views").size(), 4u);
  double before = 1e9;
  for (const auto& view : selection.at("views")) {
    const double now = view.at("projection_px");
    EXPECT_LT(now, before);
    before = now;
  }
  EXPECT_LT(selection.at("all_views_projection_px"), before);
  EXPECT_EQ(nlohmann::json::parse(run(command + " --json").out).at("selection"), selection);
  // The four without the two most informative ones leave more uncertainty.
  std::string others = "calibrate " + set + " --model radial1 --sigma-px 0.1 --json";
  for (const std::size_t i : {0u, 1u})
    others += " --exclude " + selection.at("views")[i].at("image").get<std::string>();
  const auto worse = nlohmann::json::parse(run(others).out);
  EXPECT_EQ(worse.at("num_views"), 4);
  EXPECT_GT(worse.at("sigma").at("fx"), json.at("sigma").at("fx"));
  expect_bad_input("calibrate " + set + " --select 0", {"--select"});
  EXPECT_EQ(
      nlohmann::json::parse(run("calibrate " + set + " --model radial1 --json --select 99").out)
          .at("num_views"),
      6);
}

}  // namespace
}  // namespace tagcal::tools
