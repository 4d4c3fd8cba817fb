// Scenes with frames, motion, and parallel cameras, from the file to the answer.
#include <nlohmann/json.hpp>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

using Json = nlohmann::json;

const std::string kGrid =
    "target: {target_type: aprilgrid, tagCols: 4, tagRows: 3, tagSize: 0.06, tagSpacing: 0.3, "
    "border_bits: 1, corner_squares: false}";
const std::string kSensor = "sensor: {blur_px: 0.6, noise_levels: 1}\n";

class CliScene : public Cli {
 protected:
  // Renders a scene; its data set has the name of the scene.
  Outcome render(const std::string& name, const std::string& scene) {
    spill(root() / (name + ".yaml"), scene);
    return run("render " + path(name + ".yaml") + " --out " + path(name));
  }
};

TEST_F(CliScene, ACameraOnAnArmIsCalibratedFromItsPictures) {
  const Outcome rendered =
      render("arm",
             "camera: {image_size: [640, 480], model: f, f: 600}\n"
             "frames:\n"
             "  - {name: shoulder, pose: {translation_m: [0.14, 0.1, 0]}}\n"
             "  - {name: hand, parent: shoulder, pose: [{translate_m: [0, 0, 0.5]}, "
             "{rotate_x_deg: 180}]}\n"
             "motion:\n"
             "  - {frame: shoulder, steps: [{rotate_y_deg: [-30, 30]}, "
             "{rotate_x_deg: [-25, 25, -25]}]}\n"
             "  - {frame: hand, steps: [{rotate_z_deg: [0, 90]}]}\n"
             "boards:\n  - {" +
                 kGrid + "}\npath: {type: frame, frame: hand}\nviews: 7\n" + kSensor);
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  const Outcome calibrated = good_run("calibrate " + path("arm") + " --model f --json");
  const Json answer = Json::parse(calibrated.out);
  EXPECT_EQ(answer["num_views"], 7);
  EXPECT_NEAR(answer["camera"]["fx"], 600, 4 * answer["sigma"]["fx"].get<double>());
  EXPECT_LT(answer["sigma"]["fx"], 6);
}

TEST_F(CliScene, ABoardThatMovesIsDrawnAndLeftOutOfTheDataSet) {
  const std::string scene =
      "camera: {image_size: [640, 480], model: f, f: 600}\n"
      "frames: [{name: cart}]\nmotion: [{frame: cart, steps: [{translate_m: [[0, 0, 0], [0.1, 0, "
      "0]]}]}]\n"
      "boards:\n  - {" +
      kGrid +
      "}\n"
      "  - {target: {target_type: tags, tags: [{id: 50, size: 0.06}]}, frame: cart, "
      "pose: {translation_m: [0.1, 0.35, 0]}}\n"
      "path: {type: look_at, eye_m: [0.1, -0.1, 0.8], target_m: [0.15, 0.15, 0]}\nviews: 2\n" +
      kSensor;
  const Outcome rendered = render("cart", scene);
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  EXPECT_HAS(rendered.err, "boards[1] moves relative to the first board");
  const std::string exact = slurp(root() / "cart/observations_exact.csv");
  EXPECT_LACKS(exact, ",50,");
  EXPECT_HAS(exact, ",3,");
  EXPECT_HAS(slurp(root() / "cart/truth.yaml"), "camera_from_board");
  // The tag is in the pictures: detected with a target of its own, it has moved.
  spill(root() / "single.yaml", "target_type: tags\ntags: [{id: 50, size: 0.06}]\n");
  const Outcome found = good_run("detect --target " + path("single.yaml") + " " +
                                 path("cart/images/000.png") + " " + path("cart/images/001.png"));
  EXPECT_EQ(std::count(found.out.begin(), found.out.end(), '\n'), 9);
}

std::string parallel_scene(const std::string& projection) {
  return "camera: {image_size: [640, 480], model: parallel, scale_px_per_m: 1200" + projection +
         "}\nboards:\n  - {" + kGrid +
         "}\n"
         "path: {type: orbit, target_m: [0.14, 0.1, 0], distance_m: 1, azimuth_deg: [0, 140], "
         "elevation_deg: [50, 75, 45]}\nviews: 6\n" +
         kSensor;
}

TEST_F(CliScene, AnOrthographicSetIsWeakAndAnObliqueOneIsRefused) {
  const Outcome rendered = render("orthographic", parallel_scene(""));
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  const Json answer = Json::parse(run("calibrate " + path("orthographic") + " --json").out);
  EXPECT_EQ(answer["model"], "weak");
  for (const Json& view : answer["views"]) EXPECT_NEAR(view["scale_px_per_m"], 1200, 3);

  ASSERT_EQ(render("cabinet", parallel_scene(", projection: cabinet")).exit_code, 0);
  expect_bad_input("calibrate " + path("cabinet"),
                   {"cabinet: truth.yaml: camera: is an oblique projection, which no model has"});
}

TEST_F(CliScene, AWindowBeforeAMovingEyeHasALensForEachView) {
  const Outcome rendered = render(
      "window",
      "camera: {image_size: [640, 480], model: window}\nboards:\n  - {" + kGrid +
          ", pose: {axis: [1, 0, 0], angle_deg: 90, translation_m: [-0.14, 0.3, -0.1]}}\n"
          "path: {type: window, lower_left_m: [-0.2, 0, -0.15], lower_right_m: [0.2, 0, "
          "-0.15], upper_left_m: [-0.2, 0, 0.15], eye_m: [[-0.2, -0.5, 0], [0.2, -0.6, 0.1]]}\n"
          "views: 3\n" +
          kSensor);
  ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  expect_bad_input("calibrate " + path("window"),
                   {"window: truth.yaml: poses: each view has its own"});
  EXPECT_EQ(run("view " + path("window.yaml") + " --view 2").exit_code, 0);
}

TEST_F(CliScene, BadHierarchiesAreOneLineAndWriteNothing) {
  const std::string scene = "camera: {image_size: [640, 480], model: f, f: 600}\nboards:\n  - {" +
                            kGrid + "}\npath: {type: orbit, distance_m: 1}\n";
  spill(root() / "cycle.yaml", scene + "frames: [{name: a, parent: b}, {name: b, parent: a}]\n");
  expect_bad_input("render " + path("cycle.yaml") + " --out " + path("cycle"),
                   {"cycle.yaml: frames: "});
  // A motion that passes through a scale of zero only in the middle of the views.
  spill(root() / "flat.yaml",
        scene +
            "views: 3\nframes: [{name: a}, {name: b, parent: a}]\n"
            "motion: [{frame: a, steps: [{scale: [[1, 1, 1], [-1, -1, -1]]}]}]\n"
            "cuboids: [{size_m: [0.1, 0.1, 0.1], frame: b}]\n");
  expect_bad_input("render " + path("flat.yaml") + " --out " + path("flat"), {"occluders[0]"});
  for (const std::string folder : {"cycle", "flat"}) EXPECT_FALSE(fs::exists(root() / folder));
}

}  // namespace
}  // namespace tagcal::tools
