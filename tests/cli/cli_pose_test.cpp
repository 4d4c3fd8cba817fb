// tagcal pose, from outside: numbers against the truth, JSON, exit codes.
#include <fmt/format.h>

#include <numbers>

#include "cli_pose_fixture.hpp"
#include "job/terminal.hpp"
#include "png_colours.hpp"
#include "tagcal/geometry/viewpoint.hpp"
#include "tagcal/io/target_file.hpp"

namespace tagcal::tools {
namespace {

TEST_F(PoseCli, OfRenderedPicturesIsTheTruthWithinItsSigmas) {
  const Json views = views_of(set() + known());
  const Truth t = truth();
  ASSERT_EQ(views.size(), t.camera_from_world.size());
  double sum = 0;
  for (const Json& view : views) {
    EXPECT_EQ(view["status"], "ok");
    EXPECT_GE(view["num_inliers"], 12);
    const Pose& expected = t.camera_from_world.at(view["image"]);
    sum += normalised_error(view, expected);
    EXPECT_LT(angle_between_rad(pose_of(view["camera_from_board"]), expected), 1e-3);
    EXPECT_LT(distance_between_m(pose_of(view["camera_from_board"]), expected), 5e-4);
  }
  EXPECT_LT(sum / (6 * static_cast<double>(views.size())), 2);
}

TEST_F(PoseCli, PicturesWithATargetGiveWhatTheDataSetGives) {
  const std::string target = " --target " + path("set/target.yaml") + " ";
  const Outcome folder = run("pose " + set() + known() + " --json");
  const Outcome pictures =
      good_run("pose" + target + path("set/images") + "/*.png" + known() + " --json");
  EXPECT_EQ(folder.out, pictures.out);
  const Outcome one = run("pose" + target + path("set/images/002.png") + known() + " --json");
  const Outcome chosen = run("pose " + set() + known() + " --json --view 002.png --threads 1");
  EXPECT_EQ(one.out, chosen.out);
  EXPECT_EQ(run("pose --view 002.png " + set() + known() + " --json --threads 1").out, one.out);
  EXPECT_EQ(Json::parse(one.out)["views"][0], Json::parse(folder.out)["views"][2]);
}

TEST_F(PoseCli, ExactCornersGiveTheTruth) {
  const Truth t = truth();
  for (const Json& view : views_of(set() + exact() + known() + " --sigma-px 0.3")) {
    const Pose& expected = t.camera_from_world.at(view["image"]);
    EXPECT_LT(angle_between_rad(pose_of(view["camera_from_board"]), expected), 1e-7);
    EXPECT_LT(distance_between_m(pose_of(view["camera_from_board"]), expected), 1e-7);
    EXPECT_EQ(view["sigma_px"], 0.3);
    EXPECT_LT(view["rms_px"], 1e-6);
    EXPECT_TRUE(view["outliers"].empty());
    EXPECT_EQ(view["num_inliers"], view["num_corners"]);
    EXPECT_EQ(view["alternative"], nullptr);
    EXPECT_EQ(view["focal_px"], nullptr);
    EXPECT_EQ(view["probability"], 1);
  }
}

TEST_F(PoseCli, TheJsonHasItsKeysInTheirOrder) {
  const Outcome outcome = good_run("pose " + set() + exact() + known() + " --view 001.png --json");
  const auto json = nlohmann::ordered_json::parse(outcome.out);
  ASSERT_EQ(json.size(), 1u);
  ASSERT_EQ(json["views"].size(), 1u);
  std::vector<std::string> keys;
  for (const auto& [key, value] : json["views"][0].items()) keys.push_back(key);
  EXPECT_EQ(fmt::format("{}", fmt::join(keys, " ")),
            "image time_s status camera_from_board covariance noise_covariance camera_in_target "
            "focal_px sigma_focal_px prior_focal_px rms_px num_inliers num_corners outliers "
            "probability alternative weak_perspective sigma_px findings warnings");
  const Eigen::MatrixXd covariance = matrix_of(json["views"][0]["covariance"]);
  EXPECT_EQ(covariance.rows(), 6);
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(covariance).info(), Eigen::Success);
}

// The camera's place and angles and their standard deviations are those of the pose and its
// covariance, by difference quotients.
TEST_F(PoseCli, WhereTheCameraIsFollowsFromThePose) {
  constexpr double kDegree = std::numbers::pi / 180, kStep = 1e-6;
  const auto place_of = [&](const Pose& pose) {
    const RollPitchYaw angles = camera_angles(pose);
    Vector6d place;
    place << pose.inverse().translation(), angles.yaw_rad / kDegree, -angles.pitch_rad / kDegree,
        angles.roll_rad / kDegree;
    return place;
  };
  const Json views = views_of(set() + exact() + known() + " --sigma-px 0.3");
  ASSERT_EQ(views.size(), 6u);
  for (const Json& view : views) {
    const Pose pose = pose_of(view["camera_from_board"]);
    Matrix6 by_step;
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = kStep * Vector6d::Unit(k);
      by_step.col(k) =
          (place_of(retract(pose, step)) - place_of(retract(pose, -step))) / (2 * kStep);
    }
    const Vector6d place = place_of(pose);
    const Eigen::MatrixXd covariance =
        by_step * matrix_of(view["covariance"]) * by_step.transpose();
    const Json& camera = view["camera_in_target"];
    const std::string angles[] = {"azimuth_deg", "elevation_deg", "roll_deg"};
    for (int k = 0; k < 3; ++k) {
      const double sigma_m = std::sqrt(covariance(k, k));
      const double sigma_deg = std::sqrt(covariance(3 + k, 3 + k));
      EXPECT_NEAR(camera["position_m"][k].get<double>(), place[k], 1e-9);
      EXPECT_NEAR(camera["sigma_position_m"][k].get<double>(), sigma_m, 1e-3 * sigma_m);
      EXPECT_NEAR(camera[angles[k]].get<double>(), place[3 + k], 1e-6);
      EXPECT_NEAR(camera["sigma_" + angles[k]].get<double>(), sigma_deg, 1e-3 * sigma_deg)
          << angles[k];
    }
  }
}

// A board has its own frame; this one is not at the world's origin.
TEST_F(PoseCli, OneBoardIsItsOwnFrame) {
  const std::string folder = tag_set(false);
  const Truth t = read_truth(folder + "/truth.yaml");
  const Json views =
      views_of(folder + " --observations " + folder +
               "/observations_exact.csv --sigma-px 0.1 --camera " + path("near-tag-camera.yaml"));
  ASSERT_EQ(views.size(), 2u);
  for (const Json& view : views) {
    const Pose expected =
        t.camera_from_world.at(view["image"]) * Pose(Eigen::Quaterniond::Identity(), {1, 2, 0});
    EXPECT_LT(distance_between_m(pose_of(view["camera_from_board"]), expected), 1e-7);
    EXPECT_EQ(view["num_corners"], 4);
  }
}

TEST_F(PoseCli, SeveralBoardsHaveTheWorldsFrame) {
  const fs::path folder = exact_set("two-boards");
  spill(folder / "wall.yaml", "target_type: tags\ntags: [{id: 90, size: 0.1}]\n");
  spill(folder / "dataset.yaml",
        "image_size: [640, 400]\nobservations: observations_exact.csv\ntarget:\n"
        "  - {file: target.yaml, world_from_board: {translation_m: [0.5, 0, 2]}}\n"
        "  - {file: wall.yaml, world_from_board: {translation_m: [0, 1, 1]}}\n");
  const Pose board_from_world(Eigen::Quaterniond::Identity(), {-0.5, 0, -2});
  const Truth t = truth();
  for (const Json& view : views_of(folder.string() + known() + " --sigma-px 0.1")) {
    const Pose expected = t.camera_from_world.at(view["image"]) * board_from_world;
    EXPECT_LT(distance_between_m(pose_of(view["camera_from_board"]), expected), 1e-7);
  }
}

TEST_F(PoseCli, AFarTagHasTwoPosesWithOdds) {
  const std::string folder = tag_set(true);
  const std::string arguments = folder + " --observations " + folder +
                                "/observations_exact.csv --sigma-px 0.8 --camera " +
                                path("far-tag-camera.yaml");
  const Truth t = read_truth(folder + "/truth.yaml");
  for (const Json& view : views_of(arguments)) {
    EXPECT_EQ(view["status"], "ambiguous");
    const Json& other = view["alternative"];
    ASSERT_TRUE(other.is_object());
    EXPECT_NEAR(view["probability"].get<double>() + other["probability"].get<double>(), 1, 1e-12);
    EXPECT_GE(view["probability"], other["probability"]);
    EXPECT_GT(other["rms_px"], view["rms_px"]);
    EXPECT_EQ(matrix_of(other["covariance"]).rows(), 6);
    const Pose a = pose_of(view["camera_from_board"]), b = pose_of(other["camera_from_board"]);
    EXPECT_GT(angle_between_rad(a, b), 0.2);
    const Pose expected =
        t.camera_from_world.at(view["image"]) * Pose(Eigen::Quaterniond::Identity(), {1, 2, 0});
    EXPECT_LT(angle_between_rad(a, expected), 1e-6);
  }
  const std::string text = run("pose " + arguments).out;
  EXPECT_HAS(text, "000.png: AMBIGUOUS: two poses fit, ");
  EXPECT_HAS(text, "likelier pose with probability 0.");
  EXPECT_HAS(text, "other pose with probability 0.");
}

TEST_F(PoseCli, TheFocalLengthIsFoundWhereTheViewShowsIt) {
  const std::string folder = tag_set(false);
  const Truth t = read_truth(folder + "/truth.yaml");
  for (const Json& view : views_of(folder + " --unknown-focal --sigma-px 0.05")) {
    EXPECT_EQ(view["status"], "ok");
    const double sigma = view["sigma_focal_px"];
    EXPECT_GT(sigma, 0);
    EXPECT_LT(sigma, 60);
    EXPECT_NEAR(view["focal_px"].get<double>(), 600, 4 * sigma);
    EXPECT_EQ(view["prior_focal_px"], nullptr);
    EXPECT_EQ(view["weak_perspective"], nullptr);
    const Pose expected =
        t.camera_from_world.at(view["image"]) * Pose(Eigen::Quaterniond::Identity(), {1, 2, 0});
    EXPECT_LT(normalised_error(view, expected), 40);
  }
}

// The residuals of a view through a distorted lens may look like noise: its corners' covariances
// show that they are not.
TEST_F(PoseCli, ALensThatIsNoPinholeIsWarnedOf) {
  int answers = 0;
  for (const std::string lens : {"pinhole", "radial1"}) {
    const bool is_pinhole = lens == "pinhole";
    spill(
        root() / "board.yaml",
        "camera: {image_size: [640, 480], f: 520, model: " + lens +
            (is_pinhole ? "" : ", distortion: [-0.3]") +
            "}\n"
            "boards:\n"
            "  - target: {target_type: checkerboard, targetCols: 9, targetRows: 6, "
            "rowSpacingMeters: 0.03, colSpacingMeters: 0.03}\n"
            "    world_from_board: {translation_m: [-0.12, -0.075, 0]}\n"
            "path: {type: dome, min_distance_m: 0.4, max_distance_m: 0.6, min_elevation_deg: 35}\n"
            "views: 12\n"
            "sensor: {blur_px: 0.7, noise_levels: 2}\n");
    ASSERT_EQ(run("render " + path("board.yaml") + " --out " + path(lens)).exit_code, 0);
    const Json all = Json::parse(run("pose " + path(lens) + " --unknown-focal --json").out);
    for (const Json& view : all["views"]) {
      if (view["focal_px"].is_null()) continue;
      answers += !is_pinhole;
      const bool is_warned = std::ranges::any_of(view["findings"], [](const Json& finding) {
        return finding["sentence"].get<std::string>().find("the lens is no pinhole") !=
               std::string::npos;
      });
      EXPECT_EQ(is_warned, !is_pinhole) << view["image"];
    }
  }
  EXPECT_GT(answers, 0);
}

TEST_F(PoseCli, WhereItDoesNotTheFocalLengthIsRefused) {
  const std::string folder = tag_set(true);
  const std::string arguments = folder + " --unknown-focal --sigma-px 0.5";
  for (const Json& view : views_of(arguments, 3)) {
    EXPECT_EQ(view["status"], "focal_not_observable");
    for (const char* key : {"camera_from_board", "covariance", "focal_px", "sigma_focal_px",
                            "prior_focal_px", "rms_px", "num_inliers", "probability"})
      EXPECT_TRUE(view[key].is_null()) << key;
    ASSERT_GE(view["weak_perspective"].size(), 1u);
    const Json& weak = view["weak_perspective"][0];
    EXPECT_EQ(weak["rotation"].size(), 4u);
    EXPECT_EQ(weak["translation_m"].size(), 2u);
    EXPECT_NEAR(weak["scale_px_per_m"], 600 / 1.8, 30);
    EXPECT_LT(weak["rms_px"], 1);
  }
  const Truth t = read_truth(folder + "/truth.yaml");
  for (const Json& view : views_of(arguments + " --prior-focal 600", 3)) {
    EXPECT_EQ(view["status"], "focal_not_observable");
    EXPECT_EQ(view["prior_focal_px"], 600);
    EXPECT_TRUE(view["focal_px"].is_null());
    const Pose expected =
        t.camera_from_world.at(view["image"]) * Pose(Eigen::Quaterniond::Identity(), {1, 2, 0});
    EXPECT_LT(normalised_error(view, expected), 40);
  }
  const std::string text = run("pose " + arguments + " --prior-focal 600").out;
  EXPECT_HAS(text, "not observable; the pose is for 600 px");
}

TEST_F(PoseCli, CornersInWrongPlacesAreNamed) {
  const std::vector<View> views = read_observations(
      root() / "set/observations_exact.csv", {{read_target(root() / "set/target.yaml"), Pose()}});
  std::vector<View> one = {views[1]};
  const int tag = one[0].observations[4].id.tag_id;
  for (Observation& seen : one[0].observations)
    if (seen.id.tag_id == tag) seen.pixel += Eigen::Vector2d(40, -25);
  spill(root() / "wrong.csv", observations_csv(one));
  const std::string arguments =
      set() + known() + " --sigma-px 0.2 --observations " + path("wrong.csv");
  const Json view = views_of(arguments).at(0);
  EXPECT_EQ(view["status"], "ok");
  EXPECT_EQ(view["num_inliers"].get<int>() + 4, view["num_corners"].get<int>());
  ASSERT_EQ(view["outliers"].size(), 4u);
  for (int corner = 0; corner < 4; ++corner)
    EXPECT_EQ(view["outliers"][corner], Json({{"tag_id", tag}, {"corner", corner}}));
  EXPECT_LT(distance_between_m(pose_of(view["camera_from_board"]),
                               truth().camera_from_world.at(view["image"])),
            1e-6);
  const std::string text = run("pose " + arguments + " --draw " + path("wrong")).out;
  const std::string last = " " + std::to_string(tag) + ":3  tag:corner\n";
  EXPECT_HAS(text, last);
  const auto colours = png_colours(root() / "wrong" / "001-pose.png");
  EXPECT_GT(std::count(colours.begin(), colours.end(), Rgb{255, 32, 32}), 20);  // crossed out
}

TEST_F(PoseCli, AViewWithoutTheTargetIsNoReasonToStop) {
  spill(root() / "black.pgm", "P5 640 400 255\n" + std::string(640 * 400, '\0'));
  const std::string target = "--target " + path("set/target.yaml") + " " + path("black.pgm");
  const Json views = views_of(target + " " + path("set/images/000.png") + known());
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views[0]["status"], "degenerate");
  EXPECT_EQ(views[0]["num_corners"], 0);
  EXPECT_TRUE(views[0]["camera_from_board"].is_null());
  EXPECT_EQ(views[0]["findings"][0]["code"], "target_unseen");
  EXPECT_EQ(views[0]["warnings"][0], "no corner of the target is seen");
  EXPECT_EQ(views[1]["status"], "ok");
  const Outcome none = run("pose " + target + known() + " --draw " + path("no-drawings"));
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_HAS(none.out, "NO ANSWER: no corner of the target is seen");
  EXPECT_FALSE(fs::exists(path("no-drawings")));
}

TEST_F(PoseCli, NoiseComesFromTheCornersUnlessItIsStated) {
  std::string csv = slurp(root() / "set/observations_exact.csv");
  csv = replaced(csv, "y_px\n", "y_px,sxx_px2,sxy_px2,syy_px2\n");
  for (std::size_t at = csv.find('\n') + 1; (at = csv.find('\n', at)) != std::string::npos;) {
    csv.insert(at, ",0.04,0.01,0.09");
    at += 16;
  }
  spill(root() / "noisy.csv", csv);
  const std::string arguments = set() + known() + " --observations " + path("noisy.csv");
  for (const Json& view : views_of(arguments + " --camera-error-px 0.1"))
    EXPECT_TRUE(view["sigma_px"].is_null());
  EXPECT_HAS(run("pose " + arguments + " --camera-error-px 0.1 --verbose").out,
             "each corner's own covariance");
  // The error of lens and target is unknown: the covariances of the corners alone are too small.
  for (const Json& view : views_of(arguments)) EXPECT_TRUE(view["sigma_px"].is_number());
  for (const Json& view : views_of(arguments + " --sigma-px 0.7")) EXPECT_EQ(view["sigma_px"], 0.7);
}

// Corners that are moved by 1 px to and fro.
TEST_F(PoseCli, ARaisedNoiseIsTheSameNumberEverywhere) {
  std::string csv = slurp(root() / "set/observations_exact.csv");
  std::size_t line = csv.find('\n') + 1;
  for (int i = 0; line < csv.size(); ++i) {
    const std::size_t end = csv.find('\n', line), comma = csv.rfind(',', end) + 1;
    const double moved = std::stod(csv.substr(comma, end - comma)) + (i % 2 == 0 ? 1 : -1);
    csv.replace(comma, end - comma, std::to_string(moved));
    line = csv.find('\n', line) + 1;
  }
  spill(root() / "moved.csv", csv);
  const std::string arguments =
      set() + known() + " --observations " + path("moved.csv") + " --sigma-px 0.3";
  const std::string text = run("pose " + arguments + " --verbose").out;
  for (const Json& view : views_of(arguments)) {
    ASSERT_EQ(view["findings"][0]["code"], "noise_understated");
    const double sigma_px = view["sigma_px"];
    EXPECT_NEAR(sigma_px, std::sqrt(0.5), 0.15);
    const std::string number = two_digits(sigma_px) + " px";
    EXPECT_HAS(view["warnings"][0].get<std::string>(), number);
    EXPECT_HAS(text, "noise      " + number + " per coordinate");
  }
}

TEST_F(PoseCli, BadInputIsNamedAndNothingIsWritten) {
  const std::string camera = known();
  const std::string wide = camera_file(800);
  spill(root() / "a-file", "");
  spill(root() / "cut.png", slurp(root() / "set/images/000.png").substr(0, 3000));
  tag_set(false);
  const auto before = names();
  const std::string draw = " --draw " + path("never");
  expect_bad_input("pose " + set() + draw, {"--camera", "--unknown-focal", "one of them"});
  expect_bad_input("pose " + set() + camera + " --unknown-focal" + draw,
                   {"--camera", "--unknown-focal", "only one"});
  expect_bad_input("pose " + set() + camera + " --prior-focal 500",
                   {"--prior-focal", "--unknown-focal"});
  expect_bad_input("pose " + set() + " --unknown-focal --prior-focal -1",
                   {"--prior-focal", "> 0", "-1"});
  expect_bad_input("pose " + set() + camera + " --sigma-px 0", {"--sigma-px", "> 0", "0"});
  expect_bad_input("pose " + set() + camera + " --sigma 1", {"--sigma", "unknown option"});
  expect_bad_input("pose " + set() + " --camera " + path("none.yaml") + draw, {"none.yaml"});
  expect_bad_input("pose " + set() + " --camera " + wide + draw,
                   {"camera-800.yaml", "640x400", "800x400"});
  expect_bad_input("pose " + path("nowhere") + camera + draw, {"nowhere"});
  expect_bad_input("pose" + camera, {"needs DATASET|IMAGE"});
  expect_bad_input("pose " + set() + camera + draw + " --view 999.png", {"--view", "999.png"});
  expect_bad_input("pose " + set() + camera + " --draw " + path("a-file"), {"a-file", "folder"});
  expect_bad_input("pose " + set() + camera + " --draw " + path("a-file/below"), {"a-file/below"});
  expect_bad_input("pose --target " + path("set/target.yaml") + " " + path("set/images/000.png") +
                       " " + path("cut.png") + " --strict" + camera + draw,
                   {"cut.png"});
  EXPECT_EQ(names(), before);
}

TEST_F(PoseCli, ThePageShowsWhatTheCommandPrints) {
  const OnThePage page = on_the_page(path("page-drawings"));
  const Outcome outcome = good_run(page.arguments);
  const std::string count = "1 of 1 view with an answer\n";
  EXPECT_TRUE(outcome.err.ends_with(count)) << outcome.err;
  expect_same_text(page.text, outcome.out + count, 2e-4, 1e-3);
}

TEST_F(PoseCli, HelpHasAnExample) {
  const Outcome help = good_run("pose --help");
  for (const char* part : {"Example: tagcal pose", "--camera", "--unknown-focal", "--prior-focal",
                           "--sigma-px", "--view", "--draw", "--json", "--target"})
    EXPECT_HAS(help.out, part);
}

}  // namespace
}  // namespace tagcal::tools
