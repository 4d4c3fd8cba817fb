#include <fcntl.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "cli_fixture.hpp"
#include "job/progress.hpp"
#include "watch/folder_follower.hpp"

// `tagcal watch`: a folder that changes while the command runs, and the parts that need no clock.

namespace tagcal::tools {
namespace {

using Names = std::vector<std::string>;

FileStamp stamp(std::uintmax_t size, int time = 0) {
  return {size, fs::file_time_type(fs::file_time_type::duration(time))};
}

TEST(FolderFollower, AFileIsReadyOnceItRests) {
  FolderFollower follower;
  EXPECT_EQ(follower.look({{"a", stamp(5)}}).ready, Names());
  EXPECT_EQ(follower.look({{"a", stamp(9)}}).ready, Names());  // it grows
  EXPECT_EQ(follower.look({{"a", stamp(9)}}).ready, Names{"a"});
  EXPECT_EQ(follower.look({{"a", stamp(9)}}).ready, Names());     // once
  EXPECT_EQ(follower.look({{"a", stamp(9, 1)}}).ready, Names());  // written again
  EXPECT_EQ(follower.look({{"a", stamp(9, 1)}}).ready, Names{"a"});
}

// So that no timeout ends before it is read, however slow the looks are.
TEST(FolderFollower, AwaitsNewFilesUntilTheyRest) {
  FolderFollower follower;
  const FolderListing one{{"a.png", FileStamp{10, {}}}};
  EXPECT_FALSE(follower.awaits());
  follower.look(one);
  EXPECT_TRUE(follower.awaits());
  EXPECT_EQ(follower.look(one).ready.size(), 1u);
  EXPECT_FALSE(follower.awaits());
  follower.set_aside("a.png");
  follower.recall_set_aside();
  EXPECT_FALSE(follower.awaits());
}

TEST(FolderFollower, TheOldestComesFirst) {
  FolderFollower follower;
  const FolderListing listing = {{"a", stamp(1, 9)}, {"b", stamp(1, 3)}, {"c", stamp(1, 9)}};
  follower.look(listing);
  EXPECT_EQ(follower.look(listing).ready, (Names{"b", "a", "c"}));
}

TEST(FolderFollower, AFileIsRemovedIfTwoLooksMissIt) {
  FolderFollower follower;
  const FolderListing both = {{"a", stamp(1)}, {"b", stamp(1)}};
  follower.look(both);
  follower.look(both);
  EXPECT_EQ(follower.look({{"b", stamp(1)}}).removed, Names());
  EXPECT_EQ(follower.look(both).removed, Names());  // it was only replaced
  EXPECT_EQ(follower.look({{"b", stamp(1)}}).removed, Names());
  EXPECT_EQ(follower.look({{"b", stamp(1)}}).removed, Names{"a"});
  EXPECT_EQ(follower.look({{"b", stamp(1)}}).removed, Names());
}

TEST(FolderFollower, AFileThatNeverRestedIsNotRemoved) {
  FolderFollower follower;
  follower.look({{"a.part.png", stamp(1)}});
  follower.look({});
  EXPECT_EQ(follower.look({}).removed, Names());
}

TEST(FolderFollower, AnUnreadableFileIsTriedAgainForAWhileAndOnceItChanges) {
  FolderFollower follower;
  const FolderListing listing = {{"a", stamp(5)}};
  follower.look(listing);
  int tries = 0, told = 0;
  for (int look = 0; look < 3 * FolderFollower::kPatientLooks; ++look) {
    if (follower.look(listing).ready.empty()) continue;
    ++tries;
    told += follower.postpone("a") ? 1 : 0;
  }
  EXPECT_EQ(tries, FolderFollower::kPatientLooks);
  EXPECT_EQ(told, 1);
  follower.look({{"a", stamp(6)}});
  EXPECT_EQ(follower.look({{"a", stamp(6)}}).ready, Names{"a"});
}

TEST(FolderFollower, FilesSetAsideComeBack) {
  FolderFollower follower;
  const FolderListing listing = {{"a", stamp(1)}, {"b", stamp(1)}};
  follower.look(listing);
  follower.look(listing);
  follower.set_aside("b");
  EXPECT_EQ(follower.look(listing).ready, Names());
  follower.recall_set_aside();
  EXPECT_EQ(follower.look(listing).ready, Names{"b"});
}

TEST(Progress, SaysTheRateAndTheTimeLeft) {
  EXPECT_EQ(progress_text("detecting", 12, 200, 3.75), "detecting: 12 of 200, 3.2/s, 59 s left");
  EXPECT_EQ(progress_text("detecting", 0, 200, 2), "detecting: 0 of 200");
  EXPECT_EQ(progress_text("detecting", 200, 200, 10), "detecting: 200 of 200, 20/s");
  EXPECT_EQ(progress_text("rendering", 1, 1000, 4.5),
            "rendering: 1 of 1000, 0.22/s, 1 h 14 min left");
  EXPECT_EQ(progress_text("calibrating", 0, 0, 65.5), "calibrating: 1 min 5 s");
}

// A run of `tagcal watch` that goes on while the test changes the folder.
class Watch : public Cli {
 protected:
  static void SetUpTestSuite() {
    Cli::SetUpTestSuite();
    std::string all_over = replaced(kScene, "target_m: 0.02", "target_m: 0.07");
    all_over = replaced(all_over, "views: 6", "views: 10");
    all_over = replaced(all_over, "min_distance_m: 0.45, max_distance_m: 0.6",
                        "min_distance_m: 0.3, max_distance_m: 0.4");
    spill(root() / "all_over.yaml", all_over);
    ASSERT_EQ(run("render " + path("all_over.yaml") + " --out " + path("all_over")).exit_code, 0);
    spill(root() / "odd.yaml",
          replaced(replaced(kScene, "[640, 400]", "[600, 380]"), "views: 6", "views: 1"));
    ASSERT_EQ(run("render " + path("odd.yaml") + " --out " + path("odd")).exit_code, 0);
  }

  void SetUp() override {
    fs::remove_all(root() / "photos");
    fs::remove(root() / "camera.yaml");
    fs::create_directories(root() / "photos");
  }
  void TearDown() override {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }

  static fs::path picture(int i) {
    return root() / "set/images" / ("00" + std::to_string(i) + ".png");
  }
  static fs::path photo(const std::string& name) { return root() / "photos" / name; }

  void start(const std::string& options) {
    launch(path("photos") + " --target " + path("set/target.yaml") + " --out " +
           path("camera.yaml") + " " + options);
  }

  void launch(const std::string& arguments) {
    std::string line = "exec " + program() + " watch --every 0.03 --no-cache " + arguments;
    line += " >" + path("watch.txt") + " 2>" + path("watch_err.txt") + " </dev/null";
    spill(root() / "watch.txt", "");
    pid_ = fork();
    if (pid_ == 0) {
      execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      _exit(127);
    }
  }

  // The start of a picture's line.
  static std::string line(const std::string& name, const std::string& text) {
    return "\n" + name + std::string(16 - name.size(), ' ') + text;
  }

  // Waits for a text in the output; fails after two minutes, of which valgrind needs some.
  static void wait_for(const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (slurp(root() / "watch.txt").find(text) == std::string::npos) {
      ASSERT_TRUE(std::chrono::steady_clock::now() < end)
          << "missing: " << text << "\n"
          << slurp(root() / "watch.txt") << slurp(root() / "watch_err.txt");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  Outcome finished() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(root() / "watch.txt"),
            slurp(root() / "watch_err.txt")};
  }
  Outcome interrupted() {
    kill(pid_, SIGINT);
    return finished();
  }

 private:
  pid_t pid_ = -1;
};

// How many lines begin with a name.
int lines_of(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line);) count += line.starts_with(name) ? 1 : 0;
  return count;
}

TEST_F(Watch, FollowsAFolderUntilItIsGone) {
  fs::copy(picture(0), photo("000.png"));
  fs::copy(picture(1), photo("001.png"));
  start("--until 1e-9px --model radial1");
  wait_for("2 pictures");
  const std::string bytes = slurp(picture(2));
  spill(photo("half.png"), bytes.substr(0, bytes.size() / 2));
  wait_for(line("half.png", "not readable: PNG: is truncated"));
  spill(photo("half.png"), bytes);
  wait_for(line("half.png", " "));
  fs::rename(photo("000.png"), photo("first.png"));
  wait_for(line("first.png", "was 000.png"));
  fs::copy(photo("001.png"), photo("copy.png"));
  wait_for(line("copy.png", "same picture as 001.png"));
  fs::remove(photo("001.png"));  // copy.png stands for it
  fs::remove(photo("first.png"));
  wait_for(line("first.png", "removed, its "));
  fs::copy(root() / "odd/images/000.png", photo("odd.png"));
  wait_for(line("odd.png", "refused: 600x380 pixels, the others have 640x400"));
  spill(photo("grey.pgm"), "P5 640 400 255\n" + std::string(640 * 400, '\x80'));
  wait_for(line("grey.pgm", "no board: nothing in the picture looks like a tag"));
  fs::create_symlink("/dev/zero", photo("endless.png"));
  wait_for(line("endless.png", "not readable: is not a regular file"));
  const std::string camera = slurp(root() / "camera.yaml");
  fs::remove_all(root() / "photos");
  const Outcome outcome = finished();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_HAS(outcome.out, "the folder is gone");
  EXPECT_HAS(outcome.out, "GOAL NOT MET");
  EXPECT_EQ(lines_of(outcome.out, "001.png"), 0) << outcome.out;  // its bytes are still there
  EXPECT_EQ(slurp(root() / "camera.yaml"), camera);
  std::istringstream lines(outcome.out);
  for (std::string text; std::getline(lines, text);) {
    const bool names_a_path = text.find(root().string()) != std::string::npos;
    EXPECT_TRUE(names_a_path || text.size() <= 100) << text;
  }
}

// The calibration is that of `tagcal calibrate` on the same folder.
TEST_F(Watch, EndsOnceTheGoalIsMet) {
  for (const auto& entry : fs::directory_iterator(root() / "all_over/images"))
    fs::copy(entry.path(), photo(entry.path().filename().string()));
  start("--until 5px");
  const Outcome outcome = finished();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_HAS(outcome.out, "GOAL MET");
  EXPECT_HAS(outcome.err, "wrote " + path("camera.yaml"));
  good_run("calibrate --target " + path("set/target.yaml") + " " + path("photos") +
           " --no-cache --out " + path("same.yaml"));
  EXPECT_EQ(slurp(root() / "camera.yaml"), slurp(root() / "same.yaml"));
}

// A small standard deviation is not enough: the corners of the image were not seen.
TEST_F(Watch, TheGoalNeedsCornersEverywhere) {
  for (int i = 0; i < 6; ++i) fs::copy(picture(i), photo(picture(i).filename().string()));
  start("--until 1000px --timeout 1");
  const Outcome outcome = finished();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_HAS(outcome.out, "next: show the board in the ");
  EXPECT_HAS(outcome.out, "GOAL NOT MET: there are no corners in the ");
  EXPECT_HAS(outcome.out, "no new picture for 1 s");
}

// A picture of another size counts once all others are gone; a file that is written again counts
// with its new picture.
TEST_F(Watch, TakesWhatReplacesOtherPictures) {
  fs::copy(picture(0), photo("000.png"));
  start("");
  wait_for("next: ");
  fs::copy(root() / "odd/images/000.png", photo("odd.png"));
  wait_for(line("odd.png", "refused: "));
  fs::remove(photo("000.png"));
  wait_for("no picture with the board is left");
  wait_for(line("odd.png", " "));
  spill(photo("odd.png"), "P5 640 400 255\n" + std::string(640 * 400, '\x80'));
  wait_for(line("odd.png", "no board: "));
  EXPECT_EQ(interrupted().exit_code, 0);  // the file has the calibration before
}

TEST_F(Watch, AnInterruptionLeavesTheCalibration) {
  start("");
  wait_for("watching ");
  const Outcome empty = interrupted();
  EXPECT_EQ(empty.exit_code, 3);
  EXPECT_HAS(empty.out, "NO ANSWER");
  EXPECT_FALSE(fs::exists(root() / "camera.yaml"));
  for (int i = 0; i < 4; ++i) fs::copy(picture(i), photo(picture(i).filename().string()));
  start("--model f");
  wait_for("4 pictures");
  wait_for("next: ");
  const Outcome outcome = interrupted();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_HAS(slurp(root() / "camera.yaml"), "camera_matrix");
}

const char* const kWatchedRig = R"(
rig:
  cameras:
    - {name: left, camera: {image_size: [480, 360], model: pinhole, f: 400}}
    - name: right
      camera: {image_size: [400, 300], model: pinhole, f: 330}
      rig_from_camera: {translation_m: [0.08, 0.002, 0.001], roll_pitch_yaw_deg: [1, 2, 3]}
boards:
  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: 0.3}
    world_from_board: {translation_m: [-0.2, -0.2, 0]}
path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.9, min_elevation_deg: 50}
jitter: {target_m: 0.05, roll_deg: 180}
views: 8
sensor: {blur_px: 0.6, noise_levels: 2}
)";

// The rig is that of `tagcal rig` on the same folders.
TEST_F(Watch, FollowsTheFoldersOfARig) {
  spill(root() / "duo.yaml", kWatchedRig);
  ASSERT_EQ(run("render " + path("duo.yaml") + " --out " + path("duo")).exit_code, 0);
  for (const char* const folder : {"left", "right"})
    fs::create_directories(root() / "cameras" / folder);
  const auto add = [](const std::string& camera, int i) {
    const std::string name = "00" + std::to_string(i) + ".png";
    fs::copy(root() / "duo" / camera / "images" / name, root() / "cameras" / camera / name);
  };
  const std::string folders =
      path("cameras/left") + " " + path("cameras/right") + " --target " + path("duo/target.yaml");
  for (int i = 0; i < 4; ++i) add("left", i);
  launch(folders + " --rig --until 1e-9px --timeout 2 --out " + path("watched.yaml"));
  wait_for("rig  not yet: right: no picture with the board yet");
  for (int i = 0; i < 4; ++i) add("right", i);
  wait_for("next: show the board to left and right at the same time");
  for (int i = 4; i < 8; ++i) add("left", i);
  for (int i = 4; i < 8; ++i) add("right", i);
  wait_for("2 cameras, 8 instants");
  const Outcome outcome = finished();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_EQ(lines_of(outcome.out, "left/007.png"), 1) << outcome.out;
  EXPECT_HAS(outcome.out, "GOAL NOT MET: the places of left and right");
  EXPECT_HAS(outcome.out, "no new picture for 2 s");
  ASSERT_EQ(run("rig " + folders + " --out " + path("same.yaml")).exit_code, 0);
  EXPECT_EQ(slurp(root() / "watched.yaml"), slurp(root() / "same.yaml"));

  // What is to be acted on is said as of one camera.
  const std::string bytes = slurp(root() / "cameras/left/000.png");
  for (const char* const copy : {"a", "b", "c", "d", "e", "f"})
    spill(root() / "cameras/left/copies" / copy, bytes);
  for (const auto& copy : fs::directory_iterator(root() / "cameras/left/copies"))
    fs::rename(copy, root() / "cameras/left" / (copy.path().filename().string() + ".png"));
  spill(root() / "cameras/left/twice.png", bytes + "other bytes behind the same picture");
  spill(root() / "cameras/left/IMG_1.CR3", "raw");
  launch(folders + " --rig --json --timeout 0.5 --out " + path("watched.yaml"));
  const Outcome json = finished();
  EXPECT_EQ(json.exit_code, 0) << json.err;
  EXPECT_TRUE(json.out.starts_with("{")) << json.out;
  for (const char* const part :
       {"left: 9 pictures", "left: 6 pictures have the same bytes as others",
        "left/IMG_1.CR3  not read: ", "! left: twice.png: not used, it repeats 000.png"})
    EXPECT_HAS(json.err, part);

  fs::remove_all(root() / "cameras/right");
  fs::copy(root() / "cameras/left", root() / "cameras/right");
  launch(folders + " --rig --timeout 0.5 --out " + path("none.yaml"));
  const Outcome same = finished();
  EXPECT_EQ(same.exit_code, 3) << same.out << same.err;
  EXPECT_HAS(same.out, "NO ANSWER: left and right: 000.png and 000.png are the same picture");
  EXPECT_FALSE(fs::exists(root() / "none.yaml"));
}

TEST_F(Watch, RefusesWhatCannotBeWatched) {
  const std::string target = " --target " + path("set/target.yaml");
  const std::string photos = "watch " + path("photos");
  expect_bad_input("watch " + path("nothing") + target, {path("nothing"), "no such folder"});
  expect_bad_input("watch " + path("scene.yaml") + target, {"must be a folder"});
  expect_bad_input("watch " + path("set") + target, {"is a data set"});
  expect_bad_input(photos, {"--target"});
  expect_bad_input(photos + target + " --rig", {"folders (or films) of two cameras"});
  expect_bad_input(photos + " " + path("photos") + target + " --rig", {"given twice"});
  expect_bad_input(photos + " " + path("nothing") + target + " --rig", {"no such folder"});
  expect_bad_input(photos + " " + path("set") + target, {"--rig"});
  expect_bad_input(photos + target + " --until 3mm", {"--until", "0.1px", "3mm"});
  expect_bad_input(photos + target + " --until -1px", {"--until"});
  expect_bad_input(photos + target + " --model nothing", {"nothing"});
  expect_bad_input(photos + target + " --out " + path("no/camera.yaml"), {path("no")});
  spill(root() / "points.yaml",
        "target_type: points\npoints:\n  - [0, 0, 0, 0]\n  - [1, 1, 0, 0]\n");
  expect_bad_input(photos + " --target " + path("points.yaml"), {"no tags to detect"});
}

}  // namespace
}  // namespace tagcal::tools
