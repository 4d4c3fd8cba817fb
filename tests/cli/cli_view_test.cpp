// tagcal view, and the numbers of docs/course/viewing.md, all of which come from it.
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli_fixture.hpp"
#include "tagcal/io/image_file.hpp"
#include "view_json.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kSource = TAGCAL_SOURCE_DIR;

TEST_F(Cli, ThePageOnTheViewingPipelineShowsWhatTheCommandPrints) {
  const std::string page = slurp(kSource + "/docs/course/viewing.md");
  int shown = 0;
  for (std::size_t at = page.find("```\n$ tagcal "); at != std::string::npos;
       at = page.find("```\n$ tagcal ", at + 1), ++shown) {
    const std::size_t command = at + std::string("```\n$ tagcal ").size();
    const std::size_t line_end = page.find('\n', command);
    std::string text = page.substr(line_end + 1, page.find("```", line_end) - line_end - 1);
    std::string arguments = page.substr(command, line_end - command);
    SCOPED_TRACE(arguments);
    arguments = replaced(arguments, "data-synthetic", kSource + "/data-synthetic");
    const Outcome outcome = good_run(arguments);
    std::string printed = outcome.out;
    if (text.starts_with("...\n")) {  // the page leaves out the matrices
      text = text.substr(4);
      printed = printed.substr(printed.rfind("\n\n") + 2);
    }
    expect_same_text(text, printed, 2e-6, 0);
  }
  EXPECT_EQ(shown, 16);
}

TEST_F(Cli, ThePicturesOnThePageAreTheCommands) {
  const std::string script = "sh " + kSource + "/docs/course/viewing/pictures.sh ";
  ASSERT_EQ(std::system((script + TAGCAL_COMMAND + " " + path("pictures")).c_str()), 0);
  int pictures = 0;
  for (const auto& entry : fs::directory_iterator(root() / "pictures")) {
    SCOPED_TRACE(entry.path().filename());
    const Image8 made = read_image(entry.path());
    const Image8 shown =
        read_image(fs::path(kSource) / "docs/course/viewing" / entry.path().filename());
    ASSERT_EQ(made.pixels().size(), shown.pixels().size());
    int most = 0;  // rounding differs between machines
    for (std::size_t i = 0; i < made.pixels().size(); ++i)
      most = std::max(most, std::abs(made.pixels()[i] - shown.pixels()[i]));
    EXPECT_LE(most, 1);
    ++pictures;
  }
  EXPECT_EQ(pictures, 13);
}

TEST_F(Cli, ThePageWritesOneCameraInThreeWays) {
  const std::string page = slurp(kSource + "/docs/course/viewing.md");
  const std::string scene = slurp(kSource + "/data-synthetic/scenes/viewing/turned.yaml");
  std::vector<Eigen::Matrix4d> cameras;
  for (const std::string type : {"look_at", "orbit", "roll_pitch_yaw"}) {
    const std::size_t from = page.find("`{type: " + type) + 1;
    const std::string camera = page.substr(from, page.find('`', from) - from);
    const std::size_t path_at = scene.find("path: ");
    spill(root() / "turned.yaml", scene.substr(0, path_at) + "path: " + camera + "\n");
    const Outcome outcome = run("view --json " + path("turned.yaml"));
    ASSERT_EQ(outcome.exit_code, 0) << camera << outcome.err;
    cameras.push_back(matrix(Json::parse(outcome.out)["matrices"]["camera_from_world"]));
    EXPECT_LT((cameras.back() - cameras.front()).norm(), 1e-5) << camera;  // angles of 4 decimals
  }
}

TEST_F(Cli, TheDrawingOnThePageIsTheCommands) {
  const Outcome outcome = good_run(
      "view " + kSource + "/data-synthetic/scenes/doorway.yaml --at 0:2 --near 1 --far 10 --svg");
  const std::string page = slurp(kSource + "/docs/course/viewing.svg");
  // Rounding differs between machines; the drawn elements, each with a colour, do not.
  const auto num_colours = [](const std::string& svg) {
    int count = 0;
    for (std::size_t at = svg.find("rgb("); at != std::string::npos; at = svg.find("rgb(", at + 1))
      ++count;
    return count;
  };
  EXPECT_GT(num_colours(page), 200);
  EXPECT_EQ(num_colours(page), num_colours(outcome.out));
  EXPECT_HAS(outcome.out, "</svg>");
}

TEST_F(Cli, ViewPrintsMatricesThatTakeThePointFromFrameToFrame) {
  for (const std::string at : {"0:0", "5:3", "0.1,0.1,0.02"}) {
    const Outcome outcome =
        good_run("view " + path("scene.yaml") + " --view 2 --seed 3 --json --at " + at);
    const Json answer = Json::parse(outcome.out);
    const Json& m = answer["matrices"];
    const Json& p = answer["point"];
    const Eigen::Vector4d world = vector(p["in_world_m"]).homogeneous();
    if (!p["in_board_m"].is_null()) {
      const Eigen::Vector4d board = vector(p["in_board_m"]).homogeneous();
      EXPECT_LT((matrix(m["world_from_board"]) * board - world).norm(), 1e-15);
    }
    const Eigen::Vector4d camera = matrix(m["camera_from_world"]) * world;
    EXPECT_LT((camera.head<3>() - vector(p["in_camera_m"])).norm(), 1e-14);
    const Eigen::Vector4d eye = matrix(m["eye_from_camera"]) * camera;
    const Eigen::Vector4d clip = matrix(m["clip_from_eye"]) * eye;
    EXPECT_LT((clip - vector(p["in_clip"])).norm(), 1e-14);
    const Eigen::Vector4d raster = matrix(m["raster_from_ndc"]) * (clip / clip.w());
    EXPECT_LT((raster.head<2>() - vector(p["in_raster_px"])).norm(), 1e-9);
    EXPECT_TRUE(p["in_volume"]);
    EXPECT_EQ(answer["view_volume"]["normalising_steps"].size(), 4u);
    EXPECT_EQ(answer["vanishing_points_px"].size(), 3u);
  }
}

TEST_F(Cli, ViewFollowsTheCornersThatRenderWrote) {
  std::istringstream rows(slurp(root() / "set" / "observations_exact.csv"));
  std::string row;
  std::getline(rows, row);
  for (int i = 0; i < 5 && std::getline(rows, row); ++i) {
    std::replace(row.begin(), row.end(), ',', ' ');
    std::istringstream fields(row);
    std::string image, tag, corner;
    double x = 0, y = 0;
    fields >> image >> tag >> corner >> x >> y;
    const Outcome outcome =
        good_run("view " + path("scene.yaml") + " --json --view " +
                 std::to_string(std::stoi(image)) + " --at " + tag + ":" + corner);
    const Json point = Json::parse(outcome.out)["point"];
    EXPECT_EQ(point["seen"], true);
    EXPECT_NEAR(point["pixel"][0], x, 1e-9);
    EXPECT_NEAR(point["pixel"][1], y, 1e-9);
  }
}

TEST_F(Cli, ViewOfAFisheyeAndOfAPointBehindIt) {
  spill(root() / "fisheye.yaml",
        replaced(replaced(kScene, "model: radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]",
                          "model: fisheye4, f: 200"),
                 "views: 6", "views: 1"));
  const Outcome outcome = good_run("view " + path("fisheye.yaml") + " --json --at 0,0,5");
  const Json point = Json::parse(outcome.out)["point"];
  EXPECT_EQ(point["in_ndc"], nullptr);
  EXPECT_EQ(point["seen"], false);
  EXPECT_EQ(run("view " + path("fisheye.yaml") + " --svg --at 0,0,5").exit_code, 0);
}

TEST_F(Cli, ViewNamesBadInput) {
  const std::string view = "view " + path("scene.yaml") + " ";
  expect_bad_input(view + "--at 99:0", {"--at", "99:0"});
  expect_bad_input(view + "--at 0:4", {"--at", "0:4"});
  expect_bad_input(view + "--at 1,2", {"--at", "TAG:CORNER", "1,2"});
  expect_bad_input(view + "--at 1,2,nan", {"--at", "1,2,nan"});
  expect_bad_input(view + "--at here", {"--at", "here"});
  expect_bad_input(view + "--view 6", {"--view", "5", "6"});
  expect_bad_input(view + "--near 2 --far 1", {"--near", "< far", "2", "1"});
  expect_bad_input(view + "--near 0", {"--near", "> 0"});
  expect_bad_input(view + "--json --svg", {"--json", "--svg"});
  expect_bad_input(view + "--steps --opengl", {"--steps", "--opengl"});
  expect_bad_input(view + "--camera " + path("camera.yaml"), {"--camera", "data set"});
  expect_bad_input("view " + path("none.yaml"), {"none.yaml"});
  expect_bad_input("view " + path("set") + " --view 6", {"--view", "5", "6"});
  EXPECT_EQ(run("view " + path("set/truth.yaml")).exit_code, 0);  // a camera, as a calibration is
  spill(root() / "camera.yaml", kCamera);
  expect_bad_input("view " + path("camera.yaml") + " --view 1", {"--view", "0", "1"});
  expect_bad_input("view " + path("camera.yaml") + " --at 0:0", {"--at", "0:0"});
  expect_bad_input("view " + path("set") + " --camera " + path("camera.yaml"), {"image size"});
  fs::copy(root() / "set", root() / "blind", fs::copy_options::recursive);
  spill(root() / "blind" / "dataset.yaml",
        "image_size: [640, 400]\ntarget: target.yaml\nobservations: observations_exact.csv\n");
  expect_bad_input("view " + path("blind"), {"blind", "no truth", "--camera"});
}

}  // namespace
}  // namespace tagcal::tools
