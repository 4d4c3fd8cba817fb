// Videos among the pictures, from outside.
#include <fmt/format.h>

#include <algorithm>

#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

class CliVideo : public Cli {
 protected:
  void SetUp() override {
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "needs ffmpeg";
    spill(root() / "scene.yaml",
          "camera: {image_size: [480, 360], model: pinhole, f: 400}\n"
          "boards:\n"
          "  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: "
          "0.3}\n"
          "    world_from_board: {translation_m: [-0.2, -0.2, 0]}\n"
          "path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.9, min_elevation_deg: 50}\n"
          "views: 12\n"
          "sensor: {blur_px: 0.6, noise_levels: 1}\n");
    render_as_set("scene.yaml", "still");
  }

  // Each scene is rendered once in this program, to a folder, and copied.
  static void render_as_set(const std::string& scene, const std::string& folder) {
    if (!fs::exists(root() / folder)) good_run("render " + path(scene) + " --out " + path(folder));
    fs::remove_all(root() / "set");
    fs::copy(root() / folder, root() / "set", fs::copy_options::recursive);
  }

  void encode(const std::string& name, const std::string& options) {
    const std::string command = "ffmpeg -loglevel error -y -framerate 10 -i " +
                                path("set/images/%03d.png") + " " + options + " " + path(name);
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }

  // A ring that the camera goes along while its rows are read, from the first to the last in so
  // many of the 100 ms to the next picture.
  void film_ring(const std::string& video, const std::string& focal_px,
                 const std::string& readout_ms = "20") {
    std::string scene = slurp(root() / "scene.yaml");
    scene.replace(scene.find("path:"), scene.find("\nsensor") - scene.find("path:"),
                  "path: {type: ring, centre_m: [0.15, -0.1, 0.7], radius_m: 0.4, end_deg: 180, "
                  "target_m: [-0.08, 0.08, 0]}\nviews: 24\nperiod_ms: 100");
    scene.replace(scene.find("sensor: {"), 9, "sensor: {readout_ms: " + readout_ms + ", ");
    scene.replace(scene.find("f: 400"), 6, "f: " + focal_px);
    scene.replace(scene.find("noise_levels: 1"), 15, "noise_levels: 3");
    spill(root() / "ring.yaml", scene);
    render_as_set("ring.yaml", "ring_" + focal_px + "_" + readout_ms);
    encode(video, "-c:v ffv1 -pix_fmt gray");
  }

  std::string answer(const std::string& pictures, const std::string& options = "") {
    const Outcome out = good_run("detect " + pictures + " --target " + path("set/target.yaml") +
                                 " --no-cache --out " + path("corners.csv") + " " + options);
    said_ = out.err;
    return slurp(root() / "corners.csv");
  }

  std::string said_;
};

TEST_F(CliVideo, ALosslessOneHasTheCornersOfItsPictures) {
  encode("clip.mkv", "-c:v ffv1 -pix_fmt gray");
  const std::string of_pictures = answer(path("set/images"));
  const std::string of_video = answer(path("clip.mkv"));
  const std::string without_times =
      std::regex_replace(of_video, std::regex(",(time_s|\\d\\.\\d{6})\n"), "\n");
  EXPECT_HAS(of_video, ",1.100000\n");
  EXPECT_EQ(std::regex_replace(without_times, std::regex("clip@000"), ""),
            std::regex_replace(of_pictures, std::regex("\\.png"), ""));
}

TEST_F(CliVideo, ACalibrationIsWithinItsClaims) {
  encode("clip.mp4", "-c:v libx264 -crf 23 -pix_fmt yuv420p");
  const Outcome out = run("calibrate " + path("clip.mp4") + " --target " + path("set/target.yaml") +
                          " --report " + path("page.html") + " --out " + path("camera.yaml"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Outcome truth =
      run("validate " + path("camera.yaml") + " --dataset " + path("set") + " --truth");
  EXPECT_EQ(truth.exit_code, 0) << truth.out << truth.err;
  const std::string page = slurp(root() / "page.html");
  EXPECT_HAS(page, R"("image":"clip@000003","time_s":0.3,)");
}

TEST_F(CliVideo, TheReadoutOfARollingShutterIsFound) {
  film_ring("clip.mkv", "400");
  encode("first.mkv", "-c:v ffv1 -pix_fmt gray -frames:v 12");
  encode("last.mkv", "-c:v ffv1 -pix_fmt gray -vf trim=start_frame=12,setpts=PTS-STARTPTS");
  const std::string command =
      "calibrate --target " + path("set/target.yaml") + " --shutter rolling ";
  const Outcome out = run(command + path("clip.mkv") + " --json --report " + path("page.html"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const auto readout = nlohmann::json::parse(out.out)["readout"];
  EXPECT_NEAR(readout["ms"], 20, 3 * readout["sigma_ms"].get<double>());
  EXPECT_LT(readout["sigma_ms"], 0.5);
  EXPECT_EQ(readout["num_views"], 24);  // the first calibration rejects some: their motion is large
  EXPECT_HAS(slurp(root() / "page.html"), R"("readout":{"ms":)");
  // So it is without being asked for, also from the neighbours of a few frames.
  for (const std::string frames : {"", " --frames every:3"}) {
    const Outcome found = run("calibrate --target " + path("set/target.yaml") +
                              " --model f --json " + path("clip.mkv") + frames);
    ASSERT_EQ(found.exit_code, 0) << found.err << found.out;
    const auto by_itself = nlohmann::json::parse(found.out)["readout"];
    ASSERT_TRUE(by_itself.is_object()) << frames;
    EXPECT_NEAR(by_itself["ms"], 20, 3 * by_itself["sigma_ms"].get<double>());
    EXPECT_GT(by_itself["num_views"], 20);
  }
  // And of corners that were found before, with their times.
  good_run("detect --target " + path("set/target.yaml") + " --out " + path("c.csv") + " " +
           path("clip.mkv"));
  fs::create_directory(root() / "corners");
  spill(root() / "corners/dataset.yaml",
        "image_size: [480, 360]\ntarget: ../set/target.yaml\nobservations: ../c.csv\n");
  EXPECT_HAS(good_run("calibrate " + path("corners") + " --model f").out, "\nreadout    ");
  const Outcome none = run("calibrate --target " + path("set/target.yaml") + " --model f --json " +
                           path("clip.mkv") + " --shutter global");
  EXPECT_TRUE(nlohmann::json::parse(none.out)["readout"].is_null());
  // Two videos whose times are the same.
  const Outcome pieces =
      run(command + "--model f --json " + path("first.mkv") + " " + path("last.mkv"));
  ASSERT_EQ(pieces.exit_code, 0) << pieces.err << pieces.out;
  const auto of_both = nlohmann::json::parse(pieces.out)["readout"];
  EXPECT_NEAR(of_both["ms"], 20, 3 * of_both["sigma_ms"].get<double>());
  const Outcome pictures = run(command + path("set/images"));
  EXPECT_EQ(pictures.exit_code, 2);
  EXPECT_HAS(pictures.err, "--shutter rolling: needs a time for each picture");
}

// Two cameras at one place, of different lenses.
TEST_F(CliVideo, TheReadoutsOfARigAreFound) {
  film_ring("left.mkv", "400");
  film_ring("right.mkv", "360");
  const std::string command = "rig " + path("left.mkv") + " " + path("right.mkv") + " --target " +
                              path("set/target.yaml") + " --model f";
  for (const std::string option : {" --shutter rolling", "", " --frames every:3"}) {
    const Outcome out = run(command + option + " --json --report " + path("page.html"));
    ASSERT_EQ(out.exit_code, 0) << option << out.err << out.out;
    const auto rig = nlohmann::json::parse(out.out);
    for (const auto& camera : rig["cameras"]) {
      ASSERT_TRUE(camera["readout"].is_object()) << option;
      EXPECT_NEAR(camera["readout"]["ms"], 20, 3 * camera["readout"]["sigma_ms"].get<double>());
      EXPECT_GT(camera["readout"]["num_views"], 20);
      const auto& f = camera["lens"]["fx"];
      EXPECT_NEAR(f["value"], camera["name"] == "left.mkv" ? 400 : 360,
                  4 * f["sigma"].get<double>());
    }
    EXPECT_EQ(rig["num_paired"], option.ends_with("3") ? 8 : 24);
    EXPECT_HAS(slurp(root() / "page.html"), R"("readout":{"ms":)");
  }
  EXPECT_HAS(run(command).out, "\nleft.mkv: readout ");
  const Outcome global = run(command + " --shutter global --json");
  for (const auto& camera : nlohmann::json::parse(global.out)["cameras"])
    EXPECT_TRUE(camera["readout"].is_null());
}

// With the neighbours of the frames, or if they have them.
TEST_F(CliVideo, TheGlobalShuttersOfARigChangeNothing) {
  film_ring("left.mkv", "400", "0");
  film_ring("right.mkv", "360", "0");
  for (const std::string frames : {"", " --frames every:3"}) {
    const std::string command = "rig " + path("left.mkv") + " " + path("right.mkv") + " --target " +
                                path("set/target.yaml") + " --model f --json" + frames;
    auto looked = nlohmann::json::parse(run(command).out);
    auto plain = nlohmann::json::parse(run(command + " --shutter global").out);
    ASSERT_EQ(plain["status"], "ok");
    looked.erase("seconds");
    plain.erase("seconds");
    EXPECT_EQ(looked, plain) << frames;
  }
}

TEST_F(CliVideo, APipeIsAVideo) {
  encode("clip.mkv", "-c:v ffv1 -pix_fmt gray");
  const std::string of_video = answer(path("clip.mkv"));
  for (const std::string kind : {"yuv4mpegpipe -pix_fmt gray", "mjpeg -q:v 1 -pix_fmt gray"}) {
    const std::string command = "ffmpeg -loglevel error -i " + path("clip.mkv") + " -f " + kind +
                                " - | " + TAGCAL_COMMAND + " detect - --target " +
                                path("set/target.yaml") + " --out " + path("piped.csv") + " 2>" +
                                path("said.txt");
    ASSERT_EQ(std::system(command.c_str()), 0) << slurp(root() / "said.txt");
    const std::string piped = slurp(root() / "piped.csv");
    EXPECT_HAS(piped, "stdin@000011,");
    // Y4M loses nothing.
    if (kind.starts_with("yuv")) {
      EXPECT_EQ(std::regex_replace(piped, std::regex("stdin@"), "clip@"), of_video);
    }
  }
  for (const auto& [sent, message] :
       {std::pair{"hello", "neither MJPEG nor Y4M"}, {"", "is empty"}}) {
    const std::string command = std::string("printf '") + sent + "' | " + TAGCAL_COMMAND +
                                " detect - --target " + path("set/target.yaml") + " 2>" +
                                path("said.txt");
    EXPECT_NE(std::system(command.c_str()), 0);
    EXPECT_HAS(slurp(root() / "said.txt"), message);
  }
}

TEST_F(CliVideo, FramesAreChosen) {
  encode("clip.mkv", "-c:v ffv1 -pix_fmt gray");
  const std::string some = answer(path("clip.mkv"), "--frames every:5");
  EXPECT_HAS(said_, "3 of 12 frames are taken");
  EXPECT_HAS(some, "clip@000010,");
  EXPECT_LACKS(some, "clip@000004,");
  spill(root() / "frames.txt", "# the good ones\n7\n2\n");
  const std::string two = answer(path("clip.mkv"), "--frames " + path("frames.txt"));
  EXPECT_HAS(two, "clip@000007,");
  EXPECT_LACKS(two, "clip@000000,");
  EXPECT_HAS(answer(path("clip.mkv") + "@000009"), "clip@000009,");
}

TEST_F(CliVideo, BadInputIsOneLine) {
  encode("clip.mkv", "-c:v ffv1 -pix_fmt gray");
  spill(root() / "frames.txt", "3\nthird\n");
  spill(root() / "beyond.txt", "12\n");
  spill(root() / "empty.mp4", "");
  for (const auto& [arguments, message] :
       {std::pair{path("clip.mkv") + " --frames " + path("frames.txt"),
                  std::string("line 2: must be the number of a frame, got third")},
        {path("clip.mkv") + " --frames " + path("beyond.txt"), "has 12 frames"},
        {path("clip.mkv") + " --frames every:0", "every:N needs a number from 1 on"},
        {path("clip.mkv") + " --frames some", "must be auto, evenly, all, every:N or a file"},
        {path("empty.mp4"), "is no video"},
        {path("clip.mkv") + " " + path("clip.mkv"), "given twice"}}) {
    const Outcome out = run("detect " + arguments + " --target " + path("set/target.yaml") +
                            " --out " + path("none.csv"));
    EXPECT_EQ(out.exit_code, 2) << arguments << out.err;
    EXPECT_HAS(out.err, message);
    EXPECT_EQ(std::ranges::count(out.err, '\n'), 1) << out.err;
    EXPECT_FALSE(fs::exists(root() / "none.csv"));
  }
}

// A camera that goes about the board and rests eight times is watched while it sends.
TEST_F(CliVideo, ALiveOneIsWatched) {
  spill(root() / "walk.yaml",
        "camera: {image_size: [480, 360], model: pinhole, f: 400}\n"
        "boards:\n"
        "  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: "
        "0.3}\n"
        "    world_from_board: {translation_m: [-0.2, -0.2, 0]}\n"
        "path: {type: orbit, distance_m: [0.6, 0.8, 0.6], azimuth_deg: [-90, 150], elevation_deg: "
        "[75, 45]}\n"
        "views: 57\n"
        "sensor: {blur_px: 0.6, noise_levels: 1}\n");
  ASSERT_EQ(run("render " + path("walk.yaml") + " --out " + path("walk")).exit_code, 0);
  std::ofstream video(root() / "live.mjpeg", std::ios::binary);
  std::ofstream restless(root() / "restless.mjpeg", std::ios::binary);
  int frame = 0;
  std::vector<std::string> rests;
  for (int view = 0; view < 57; ++view) {
    const std::string jpeg =
        jpeg_bytes(read_image(root() / fmt::format("walk/images/{:03}.png", view)), 95);
    if (view % 8 == 0) rests.push_back(fmt::format("{:06}.jpg", frame + 1));
    for (int k = 0; k < (view % 8 == 0 ? 5 : 1); ++k, ++frame) video << jpeg;
    if (view % 4 == 0) restless << jpeg;
  }
  video.close();
  restless.close();
  const auto watched = [&](const std::string& sent, const std::string& options) {
    return std::system(("cat " + path(sent) + " | " + TAGCAL_COMMAND + " watch - --target " +
                        path("walk/target.yaml") + " --every 0.05 --out " + path("live.yaml") +
                        " " + options + " >" + path("said.txt") + " 2>&1")
                           .c_str());
  };
  EXPECT_NE(watched("restless.mjpeg", ""), 0);
  EXPECT_HAS(slurp(root() / "said.txt"), "hold the board still after each move");
  ASSERT_EQ(watched("live.mjpeg", "--keep " + path("kept")), 0) << slurp(root() / "said.txt");
  const auto kept_in = [&](const std::string& folder) {
    std::vector<std::string> kept;
    for (const auto& file : fs::directory_iterator(root() / folder))
      kept.push_back(file.path().filename().string());
    std::ranges::sort(kept);
    return kept;
  };
  EXPECT_EQ(kept_in("kept"), rests);
  const std::string said = slurp(root() / "said.txt");
  EXPECT_HAS(said, "the video has ended");
  good_run("calibrate " + path("kept") + " --target " + path("walk/target.yaml") + " --out " +
           path("again.yaml"));
  const auto camera = [&](const std::string& file) {
    const std::string text = slurp(root() / file);
    return text.substr(0, text.find("views:"));
  };
  EXPECT_EQ(camera("live.yaml"), camera("again.yaml"));
  // Y4M has the same frames: grey within the rounding of two decoders of JPEG, and colour within
  // that of the limited range.
  for (const auto& [kind, most] : {std::pair{"gray", 1}, {"yuv420p", 2}, {"yuv422p", 2}}) {
    ASSERT_EQ(std::system(fmt::format("ffmpeg -loglevel error -y -f mjpeg -i {} -f yuv4mpegpipe "
                                      "-pix_fmt {} {}",
                                      path("live.mjpeg"), kind, path("live.y4m"))
                              .c_str()),
              0);
    fs::remove_all(root() / "plain");
    ASSERT_EQ(watched("live.y4m", "--model f --keep " + path("plain")), 0)
        << slurp(root() / "said.txt");
    const std::vector<std::string> plain = kept_in("plain");
    ASSERT_EQ(plain.size(), rests.size()) << kind;
    for (std::size_t i = 0; i < rests.size(); ++i) {
      EXPECT_EQ(plain[i], fs::path(rests[i]).stem().string() + ".png");
      const Image8 a = read_image(root() / "kept" / rests[i]),
                   b = read_image(root() / "plain" / plain[i]);
      ASSERT_EQ(a.size(), b.size());
      int largest = 0;
      for (int y = 0; y < a.height(); ++y)
        for (int x = 0; x < a.width(); ++x)
          largest = std::max(largest, std::abs(a(x, y) - b(x, y)));
      EXPECT_LE(largest, most) << kind;
    }
  }
  EXPECT_NE(watched("live.mjpeg", "--keep " + path("kept")), 0);  // it exists
  EXPECT_HAS(slurp(root() / "said.txt"), "give a new folder");
  spill(root() / "deep.y4m", "YUV4MPEG2 W64 H48 F30:1 C420p10\nFRAME\n");
  spill(root() / "empty.y4m", "YUV4MPEG2 W0 H48\nFRAME\n");
  spill(root() / "other.y4m", "YUV4MPEG2 W1 H1 Cmono\nFRAME\nxGRAME\n");
  for (const auto& [sent, message] : {std::pair{"walk.yaml", "neither MJPEG nor Y4M"},
                                      {"/dev/null", "no picture"},
                                      {"deep.y4m", "kind C420p10"},
                                      {"empty.y4m", "-: width and height must be > 0"},
                                      {"other.y4m", "no longer Y4M"}}) {
    const std::string file = sent[0] == '/' ? sent : path(sent);
    EXPECT_EQ(WEXITSTATUS(std::system((std::string(TAGCAL_COMMAND) + " watch - --target " +
                                       path("walk/target.yaml") + " <" + file + " >" +
                                       path("said.txt") + " 2>&1")
                                          .c_str())),
              2);
    EXPECT_HAS(slurp(root() / "said.txt"), message);
  }
}

}  // namespace
}  // namespace tagcal::tools
