#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

// Several data sets in one call.

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

Json without_times(Json json) {
  json.erase("seconds");
  json.erase("data_set");
  return json;
}

class CliMany : public Cli {
 protected:
  // The calibrations of a folder, without their summaries.
  static std::map<std::string, std::string> calibrations_of(const fs::path& folder) {
    auto files = bytes_of(folder);
    std::erase_if(files, [](const auto& file) { return !file.first.ends_with(".yaml"); });
    return files;
  }

  // Writes three different data sets and returns their names as arguments.
  static std::string three() {
    exact_set("a");
    const fs::path b = exact_set("b");
    const fs::path c = exact_set("c");
    // b has no last view, c no first one.
    const std::string all = slurp(b / "observations_exact.csv");
    spill(b / "observations_exact.csv", all.substr(0, all.find("005.png")));
    const std::size_t first = all.find("000.png");
    spill(c / "observations_exact.csv",
          all.substr(0, first) + all.substr(all.find("001.png", first)));
    return path("a") + " " + path("b") + " " + path("c");
  }
};

TEST_F(CliMany, GivesEachWhatItsOwnCallGives) {
  const std::string sets = three();
  const std::string model = " --model radial1 --sigma-px 0.1";
  const Outcome table = run("calibrate " + sets + model + " --out " + path("many"));
  ASSERT_EQ(table.exit_code, 0) << table.out << table.err;
  EXPECT_EQ(without_progress(table.err), "wrote " + path("many") + ": 3 calibrations\n");
  const auto lines = lines_of(table.out);
  ASSERT_EQ(lines.size(), 4u) << table.out;
  EXPECT_TRUE(lines[0].starts_with("data set  status  model")) << lines[0];
  const auto files = calibrations_of(path("many"));
  ASSERT_EQ(files.size(), 3u);
  const Json array = Json::parse(run("calibrate " + sets + model + " --json").out);
  ASSERT_EQ(array.size(), 3u);
  const std::vector<std::string> names = {"a", "b", "c"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Outcome one =
        run("calibrate " + path(names[i]) + model + " --json --out " + path(names[i] + ".yaml"));
    EXPECT_EQ(files.at(names[i] + ".yaml"), slurp(path(names[i] + ".yaml")));
    EXPECT_EQ(array[i]["data_set"], names[i]);
    EXPECT_EQ(without_times(array[i]), without_times(Json::parse(one.out)));
    std::istringstream words(lines[i + 1]);
    std::string name, status, chosen, fx, sd, rms, views, rejected;
    words >> name >> status >> chosen >> fx >> sd >> rms >> views >> rejected;
    EXPECT_EQ(name + status + chosen, names[i] + "okradial1");
    EXPECT_NEAR(std::stod(fx), array[i]["camera"]["fx"].get<double>(), 1e-3);
    EXPECT_NEAR(std::stod(sd), array[i]["sigma"]["fx"].get<double>(), 1e-3);
    EXPECT_EQ(views, std::to_string(array[i]["num_views"].get<int>()));
    EXPECT_EQ(rejected, "0");
  }
  EXPECT_NE(files.at("a.yaml"), files.at("b.yaml"));
  EXPECT_NE(files.at("b.yaml"), files.at("c.yaml"));
}

TEST_F(CliMany, ThreadsDoNotChangeTheAnswers) {
  const std::string sets = "calibrate " + three() + " --model f+c --out ";
  ASSERT_EQ(run(sets + path("by1") + " --threads 1").exit_code, 0);
  ASSERT_EQ(run(sets + path("by3/deeper") + " --threads 3").exit_code, 0);
  EXPECT_EQ(bytes_of(path("by1")), bytes_of(path("by3/deeper")));
}

TEST_F(CliMany, OneBadDataSetHarmsNoOther) {
  three();
  spill(path("bad/dataset.yaml"), "image_sizes: [640, 400]\n");
  const std::string sets =
      "calibrate " + path("nowhere") + " " + path("a") + " " + path("bad") + " " + path("c");
  const Outcome table = run(sets + " --model radial1 --out " + path("some"));
  EXPECT_EQ(table.exit_code, 2);
  EXPECT_EQ(without_progress(table.err),
            "wrote " + path("some") + ": 2 calibrations\ntagcal: 2 of 4 data sets: error\n");
  const auto lines = lines_of(table.out);
  ASSERT_EQ(lines.size(), 5u) << table.out;
  EXPECT_TRUE(lines[1].starts_with("nowhere") && lines[1].find("error: ") != std::string::npos);
  EXPECT_TRUE(lines[2].starts_with("a ") && lines[2].find(" ok ") != std::string::npos);
  EXPECT_HAS(lines[3], "bad/dataset.yaml: image_sizes: ");
  EXPECT_TRUE(lines[4].starts_with("c ") && lines[4].find(" ok ") != std::string::npos);
  EXPECT_EQ(calibrations_of(path("some")).size(), 2u);
  const Json summary = Json::parse(slurp(path("some/summary/bad.json")));
  EXPECT_EQ(summary["unit"]["status"], "error");
  EXPECT_HAS(summary["unit"]["reason"].get<std::string>(), "image_sizes");
  const Outcome json = run(sets + " --model radial1 --json");
  EXPECT_EQ(json.exit_code, 2);
  const Json array = Json::parse(json.out);
  ASSERT_EQ(array.size(), 4u);
  EXPECT_EQ(array[2]["data_set"], "bad");
  EXPECT_HAS(array[2]["error"].get<std::string>(), "image_sizes");
  EXPECT_EQ(array[3]["status"], "ok");
}

TEST_F(CliMany, TheExitCodeIsTheWorst) {
  three();
  // Three tags of one view are too few for opencv8. (The whole view is an answer: the priors of
  // lenses determine what it does not.)
  const fs::path open = exact_set("open");
  const std::string all = slurp(open / "observations_exact.csv");
  spill(open / "observations_exact.csv", all.substr(0, all.find("000.png,3,")));
  const std::string sets = "calibrate " + path("a") + " " + path("open");
  const Outcome none = run(sets + " --model opencv8 --sigma-px 0.1 --out " + path("worst"));
  EXPECT_EQ(none.exit_code, 3) << none.out << none.err;
  EXPECT_HAS(none.err, "of 2 data sets: no answer, no file");
  EXPECT_FALSE(fs::exists(path("worst/open.yaml")));
  EXPECT_EQ(run(sets + " " + path("nowhere")).exit_code, 2);
  const Json array = Json::parse(run(sets + " --model opencv8 --sigma-px 0.1 --json").out);
  EXPECT_TRUE(array[1]["camera"]["fx"].is_null());
}

TEST_F(CliMany, WhatCannotWorkIsSaidBeforeAnyWork) {
  three();
  fs::create_directories(path("other"));
  fs::copy(path("b"), path("other/b"), fs::copy_options::recursive);
  const auto before = names();
  const std::string two = "calibrate " + path("a") + " " + path("b");
  expect_bad_input(two + " " + path("other/b/") + " --out " + path("twins"),
                   {"other/b", "names must differ", "called b too"});
  expect_bad_input(two + " --out " + path("scene.yaml"), {"scene.yaml", "must be a folder"});
  expect_bad_input(two + " --uncertainty " + path("u.svg"), {"--uncertainty", "one camera"});
  expect_bad_input(two + " --observations x.csv", {"--observations", "one data set"});
  expect_bad_input(two + " --model opencv6", {"opencv6"});
  EXPECT_EQ(names(), before);
  expect_bad_input(two + " --chunk 1/2 --out " + path("parts"), {"--chunk", "--resume"});
  for (const char* wrong : {"0/2", "3/2", "1", "1/2x", "/2", "1/0"})
    expect_bad_input(two + " --resume --out " + path("parts") + " --chunk " + wrong,
                     {"--chunk: must be K/N", wrong});
  EXPECT_EQ(names(), before);
}

// What was kept counts for the same data only.
TEST_F(CliMany, ResumeCalibratesWhatHasChanged) {
  three();
  const std::string sets = "calibrate " + path("a") + " " + path("c") + " " + path("later") +
                           " --model f --resume --out " + path("kept");
  EXPECT_EQ(run(sets).exit_code, 2);  // the third is not there yet, and so the others are kept
  const std::string c = slurp(root() / "kept/c.yaml");
  EXPECT_HAS(slurp(root() / "kept/a.yaml"), "num_views: 6");
  fs::last_write_time(path("kept/c.yaml"), fs::file_time_type());
  exact_set("later");
  const std::string all = slurp(root() / "a/observations_exact.csv");
  spill(root() / "a/observations_exact.csv", all.substr(0, all.find("005.png")));
  ASSERT_EQ(run(sets).exit_code, 0);
  EXPECT_HAS(slurp(root() / "kept/a.yaml"), "num_views: 5");
  EXPECT_EQ(slurp(root() / "kept/c.yaml"), c);
  EXPECT_EQ(fs::last_write_time(path("kept/c.yaml")), fs::file_time_type());
}

// Chunks and threads, in whatever order, leave the bytes of one call; the time is not kept.
TEST_F(CliMany, ChunksLeaveTheSameBytes) {
  three();
  const std::string sets = path("c") + " " + path("a") + " " + path("b");
  const std::string options = " --model f+c --resume --out ";
  ASSERT_EQ(run("calibrate " + sets + options + path("whole")).exit_code, 0);
  for (const char* chunk : {"2/2", "1/2"}) {
    const Outcome part =
        good_run("calibrate " + sets + " --chunk " + chunk + options + path("parts"));
    EXPECT_HAS(part.err, "of 3 data sets");
  }
  EXPECT_EQ(run("calibrate " + sets + " --chunk 4/5" + options + path("parts")).exit_code, 0);
  EXPECT_EQ(bytes_of(path("parts")), bytes_of(path("whole")));
  const auto lines =
      lines_of(run("calibrate " + sets + " --chunk 1/2" + options + path("parts")).out);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_TRUE(lines[1].starts_with("a ") && lines[1].ends_with("-")) << lines[1];
  EXPECT_TRUE(lines[2].starts_with("c ")) << lines[2];
}

// An error says so in the summary, but replaces no answer.
TEST_F(CliMany, AnErrorReplacesNoEarlierAnswer) {
  three();
  const std::string sets =
      "calibrate " + path("a") + " " + path("b") + " --model f --out " + path("lasting");
  ASSERT_EQ(run(sets).exit_code, 0);
  const auto before = bytes_of(path("lasting"));
  spill(path("b/dataset.yaml"), "image_size: 3\n");
  EXPECT_EQ(run(sets).exit_code, 2);
  EXPECT_EQ(bytes_of(path("lasting")), before);
}

// Folders of pictures are cameras, one each, unless the user says that they are of one.
class CliFolders : public Cli {
 protected:
  // Three of the pictures in each of two folders.
  static std::string two() {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(root() / "set/images")) {
      const fs::path to = root() / (count++ % 2 == 0 ? "left" : "right");
      fs::create_directories(to);
      fs::copy_file(entry.path(), to / entry.path().filename(), fs::copy_options::skip_existing);
    }
    return "--target " + path("set/target.yaml") + " " + path("left") + " " + path("right");
  }
};

TEST_F(CliFolders, AreSeveralCameras) {
  const std::string folders = two();
  const Outcome several = run("calibrate " + folders + " --model f --out " + path("cameras"));
  EXPECT_NE(several.exit_code, 2) << several.err;
  const auto lines = lines_of(several.out);
  ASSERT_GE(lines.size(), 3u) << several.out;
  EXPECT_TRUE(lines[1].starts_with("left ") && lines[2].starts_with("right ")) << several.out;
  const Outcome one =
      good_run("calibrate " + folders + " --model f --one-camera --json --out " + path("one.yaml"));
  const Json answer = Json::parse(one.out);
  EXPECT_EQ(answer["views"].size(), 6u);
  EXPECT_FALSE(answer["halves"].is_null());
  EXPECT_TRUE(answer["halves"]["source"].get<std::string>().ends_with("t"));  // left or right
  // Single pictures are one camera, whose folders are compared too.
  const Outcome files =
      good_run("calibrate --target " + path("set/target.yaml") + " '" + path("left") + "/*.png' '" +
               path("right") + "/*.png' --model f --json");
  EXPECT_EQ(Json::parse(files.out)["halves"], answer["halves"]);
  EXPECT_TRUE(
      Json::parse(run("calibrate " + path("set") + " --json").out)["halves"]["source"].is_null());
}

TEST_F(CliFolders, MessagesSayWhatToType) {
  const std::string folders = "calibrate " + two();
  expect_bad_input(folders + " --out " + path("w.yaml"),
                   {"must be a folder", "--out " + path("w") + " ", "--one-camera"});
  expect_bad_input(folders + " " + path("scene.yaml"),
                   {"scene.yaml: is no folder", "--one-camera"});
  const std::string left = "calibrate --target " + path("set/target.yaml") + " " + path("left");
  expect_bad_input(left + " --out " + path("set"),
                   {"is a folder", "--out " + path("set/left.yaml")});
  expect_bad_input(left + " --out " + path("new/"), {"--out " + path("new/left.yaml")});
  expect_bad_input("calibrate " + path("set") + " --one-camera", {"--one-camera", "--target"});
}

TEST_F(CliMany, AdvisesEach) {
  const std::string sets = "calibrate " + three() + " --model f+c --advise";
  const auto lines = lines_of(run(sets).out);
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_TRUE(lines[4].starts_with("a: next view: ")) << lines[4];
  EXPECT_FALSE(Json::parse(run(sets + " --json").out)[2]["advice"]["sentence"].empty());
}

}  // namespace
}  // namespace tagcal::tools
