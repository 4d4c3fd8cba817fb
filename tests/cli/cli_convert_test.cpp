// tagcal convert, from outside, and files of other programs as the camera of other commands.
#include "camera_files.hpp"
#include "cli_pose_fixture.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {
namespace {

using ConvertCli = PoseCli;

TEST_F(ConvertCli, EveryCameraOptionTakesEveryFormat) {
  const Outcome known_truth =
      good_run("pose " + set() + exact() + " --json --camera " + path("set/truth.yaml"));
  for (const std::string format :
       {"tagcal", "opencv", "kalibr", "euroc", "ros", "colmap", "mrcal", "nerfstudio", "basalt"}) {
    const std::string out = path("camera-" + format);
    const Outcome written =
        good_run("convert " + path("set/truth.yaml") + " " + out + " --to " + format);
    EXPECT_EQ(written.out, "");
    EXPECT_HAS(written.err, "wrote " + out);
    const Json a = Json::parse(known_truth.out)["views"];
    const Json b = views_of(set() + exact() + " --camera " + out);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
      EXPECT_LT(distance_between_m(pose_of(a[i]["camera_from_board"]),
                                   pose_of(b[i]["camera_from_board"])),
                1e-9)
          << format;
    good_run("view " + set() + " --camera " + out + " --json");
    good_run("validate " + out + " --dataset " + set() + exact());
  }
  const Outcome same =
      good_run("diff " + path("camera-colmap") + " " + path("set/truth.yaml") + " --json");
  EXPECT_LT(Json::parse(same.out)["differences"][0]["max_px"], 1e-6);
}

TEST_F(ConvertCli, PosesOfPoseGoOut) {
  spill(path("poses.json"),
        run("pose " + set() + exact() + " --json --camera " + path("set/truth.yaml")).out);
  const std::string poses = " --poses " + path("poses.json");
  const Outcome tum = good_run("convert " + path("set/truth.yaml") + poses + " " + path("p.tum"));
  const std::string text = slurp(path("p.tum"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1 + 6);
  good_run("convert " + path("set/truth.yaml") + poses + " " + path("sparse") + " --to colmap");
  good_run("convert " + path("set/truth.yaml") + " " + path("sparse") + " --to colmap");
  // Points of a model, which are never written, are not lost.
  std::ofstream(path("sparse/points3D.txt")) << "1 0 0 1 255 255 255 0.5 1 0\n";
  const Outcome refused =
      run("convert " + path("set/truth.yaml") + " " + path("sparse") + " --to colmap");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_HAS(refused.err, "holds the points of a model");
  EXPECT_TRUE(fs::exists(path("sparse/images.txt")));
  EXPECT_TRUE(fs::exists(path("sparse/points3D.txt")));
}

TEST_F(ConvertCli, NotesSayWhatChanges) {
  spill(path("m.cameramodel"), kMrcal);
  const Outcome outcome = good_run("convert " + path("m.cameramodel") + " " + path("cameras.txt"));
  for (const char* const part : {"dropped: optimization_inputs", "dropped: valid_intrinsics_region",
                                 "cx and cy became 0.5 larger", "dropped: the place of the camera"})
    EXPECT_HAS(outcome.err, part);
}

TEST_F(ConvertCli, WrongFilesAndOptions) {
  spill(path("stereo.yml"), kStereoYaml);
  spill(path("basalt.json"), kBasalt);
  spill(path("corners.vnl"), "# filename x y\na.png 1 2\n");
  spill(path("splined.cameramodel"),
        replaced(kMrcal, "'LENSMODEL_OPENCV8',", "'LENSMODEL_SPLINED_STEREOGRAPHIC_order=3',"));
  const std::string truth = path("set/truth.yaml");
  expect_bad_input("convert " + path("none.yaml") + " " + path("o.xml"), {"none.yaml"});
  expect_bad_input("convert " + truth + " " + path("o.yaml"), {"o.yaml", "--to"});
  expect_bad_input("convert " + truth + " " + path("o.yaml") + " --to matlab",
                   {"matlab", "kalibr"});
  expect_bad_input("convert " + path("stereo.yml") + " " + path("o.cameramodel"),
                   {"left, right", "stereo.yml:left"});
  expect_bad_input("convert " + path("stereo.yml:left") + " " + path("o.xml"), {"--image-size"});
  expect_bad_input("convert " + path("stereo.yml:left") + " " + path("o.xml") + " --image-size 640",
                   {"--image-size", "WIDTHxHEIGHT"});
  expect_bad_input("convert " + path("stereo.yml:left") + " " + path("o.xml") +
                       " --image-size 200000x480",  // which no reader takes
                   {"--image-size", "WIDTHxHEIGHT"});
  expect_bad_input("convert " + truth + " " + path("o.xml") + " --image-size 1x1", {"640x400"});
  expect_bad_input("convert " + path("basalt.json:cam1") + " " + path("o.xml"),
                   {"double sphere", "--model"});
  expect_bad_input("convert " + path("splined.cameramodel") + " " + path("o.xml"),
                   {"LENSMODEL_SPLINED_STEREOGRAPHIC_order=3"});
  expect_bad_input("convert " + path("corners.vnl") + " " + path("o.xml"), {"--target"});
  expect_bad_input("convert " + path("corners.vnl") + " " + path("o.csv") + " --target " +
                       path("set/target.yaml"),
                   {"checkerboard"});
  for (const std::string option :
       {"--poses poses.json", "--image-size 640x480", "--crop 1,2,64x48", "--resize 64x48"})
    expect_bad_input("convert " + path("corners.vnl") + " " + path("o.csv") + " --target " +
                         path("set/target.yaml") + " " + option,
                     {option.substr(0, option.find(' ')), "--target"});
  EXPECT_FALSE(fs::exists(path("o.xml")));
  EXPECT_FALSE(fs::exists(path("o.yaml")));
  good_run("convert " + path("stereo.yml:left") + " " + path("left.xml") + " --image-size 640x480");
}

// Half of the pixels of a part of the pictures.
TEST_F(ConvertCli, CamerasOfPartsAndScaledPictures) {
  const std::string truth = path("set/truth.yaml");
  const Outcome written = good_run("convert " + truth + " " + path("part.yaml") +
                                   " --to tagcal --crop 40,20,560x360 --resize 280x180");
  const auto camera_of = [](const std::string& file) {
    return read_one_camera(file).cameras[0].calibration.camera;
  };
  const Camera whole = camera_of(truth), part = camera_of(path("part.yaml"));
  EXPECT_EQ(part.image_size, (ImageSize{280, 180}));
  const auto before = parameters(whole.lens), after = parameters(part.lens);
  EXPECT_NEAR(after[0], before[0] / 2, 1e-9);
  EXPECT_NEAR(after[2], (before[2] - 40 + 0.5) / 2 - 0.5, 1e-9);
  EXPECT_NEAR(after[3], (before[3] - 20 + 0.5) / 2 - 0.5, 1e-9);
  EXPECT_EQ(after[4], before[4]);
  EXPECT_LACKS(written.err, "--resize: ");
  good_run("calibrate " + path("set") + " --out " + path("k.yaml"));
  EXPECT_LACKS(good_run("convert " + path("k.yaml") + " " + path("k2.yaml") +
                        " --to tagcal --crop 40,20,560x360 --resize 280x180")
                   .err,
               "standard deviations");
  const CalibrationFile all = read_calibration(path("k.yaml")),
                        k = read_calibration(path("k2.yaml"));
  EXPECT_NEAR(k.sigmas[0], all.sigmas[0] / 2, 1e-9 * all.sigmas[0]);
  EXPECT_NEAR(k.claim_covariance(2, 3), all.claim_covariance(2, 3) / 4,
              1e-9 * all.claim_covariance(2, 2));
  EXPECT_NEAR(*k.camera_error_px, *all.camera_error_px / 2, 1e-9);
  const std::string convert = "convert " + truth + " " + path("o.yaml") + " --to tagcal ";
  // A scale that is equal but for the rounding of the sides, and one of another aspect ratio.
  EXPECT_LACKS(run(convert + "--resize 213x133").err, "--resize: ");
  const Outcome squeezed = good_run(convert + "--resize 320x240");
  EXPECT_HAS(squeezed.err, "--resize: 640x400 to 320x240 scales x by 0.5 and y by 0.6");
  expect_bad_input(convert + "--resize 640", {"--resize", "WIDTHxHEIGHT"});
  expect_bad_input(convert + "--crop 640x480", {"--crop", "X,Y,WIDTHxHEIGHT"});
  expect_bad_input(convert + "--crop -1,0,64x48", {"--crop: -1,0,64x48 is not inside the image"});
  expect_bad_input(convert + "--crop 0,1,640x400", {"is not inside the image of 640x400"});
  expect_bad_input(convert + "--image-size 320x200", {"640x400", "--resize"});
  spill(path("stereo2.yml"), kStereoYaml);
  expect_bad_input("convert " + path("stereo2.yml:left") + " " + path("o.yaml") +
                       " --to tagcal --resize 320x240",
                   {"--resize", "--image-size"});
  expect_bad_input("convert " + path("stereo2.yml:left") + " " + path("o.yaml") + " --to tagcal",
                   {"stereo2.yml:left: has no image size, which tagcal needs", "--image-size"});
}

TEST_F(ConvertCli, CornersOfACheckerboardCalibrate) {
  // mrcal's corners as the observations of a data set: a plane seen by a pinhole from 4 places.
  const Lens lens = pinhole(500, 500, 320, 240);
  std::string vnl = "# filename x y level\n";
  for (int view = 0; view < 6; ++view) {
    const Pose camera_from_board =
        Pose(exp_rotation({0.5 * std::cos(view), 0.5 * std::sin(view), 0}), {-0.2, 0.1, 1}) *
        Pose(exp_rotation({3.141592653589793, 0, 0}), {0, 0, 0});
    for (int row = 4; row >= 0; --row)
      for (int column = 0; column < 7; ++column) {
        const Eigen::Vector2d p =
            *project(lens, camera_from_board * Eigen::Vector3d(0.05 * column, 0.05 * row, 0));
        vnl += "p" + std::to_string(view) + ".png " + std::to_string(p.x()) + " " +
               std::to_string(p.y()) + " 0\n";
      }
  }
  spill(path("checker/corners.vnl"), vnl);
  spill(path("checker/board.yaml"),
        "target_type: checkerboard\ntargetCols: 7\ntargetRows: 5\nrowSpacingMeters: 0.05\n"
        "colSpacingMeters: 0.05\n");
  spill(path("checker/dataset.yaml"),
        "image_size: [640, 480]\ntarget: board.yaml\nobservations: corners.vnl\n");
  good_run("calibrate " + path("checker") + " --model pinhole --out " + path("k.yaml"));
  EXPECT_NEAR(std::get<Perspective>(read_calibration(path("k.yaml")).camera.lens).parameters()[0],
              500, 0.01);
  const std::string target = " --target " + path("checker/board.yaml");
  good_run("convert " + path("checker/corners.vnl") + " " + path("c.xml") + target);
  EXPECT_EQ(run("convert " + path("c.xml") + " " + path("c.vnl") + target).exit_code, 0);
  EXPECT_EQ(slurp(path("c.vnl")).size() > 100, true);
  good_run("calibrate " + path("checker") + " --model pinhole --observations " + path("c.xml"));
}

}  // namespace
}  // namespace tagcal::tools
