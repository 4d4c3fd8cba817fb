// tagcal rig, from outside.
#include "page_data.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

class CliRig : public Cli {
 protected:
  // Corners of the scene's exact observations, with 0.1 px of noise that a seed makes.
  void render(const std::string& name, const std::string& scene) {
    spill(root() / (name + ".yaml"), scene);
    good_run("render " + path(name + ".yaml") + " --force --out " + path(name));
  }
};

std::string scene_of(const std::string& right, const std::string& views = "12") {
  return "rig:\n"
         "  period_ms: 40\n"
         "  cameras:\n"
         "    - {name: left, camera: {image_size: [480, 360], model: pinhole, f: 400}}\n"
         "    - name: right\n"
         "      camera: {image_size: [400, 300], model: pinhole, f: 330}\n" +
         right +
         "boards:\n"
         "  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: "
         "0.3}\n"
         "    world_from_board: {translation_m: [-0.2, -0.2, 0]}\n"
         "path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.9, min_elevation_deg: 50}\n"
         "jitter: {target_m: 0.05, roll_deg: 180}\n"
         "views: " +
         views +
         "\n"
         "sensor: {blur_px: 0.6, noise_levels: 2}\n";
}

std::string replaced_all(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at))
    text.replace(at, from.size(), to);
  return text;
}

const char* const kPlace =
    "      rig_from_camera: {translation_m: [0.08, 0.002, 0.001], roll_pitch_yaw_deg: [1, 2, 3]}\n";

// Corners at wrong places of the board are no answer of any command that takes a rig.
TEST_F(CliRig, AWrongTargetIsNoAnswer) {
  render("rig", scene_of(kPlace));
  good_run("rig " + path("rig") + " --out " + path("rig.yaml"));
  spill(root() / "wrong.yaml",
        replaced(slurp(root() / "rig/target.yaml"), "tagSpacing: 0.3", "tagSpacing: 0.2"));
  std::string robot = "image,x_m,y_m,z_m,qw,qx,qy,qz\n";
  for (int i = 0; i < 12; ++i)
    robot += (i < 10 ? "00" : "0") + std::to_string(i) + ".png," + std::to_string(0.01 * i) +
             ",0,0,1,0,0,0\n";
  spill(root() / "robot.csv", robot);
  const std::string cameras = " " + path("rig/left/images") + " " + path("rig/right/images") +
                              " --target " + path("wrong.yaml");
  for (const std::string& command :
       {"rig" + cameras, "pose --json --rig " + path("rig.yaml") + cameras,
        "check --camera " + path("rig.yaml") + cameras,
        "handeye --mount hand --robot " + path("robot.csv") + " --camera " + path("rig.yaml") +
            cameras,
        "handeye --mount hand --robot " + path("robot.csv") + " --camera " +
            path("rig/left/truth.yaml") + " --target " + path("wrong.yaml") + " " +
            path("rig/left/images")}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.exit_code, 3) << command << outcome.out << outcome.err;
    EXPECT_HAS(outcome.out, "wrong tag spacing");
  }
}

TEST_F(CliRig, PicturesToARigFile) {
  render("rig", scene_of(kPlace));
  const Outcome out =
      run("rig " + path("rig/left/images") + " " + path("rig/right/images") + " --target " +
          path("rig/target.yaml") + " --out " + path("rig.yaml") + " --json");
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(out.out);
  EXPECT_EQ(answer["cameras"][0]["name"], "left");
  const Json& pair = answer["pairs"][0];
  const double truth = std::sqrt(0.08 * 0.08 + 0.002 * 0.002 + 0.001 * 0.001);
  EXPECT_NEAR(pair["baseline_m"].get<double>(), truth, 4 * pair["sigma_baseline_m"].get<double>());
  EXPECT_LT(pair["sigma_baseline_m"].get<double>(), 0.001);
  EXPECT_EQ(answer["next"]["b"], "right");

  // Its poses and its comparison with the truth.
  const Outcome poses = run("pose " + path("rig") + " --rig " + path("rig.yaml") + " --json");
  ASSERT_EQ(poses.exit_code, 0) << poses.err << poses.out;
  const Json views = Json::parse(poses.out)["views"];
  ASSERT_EQ(views.size(), 12U);
  EXPECT_EQ(views[0]["status"], "ok");
  EXPECT_EQ(views[0]["cameras"], Json({"left", "right"}));
  const Json single = Json::parse(
      run("pose " + path("rig/left") + " --camera " + path("rig.yaml") + ":left --json").out);
  for (int i = 0; i < 3; ++i)  // both in the frame of the board
    EXPECT_NEAR(views[0]["camera_from_board"]["translation_m"][i].get<double>(),
                single["views"][0]["camera_from_board"]["translation_m"][i].get<double>(), 0.01);
  const Outcome valid =
      run("validate " + path("rig.yaml") + " --dataset " + path("rig") + " --truth --json");
  ASSERT_EQ(valid.exit_code, 0) << valid.err << valid.out;
  const Json checks = Json::parse(valid.out);
  EXPECT_EQ(checks["places_beyond_5_sd"], 0);
  EXPECT_EQ(checks["cameras"][1]["opencv_agrees"], true);
  EXPECT_GT(checks["places"][0]["place"][3]["sigma"].get<double>(), 0);

  // The corners of files, instead of those of the data set.
  const std::string exact =
      path("rig/left/observations_exact.csv") + "," + path("rig/right/observations_exact.csv");
  const std::string validate =
      "validate " + path("rig.yaml") + " --dataset " + path("rig") + " --observations ";
  const std::string corners = slurp(root() / "rig/left/observations_exact.csv");
  spill(root() / "few.csv", corners.substr(0, corners.find("001.png")));
  const Json few =
      Json::parse(run(validate + path("few.csv") + exact.substr(exact.find(',')) + " --json").out);
  EXPECT_EQ(few["cameras"][0]["num_views"], 1);
  EXPECT_EQ(few["cameras"][1]["num_views"], 12);
  expect_bad_input(validate + path("no.csv") + "," + path("no.csv"), {"no.csv"});
  expect_bad_input(validate + path("few.csv"), {"--observations: needs a file for each of the 2"});
  EXPECT_EQ(run("rig " + path("rig") + " --observations " + exact).exit_code, 0);
  expect_bad_input("rig " + path("rig") + " --target " + path("rig/target.yaml"),
                   {"--target: ", "is a data set, which names its own boards"});

  // Other commands take a camera of the file, and other programs' formats its places.
  EXPECT_EQ(run("diff " + path("rig.yaml") + ":left " + path("rig.yaml") + ":left").exit_code, 0);
  good_run("convert " + path("rig.yaml") + " " + path("chain.yaml") + " --to kalibr");
  EXPECT_HAS(slurp(root() / "chain.yaml"), "T_cn_cnm1");
}

// `diff` of rigs: the same rig from other noise and with another reference, a moved camera, another
// lens, and files of other programs.
TEST_F(CliRig, DifferenceOfTwoRigs) {
  render("rig", scene_of(kPlace));
  const std::string sets = path("rig/left/images") + " " + path("rig/right/images") + " --target " +
                           path("rig/target.yaml");
  const auto calibrate = [&](const std::string& out, const std::string& more) {
    good_run("rig " + sets + " --out " + path(out) + more);
  };
  calibrate("a.yaml", "");
  calibrate("b.yaml", " --reference right --cameras joint");
  const auto diff = [&](const std::string& b, const std::string& a = "a.yaml") {
    const Outcome outcome = good_run("diff " + path(a) + " " + path(b) + " --json");
    return Json::parse(outcome.out);
  };
  const Json same = diff("b.yaml");
  // A copy keeps the covariance and the warnings; of other lenses it is said that it does not.
  std::string warned = slurp(root() / "b.yaml");
  warned = warned.substr(0, warned.find("warnings:")) + "warnings:\n   - \"a doubt\"\n";
  spill(root() / "b.yaml", warned);
  const std::string copy = "convert " + path("b.yaml") + " " + path("copy.yaml") + " --to tagcal";
  const Outcome copied = run(copy);
  EXPECT_LACKS(copied.err, "dropped");
  const CameraFile kept = read_camera_file(root() / "copy.yaml");
  EXPECT_EQ(kept.rig_covariance, read_camera_file(root() / "b.yaml").rig_covariance);
  ASSERT_EQ(kept.findings.size(), 1U);
  EXPECT_EQ(kept.findings[0].sentence, "a doubt");
  const std::string scaled = run(copy + " --model opencv8").err;
  EXPECT_HAS(scaled, "dropped: the covariance of the rig");
  EXPECT_HAS(scaled, "dropped: the warnings");
  EXPECT_EQ(read_camera_file(root() / "copy.yaml").rig_covariance.size(), 0);
  EXPECT_EQ(same["verdict"], "valid");
  ASSERT_EQ(same["pairs"].size(), 1U);
  const Json& pair = same["pairs"][0];
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(pair["translation_m"][i].get<double>()),
              0.1 * pair["translation_sigma_m"][i].get<double>());
    EXPECT_GT(pair["rotation_sigma_deg"][i].get<double>(), 0);
  }
  EXPECT_EQ(same["cameras"][1]["name"], "right");

  // A camera that moved by 5 mm, in the file alone.
  const std::string text = slurp(root() / "a.yaml");
  const std::size_t at = text.find("translation_m: [", text.find("name: \"right\"")) + 16;
  spill(root() / "moved.yaml", text.substr(0, at) + "-0.085" + text.substr(text.find(',', at)));
  const Json moved = diff("moved.yaml");
  EXPECT_EQ(moved["verdict"], "changed");
  EXPECT_EQ(moved["differs_in"], Json({"the place of right from left"}));
  EXPECT_GT(moved["pairs"][0]["in_sigmas"].get<double>(), 5);
  const Outcome shown = run("diff " + path("a.yaml") + " " + path("moved.yaml"));
  EXPECT_HAS(shown.out, "CHANGED: the place of right from left differs");

  // Another program's file has no covariances: those of one rig are enough; of neither, it is said.
  good_run("convert " + path("a.yaml") + " " + path("chain.yaml") +
           " --to kalibr --model opencv4 --max-difference-px 1");
  const Json foreign = diff("chain.yaml");
  EXPECT_TRUE(foreign["pairs"][0]["in_sigmas"].is_number());
  const Json neither = diff("chain.yaml", "chain.yaml");
  EXPECT_TRUE(neither["verdict"].is_null());
  EXPECT_TRUE(neither["pairs"][0]["translation_sigma_m"].is_null());
  EXPECT_HAS(run("diff " + path("chain.yaml") + " " + path("chain.yaml")).out, "not known");

  for (const auto& [b, message] :
       {std::pair(path("a.yaml") + ":left", ": must be a rig as "),
        {path("models"), ": has no place of the camera left in a rig"}}) {
    if (b == path("models")) {
      spill(root() / "bare.yaml", replaced_all(replaced_all(text, "camera_from_rig", "was"),
                                               "joint_covariance", "joint"));
      ASSERT_EQ(run("convert " + path("bare.yaml") + " " + b + " --to mrcal").exit_code, 0);
    }
    const Outcome outcome = run("diff " + path("a.yaml") + " " + b);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_HAS(outcome.err, message);
  }
}

TEST_F(CliRig, ThePageHasTheNumbersOfTheTerminal) {
  render("rig", scene_of(kPlace));
  const Outcome out =
      run("rig " + path("rig") + " --out " + path("rig.yaml") + " --report " + path("rig.html"));
  ASSERT_EQ(out.exit_code, 0) << out.err << out.out;
  const Json answer = Json::parse(run("rig " + path("rig") + " --json").out);
  const std::string terminal = unwrapped(out.out);
  const Json page = data_of_page(root() / "rig.html");
  EXPECT_EQ(page["kind"], "rig");
  EXPECT_EQ(page["verdict"]["level"], "ok");
  const Json& pair = page["pairs"][0];
  std::vector<Json> texts = {page["verdict"]["sentence"], page["next"], pair["baseline"]};
  for (const Json& depth : pair["depths"]) texts.push_back(depth["text"]);
  for (const Json& text : page["cameras"][1]["place"]) texts.push_back(text);
  EXPECT_EQ(texts.size(), 3 + 4 + 6U);
  for (const Json& text : texts) EXPECT_HAS(terminal, text.get<std::string>());
  for (const Json& camera : page["cameras"]) {
    std::string row;
    for (const char* const key : {"name", "model"}) row += camera[key].get<std::string>() + " ";
    row += camera["num_views"].dump() + " " + camera["num_corners"].dump();
    for (const char* const key : {"rms_px", "excess"}) row += " " + camera[key].get<std::string>();
    EXPECT_HAS(terminal, row);
    EXPECT_EQ(camera["corners"]["u"].size(), camera["corners"]["rejected"].size());
  }
  const std::string picture = page["rectified"]["uri"];
  EXPECT_TRUE(picture.starts_with("data:image/jpeg;base64,/9j/")) << picture.substr(0, 40);
  EXPECT_EQ(page["rectified"]["b"], 1);
  ASSERT_EQ(page["instants"].size(), 12U);
  for (const Json& instant : page["instants"]) EXPECT_EQ(instant["state"], "used");
  EXPECT_FALSE(page["cameras"][0].contains("centre_axes_m"));  // the reference
  EXPECT_EQ(page["cameras"][1]["centre_axes_m"].size(), 3U);

  // The ellipsoid extends along the baseline, whose length is the least certain, by its error.
  double along = 0;
  for (const Json& axis : page["cameras"][1]["centre_axes_m"])
    along = std::hypot(along, axis[0].get<double>());
  EXPECT_NEAR(along, answer["pairs"][0]["sigma_baseline_m"].get<double>(), 0.1 * along);

  // The page of its file has the same lenses, places and depths, and says what it cannot show.
  ASSERT_EQ(run("report " + path("rig.yaml") + " --out " + path("file.html")).exit_code, 0);
  const Json file = data_of_page(root() / "file.html");
  EXPECT_EQ(file["pairs"][0]["baseline"], pair["baseline"]);
  EXPECT_EQ(file["pairs"][0]["depths"], pair["depths"]);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(file["cameras"][c]["parameters"], page["cameras"][c]["parameters"]);
    for (const char* const key : {"place", "centre_axes_m"})
      EXPECT_EQ(file["cameras"][c].value(key, Json()), page["cameras"][c].value(key, Json()));
  }
  EXPECT_HAS(file["notes"].dump(), "no instants");
  expect_bad_input(
      "report " + path("rig.yaml") + " --dataset " + path("rig") + " --out " + path("no.html"),
      {"is a rig", "rig.yaml:left"});
  EXPECT_FALSE(fs::exists(root() / "no.html"));
}

TEST_F(CliRig, APoseNeedsTheRigOfItsCameras) {
  render("rig", scene_of(kPlace, "6"));
  spill(root() / "chain.yaml",
        "cam0: {camera_model: pinhole, distortion_model: none, intrinsics: [400, 400, 239.5, "
        "179.5], distortion_coeffs: [], resolution: [480, 360]}\n");
  const std::string pose = "pose " + path("rig");
  expect_bad_input(pose + " --rig " + path("chain.yaml"), {"has no camera left, only cam0"});
  std::string two = slurp(root() / "chain.yaml");
  two += replaced_all(two, "cam0:", "cam1:");
  two.insert(two.size() - 2,
             ", T_cn_cnm1: [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]");
  spill(root() / "two.yaml", two);
  for (const std::string command : {"pose --rig ", "check --camera "})
    expect_bad_input(command + path("two.yaml") + " --target " + path("rig/target.yaml") + " " +
                         path("rig/left/images"),
                     {"two.yaml: has the cameras cam0, cam1: give a folder (or film) of each"});
  expect_bad_input(pose + " --rig a.yaml --camera b.yaml", {"--camera, --rig, --unknown-focal"});
  expect_bad_input(pose + " --camera a.yaml --pair index", {"--pair: needs --rig"});
  expect_bad_input(pose + " --rig a.yaml --draw out", {"--view, --draw: not with --rig"});
  expect_bad_input(pose + " --rig a.yaml --target a.yaml --target b.yaml",
                   {"--target: takes one value only"});
}

TEST_F(CliRig, ADataSetOfARigAndLensesThatAreKnown) {
  render("rig", scene_of(kPlace));
  for (const std::string name : {"left", "right"})
    good_run("calibrate " + path("rig/" + name) + " --out " + path(name + ".yaml"));
  const Outcome out =
      run("rig " + path("rig") + " --cameras fixed --camera left=" + path("left.yaml") +
          " --camera right=" + path("right.yaml"));
  EXPECT_EQ(out.exit_code, 0) << out.err << out.out;
  EXPECT_HAS(out.out, "right from left");
  EXPECT_HAS(out.out, "\nnext: show the board to left and right at the same time, ");
  const Outcome swapped =
      run("rig " + path("rig") + " --cameras fixed --camera left=" + path("right.yaml") +
          " --camera right=" + path("left.yaml"));
  EXPECT_EQ(swapped.exit_code, 3) << swapped.err << swapped.out;
  EXPECT_HAS(swapped.out, "NO ANSWER: the pictures of left have the image size");
  const Outcome missing =
      run("rig " + path("rig") + " --cameras fixed --camera left=" + path("left.yaml"));
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_HAS(missing.err, "--camera right=FILE");
}

TEST_F(CliRig, TheFoldersOfPicturesMayHaveAnyName) {
  render("rig", scene_of(kPlace));
  const fs::path folder = root() / "any";
  fs::create_directory(folder);
  fs::copy(root() / "rig/target.yaml", folder / "target.yaml");
  fs::copy(root() / "rig/left/images", folder / "a");
  fs::copy(root() / "rig/right/images", folder / "b");
  spill(
      folder / "dataset.yaml",
      "target: target.yaml\nrig: {cameras: [{name: left, images: a}, {name: right, images: b}]}\n");
  const Outcome out = run("rig " + folder.string());
  EXPECT_EQ(out.exit_code, 0) << out.err << out.out;
}

TEST_F(CliRig, BadInputIsOneLine) {
  render("rig", scene_of(kPlace));
  const std::string left = path("rig/left/images"), right = path("rig/right/images");
  const std::string target = " --target " + path("rig/target.yaml") + " --out " + path("no.yaml");
  const auto refused = [&](const std::string& command, const std::string& says) {
    const Outcome out = run("rig " + command);
    EXPECT_EQ(out.exit_code, 2) << command << out.out;
    EXPECT_HAS(out.err, says);
    EXPECT_FALSE(fs::exists(root() / "no.yaml"));
  };
  refused(left + " " + left + target, "is given twice");
  refused(left + target, "two cameras or more");
  fs::copy(root() / "rig/left/images", root() / "again");
  refused(left + " " + path("again") + target, "are the same picture");
  refused(left + " " + right + target + " --pair time:0", "time:5ms");
  refused(left + " " + right + target + " --pair time:5ms", "times of its pictures");
  refused(left + " " + right + target + " --model middle=f", "left, right");
  refused(left + " " + right + target + " --report " + path("rig.txt"), "must end in .html");
  refused(left + " " + right + target + " --report " + path("rig/target.yaml"), "target.yaml");
}

TEST_F(CliRig, NoInputIsReplaced) {
  render("rig", scene_of(kPlace, "6"));
  const std::string folders = "rig " + path("rig/left") + " " + path("rig/right");
  const std::string pictures = "rig " + path("rig/left/images") + " " + path("rig/right/images") +
                               " --target " + path("rig/target.yaml");
  for (const std::string name : {"left", "right"}) {
    fs::copy(root() / "rig" / name / "observations_exact.csv", root() / (name + "-corners"));
    spill(root() / (name + ".yaml"),
          "image_width: 480\nimage_height: 360\nmodel: pinhole\ncamera_matrix: {rows: 3, cols: 3, "
          "data: [400, 0, 240, 0, 400, 180, 0, 0, 1]}\n");
  }
  spill(root() / "pairs", "left,right\n000.png,000.png\n");
  const auto refused = [&](const std::string& command, const std::string& file) {
    const std::map<std::string, std::string> before = bytes_of(root());
    expect_bad_input(command + " --out " + path(file),
                     {file + ": is an input, which would be replaced"});
    EXPECT_EQ(bytes_of(root()).at(file), before.at(file)) << command;
  };
  for (const char* const file : {"rig/dataset.yaml", "rig/target.yaml", "rig/right/truth.yaml"})
    refused("rig " + path("rig"), file);
  refused(pictures, "rig/target.yaml");
  refused(folders, "rig/right/dataset.yaml");
  refused(folders + " --observations " + path("left-corners") + "," + path("right-corners"),
          "right-corners");
  refused(pictures + " --pair " + path("pairs"), "pairs");
  refused(pictures + " --cameras start --camera left=" + path("left.yaml") +
              " --camera right=" + path("right.yaml"),
          "right.yaml");
}

TEST_F(CliRig, NoCommonInstantIsNoAnswer) {
  render("rig", scene_of(kPlace));
  fs::create_directory(root() / "a");
  fs::create_directory(root() / "b");
  for (int i = 0; i < 12; ++i) {
    const std::string name = (i < 10 ? "00" : "0") + std::to_string(i) + ".png";
    if (i % 2 == 0) fs::copy(root() / "rig/left/images" / name, root() / "a" / name);
    if (i % 2 == 1 || i == 0) fs::copy(root() / "rig/right/images" / name, root() / "b" / name);
  }
  const std::string command = "rig " + path("a") + " " + path("b") + " --target " +
                              path("rig/target.yaml") + " --out " + path("no.yaml");
  const Outcome single = good_run(command);
  EXPECT_HAS(single.out, "nothing tests the answer");
  fs::remove(root() / "no.yaml");
  fs::remove(root() / "b/000.png");
  spill(root() / "pairs.csv", "a,b\n000.png,\n,001.png\n002.png,\n");
  const Outcome none =
      run(command + " --pair " + path("pairs.csv") + " --report " + path("none.html"));
  EXPECT_EQ(none.exit_code, 3) << none.err;
  const Json page = data_of_page(root() / "none.html");
  EXPECT_EQ(page["verdict"]["level"], "no_answer");
  EXPECT_EQ(page["instants"].size(), 3U);
  EXPECT_TRUE(page["formats"].empty());
  EXPECT_HAS(none.out, "no instant connects a with b");
  EXPECT_FALSE(fs::exists(root() / "no.yaml"));
}

}  // namespace
}  // namespace tagcal::tools
