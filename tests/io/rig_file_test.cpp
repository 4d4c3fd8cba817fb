#include "tagcal/io/rig_file.hpp"

#include <gtest/gtest.h>

#include <set>

#include "file_fixture.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/scene_file.hpp"

namespace tagcal {
namespace {

using Views = std::vector<std::optional<std::size_t>>;

const std::string kScene =
    "rig:\n"
    "  moves: rig\n"
    "  period_ms: 40\n"
    "  cameras:\n"
    "    - {name: left, camera: {image_size: [640, 480], model: pinhole, fx: 501, fy: 502}}\n"
    "    - name: right\n"
    "      camera: {image_size: [800, 600], model: fisheye4, f: 300}\n"
    "      rig_from_camera: {axis: [0, 1, 0], angle_deg: -3, translation_m: [0.11, 0, 0]}\n"
    "      time_offset_ms: 12.5\n"
    "      sensor: {noise_levels: 4}\n"
    "boards:\n"
    "  - target: {target_type: aprilgrid, tagCols: 3, tagRows: 3, tagSize: 0.08, tagSpacing: 0.3}\n"
    "    world_from_board: {translation_m: [-0.15, -0.15, 0]}\n"
    "sensor: {noise_levels: 2}\n"
    "path: {type: ring, centre_m: [0, 0, 0.8], radius_m: 0.5}\n"
    "views: 4\n";

class RigSceneFile : public FileTest {
 protected:
  AnyScene read(const std::string& text) { return read_any_scene(write("scene.yaml", text)); }
};

TEST_F(RigSceneFile, ReadsAllThatItNames) {
  const AnyScene scene = read(kScene);
  const RigScene& rig = std::get<RigScene>(scene);
  EXPECT_FALSE(rig.boards_move);
  EXPECT_DOUBLE_EQ(rig.period_s, 0.04);
  EXPECT_EQ(rig.scene.settings.num_views, 4);
  ASSERT_EQ(rig.cameras.size(), 2U);
  EXPECT_EQ(rig.cameras[0].name, "left");
  EXPECT_EQ(rig.cameras[0].model, "pinhole");
  EXPECT_TRUE(same(rig.cameras[0].rig_from_camera, Pose()));
  EXPECT_EQ(rig.cameras[0].sensor->noise_levels, 2);
  EXPECT_EQ(rig.cameras[1].camera.image_size, (ImageSize{800, 600}));
  EXPECT_EQ(rig.cameras[1].model, "fisheye4");
  EXPECT_EQ(rig.cameras[1].rig_from_camera.translation().x(), 0.11);
  EXPECT_DOUBLE_EQ(rig.cameras[1].time_offset_s, 0.0125);
  EXPECT_EQ(rig.cameras[1].sensor->noise_levels, 4);
  EXPECT_TRUE(
      std::get<RigScene>(read(replaced(kScene, "moves: rig", "moves: boards"))).boards_move);
}

TEST_F(RigSceneFile, BadScenesAreOneLine) {
  const BadFile bad[] = {
      {"name: right", "name: left", "rig.cameras[1].name: must differ from the cameras before it"},
      {"name: right", "name: a/b", "rig.cameras[1].name: names a folder: must be at most 64"},
      {"name: right", "name: ..", "rig.cameras[1].name: names a folder: must be at most 64"},
      {"[0.11, 0, 0]", "[.nan, 0, 0]",
       "rig.cameras[1].rig_from_camera.translation_m[0]: must be a finite number, got .nan"},
      {"time_offset_ms: 12.5", "time_offset_ms: .inf",
       "rig.cameras[1].time_offset_ms: must be a finite number, got .inf"},
      {"time_offset_ms", "time_offset_s",
       "rig.cameras[1].time_offset_s: unknown key; did you mean"},
      {"period_ms: 40", "period_ms: 0", "rig.period_ms: must be > 0, got 0"},
      {"moves: rig", "moves: camera", "rig.moves: must be rig or boards, got camera"},
      {"noise_levels: 4", "noise_levels: -4",
       "rig.cameras[1].sensor.noise_levels: must be >= 0, got -4"},
      {"rig:\n", "camera: {image_size: [64, 48], model: f, f: 50}\nrig:\n",
       "rig: takes the place of the scene's camera: give one"},
      {"model: fisheye4, f: 300", "model: window",
       "rig.cameras[1].camera.model: a window's lens differs from view to view"},
      {"path: {type: ring, centre_m: [0, 0, 0.8], radius_m: 0.5}",
       "path: {type: window, lower_left_m: [0, 0, 0], lower_right_m: [1, 0, 0], upper_left_m: [0, "
       "0, 1], eye_m: [0, -1, 0]}",
       "path: type window and the camera's model window need each other"},
  };
  for (const BadFile& b : bad) {
    const std::string error = error_of([&] { read(replaced(kScene, b.from, b.to)); });
    EXPECT_HAS(error, "scene.yaml: " + b.message);
  }
  const std::string head = kScene.substr(0, kScene.find("    - {name"));
  const std::string tail = kScene.substr(kScene.find("boards:"));
  const auto with = [&](int n) {
    std::string cameras;
    for (int i = 0; i < n; ++i)
      cameras += "    - {name: c" + std::to_string(i) +
                 ", camera: {image_size: [64, 48], model: f, f: 50}}\n";
    return head + cameras + tail;
  };
  EXPECT_EQ(std::get<RigScene>(read(with(64))).cameras.size(), 64U);
  EXPECT_HAS(error_of([&] { read(with(65)); }),
             "scene.yaml: rig.cameras: must be a list of at most 64");
  EXPECT_HAS(error_of([&] { read(with(0)); }), "scene.yaml: rig.cameras: must be a list");
  EXPECT_HAS(error_of([&] { read_moving_scene(write("scene.yaml", kScene)); }),
             "scene.yaml: rig: only tagcal render draws a rig");
}

// A data set of exact corners, without pictures.
class RigFile : public FileTest {
 protected:
  RigFile() {
    rig_ = exact_rig_dataset(std::get<RigScene>(read_any_scene(write("scene.yaml", kScene))), 3,
                             nullptr);
    for (const RigCamera& camera : rig_.cameras) {
      fs::create_directories(folder_ / camera.name);
      write(camera.name + "/seen.csv", observations_csv(camera.data.views));
      write_truth(folder_ / camera.name / "truth.yaml", *camera.data.truth);
    }
    write_rig_dataset(folder_, rig_, {"", "seen.csv", "truth.yaml"});
    text_ = read_text(folder_ / "dataset.yaml");
  }

  std::string error_with(const std::string& from, const std::string& to) {
    write("dataset.yaml", replaced(text_, from, to));
    std::string error = error_of([&] { read_rig_folder(folder_); });
    const std::size_t at = error.find(folder_.string() + "/");
    return at == 0 ? error.substr(folder_.string().size() + 1) : error;
  }

  RigDataset rig_;
  std::string text_;
};

TEST_F(RigFile, ReadsWhatItWrites) {
  EXPECT_TRUE(is_rig_folder(folder_));
  EXPECT_FALSE(is_rig_folder(folder_ / "left"));
  const RigDataset back = read_rig_dataset(folder_);
  ASSERT_EQ(back.cameras.size(), 2U);
  for (std::size_t c = 0; c < 2; ++c) {
    const RigCamera& camera = back.cameras[c];
    const RigCamera& expected = rig_.cameras[c];
    EXPECT_EQ(camera.name, expected.name);
    EXPECT_EQ(camera.times_s, expected.times_s);
    EXPECT_EQ(camera.data.image_size, expected.data.image_size);
    EXPECT_EQ(camera.data.truth->model, expected.data.truth->model);
    ASSERT_EQ(camera.data.boards.size(), 1U);
    EXPECT_TRUE(
        same(camera.data.boards[0].world_from_board, expected.data.boards[0].world_from_board));
    EXPECT_EQ(observations_csv(camera.data.views), observations_csv(expected.data.views));
    EXPECT_TRUE(same(back.truth->camera_from_rig[c], rig_.truth->camera_from_rig[c]));
    EXPECT_EQ(back.truth->time_offset_s[c], rig_.truth->time_offset_s[c]);
  }
  ASSERT_EQ(back.instants.size(), 4U);
  EXPECT_EQ(back.instants[2].view, (Views{2, 2}));
}

TEST_F(RigFile, PicturesAloneAreLeftToTheDetection) {
  for (const std::string name : {"left", "right"}) {
    fs::create_directories(folder_ / name / "images");
    const ImageSize size = name == "left" ? ImageSize{640, 480} : ImageSize{80, 60};
    write_png(folder_ / name / "images/000.png", Image8(size));
  }
  write("dataset.yaml",
        "target: target.yaml\nrig: {cameras: [{name: left, images: left/images, times: "
        "left/times.csv}, {name: right, images: right/images}]}\n");
  const RigFolder read = read_rig_folder(folder_);
  EXPECT_EQ(read.rig.cameras[1].data.image_size, (ImageSize{80, 60}));
  EXPECT_TRUE(read.rig.instants.empty());
  EXPECT_TRUE(read.rig.cameras[0].times_s.empty());
  ASSERT_EQ(read.files[0].images.size(), 1U);
  EXPECT_EQ(times_of({{"000.png", {}}}, read.files[0]), std::vector<double>{0});
  EXPECT_FALSE(read.rig.truth);
  write("dataset.yaml",
        "target: target.yaml\nrig: {cameras: [{name: left, images: left/images}, {name: right, "
        "images: left/../left/images/}]}\n");
  EXPECT_HAS(error_of([&] { read_rig_folder(folder_); }),
             "rig.cameras[1].images: must differ from the cameras before it");
  // A picture that is left out states no size.
  write("dataset.yaml",
        "target: target.yaml\nrig: {cameras: [{name: left, images: left/images}]}\n");
  EXPECT_HAS(error_of([&] { read_rig_folder(folder_, [](const fs::path&) { return true; }); }),
             "rig.cameras[0]: needs image_size");
}

TEST_F(RigFile, BadDataSetsAreOneLine) {
  EXPECT_EQ(error_with("name: \"right\"", "name: left"),
            "dataset.yaml: rig.cameras[1].name: must differ from the cameras before it, got left");
  EXPECT_EQ(error_with("\"right/seen.csv\"", "right/../left/seen.csv"),
            "dataset.yaml: rig.cameras[1].observations: must differ from the cameras before it, "
            "got right/../left/seen.csv");
  EXPECT_EQ(error_with("observations: \"right/seen.csv\"", "images: none"),
            "dataset.yaml: rig.cameras[1].images: must be a folder of pictures (No such file or "
            "directory), got none");
  EXPECT_EQ(error_with("      observations: \"right/seen.csv\"\n", ""),
            "dataset.yaml: rig.cameras[1]: needs observations: FILE or images: FOLDER");
  EXPECT_EQ(error_with("      image_size: [800, 600]\n", ""),
            "dataset.yaml: rig.cameras[1]: needs image_size: [WIDTH, HEIGHT], because no picture "
            "states it");
  EXPECT_EQ(error_with("image_size: [800, 600]", "image_size: [800, 601]"),
            "right/truth.yaml: camera: is for 800x600 pixels, but image_size in dataset.yaml is "
            "[800, 601]");
  EXPECT_EQ(error_with("rig:\n", "image_size: [8, 8]\nrig:\n").substr(0, 38),
            "dataset.yaml: image_size: unknown key;");
  EXPECT_ERROR(
      read_rig_folder(folder_ / "none"),
      (folder_ / "none").string() + ": must be the folder of a data set, with dataset.yaml in it");
}

TEST_F(RigFile, BadTimesAndTruthAreOneLine) {
  const auto error = [&](const char* name, const std::string& text) {
    const std::string before = read_text(folder_ / name);
    write(name, text);
    const std::string message = error_with("rig:", "rig:");
    write(name, before);
    return message;
  };
  const char* const times = "right/times.csv";
  EXPECT_EQ(error(times, ""), "right/times.csv: is empty");
  EXPECT_EQ(error(times, "image,time\n"),
            "right/times.csv: line 1: must be the header image,time_s");
  EXPECT_EQ(error(times, "image,time_s\n000.png,0\n\n001.png,soon\n"),
            "right/times.csv: line 4: time_s: must be a finite number, got soon");
  EXPECT_EQ(error(times, "image,time_s\n000.png,0\n000.png,1\n"),
            "right/times.csv: line 3: image: 000.png has a time already");
  EXPECT_EQ(error(times, "image,time_s\n000.png\n"),
            "right/times.csv: line 2: must have 2 fields, got 1");
  EXPECT_EQ(error(times, "image,time_s\n000.png,0\n"),
            "right/times.csv: has no row for the picture 001.png");
  const std::string truth = read_text(folder_ / "truth.yaml");
  EXPECT_EQ(error("truth.yaml", replaced(truth, "\"right\"", "wrong")),
            "truth.yaml: cameras[1].name: must be the cameras of dataset.yaml in their order, got "
            "wrong");
  EXPECT_EQ(error("truth.yaml", truth.substr(0, truth.find("  - name: \"right\""))),
            "truth.yaml: cameras: has 1 cameras, but dataset.yaml has 2");
}

TEST_F(RigFile, TheFolderOfARigIsNoDataSetOfACamera) {
  const std::string rig = folder_.string();
  EXPECT_ERROR(read_dataset(folder_), rig + ": is the data set of a rig: use tagcal rig " + rig);
  write("left/dataset.yaml", "");
  EXPECT_ERROR(read_dataset(folder_), rig + ": is the data set of a rig: use tagcal rig " + rig +
                                          ", or one of its cameras, " + rig + "/left");
}

TEST_F(RigFile, PairsByATable) {
  const auto pair = [&](const std::string& text, std::vector<std::string>* notes = nullptr) {
    return pair_by_file(write("pairs.csv", text), rig_.cameras, notes);
  };
  std::vector<std::string> notes;
  const auto instants =
      pair("right,left\n003.png,images/000.png\n,001.png\nblank.png,\n\n000.png,002.png\n", &notes);
  ASSERT_EQ(instants.size(), 3U);
  EXPECT_EQ(instants[0].view, (Views{0, 3}));
  EXPECT_EQ(instants[1].view, (Views{1, std::nullopt}));
  EXPECT_EQ(instants[2].view, (Views{2, 0}));
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_HAS(notes[0], "1 names of camera right are no view of it, blank.png first");
  const auto error = [&](const std::string& text) {
    const std::string message = error_of([&] { pair(text); });
    return message.substr(std::min(message.size(), folder_.string().size() + 1));
  };
  EXPECT_EQ(error("left,middle\n"), "pairs.csv: line 1: middle is the name of no camera");
  EXPECT_EQ(error("left,left\n"), "pairs.csv: line 1: left has two columns");
  EXPECT_EQ(error("left\n"), "pairs.csv: line 1: has no column for camera right");
  EXPECT_EQ(error("left,right\n000.png,001.png\n000.png,002.png\n"),
            "pairs.csv: line 3: 000.png of camera left is in a row before it");
  EXPECT_EQ(error("left,right\nx.png,001.png\n"),
            "pairs.csv: 1 names of camera left are no view of it, x.png first");
}

}  // namespace
}  // namespace tagcal
