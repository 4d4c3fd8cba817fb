// tagcal reproject, from outside.
#include <cstring>

#include "cli_fixture.hpp"
#include "tagcal/geometry/transform.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/reproject/maps.hpp"

namespace tagcal::tools {
namespace {

constexpr const char* kCamera = R"(image_width: 640
image_height: 400
model: radial1
camera_matrix: {rows: 3, cols: 3, data: [520, 0, 317, 0, 520, 203, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0, 0, 0, 0]}
)";

constexpr const char* kWideCamera = R"(image_width: 640
image_height: 400
model: fisheye4
camera_matrix: {rows: 3, cols: 3, data: [180, 0, 319.5, 0, 180, 199.5, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 4, data: [0, 0, 0, 0]}
)";

class CliReproject : public Cli {
 protected:
  void SetUp() override {
    spill(root() / "camera.yaml", kCamera);
    spill(root() / "wide.yaml", kWideCamera);
  }

  std::string picture(const char* name = "000.png") const {
    return " " + path("set/images/") + name;
  }
  std::string with(const std::string& rest, const char* camera = "camera.yaml") const {
    return "reproject --camera " + path(camera) + picture() + " " + rest;
  }
};

TEST_F(CliReproject, UndistortsAndTheNewCameraIsRead) {
  const Outcome done =
      good_run(with("--undistort all --mask --maps --out ") + path("flat") + picture("001.png"));
  EXPECT_HAS(done.err, "2 pictures, camera.yaml (640x400 pixels, pinhole");
  const Camera camera = read_calibration(root() / "flat/camera.yaml").camera;
  EXPECT_EQ(read_image(root() / "flat/000.png").size(), camera.image_size);
  // The map is the library's, in the layout of numpy.load.
  const Camera source = read_calibration(root() / "camera.yaml").camera;
  const PixelMap map = pixel_map({source, camera, {}});
  const std::string npy = slurp(root() / "flat/map.npy");
  EXPECT_HAS(npy, "'shape': (400, 640, 2)");
  ASSERT_EQ(npy.size() % 64, 0u);
  const std::size_t header = npy.size() - 640 * 400 * 2 * sizeof(float);
  EXPECT_EQ(npy[header - 1], '\n');
  float pair[2];
  std::memcpy(pair, npy.data() + header + (123 * 640 + 45) * sizeof pair, sizeof pair);
  EXPECT_NEAR(pair[0], map.x(45, 123), 1e-4);
  EXPECT_NEAR(pair[1], map.y(45, 123), 1e-4);
  // A pixel is 255 in the mask if the map has it in the picture.
  const Image8 mask = read_image(root() / "flat/mask.png");
  for (int y = 0; y < 400; y += 3)
    for (int x = 0; x < 640; x += 3)
      ASSERT_EQ(mask(x, y) == 255, contains(source.image_size, {map.x(x, y), map.y(x, y)}));
  // The new pictures and the new camera fit together: tags are found and posed.
  const Outcome pose = good_run("pose --target " + path("set/target.yaml") + " --camera " +
                                path("flat/camera.yaml") + " " + path("flat/000.png"));
}

TEST_F(CliReproject, AnotherCameraAndBackKeepsThePicture) {
  spill(root() / "other.yaml", replaced(kCamera, "[-0.1,", "[0.05,"));
  good_run(with("--to-camera " + path("other.yaml") + " --out " + path("there")));
  const Outcome back = good_run("reproject --camera " + path("there/camera.yaml") + " " +
                                path("there/000.png") + " --to-camera " + path("camera.yaml") +
                                " --interpolation lanczos4 --out " + path("back"));
  const Image8 a = read_image(root() / "set/images/000.png"),
               b = read_image(root() / "back/000.png");
  double sum = 0;
  for (int y = 50; y < 350; ++y)
    for (int x = 80; x < 560; ++x) sum += std::abs(a(x, y) - b(x, y)) / (300.0 * 480);
  EXPECT_LT(sum, 3);
}

TEST_F(CliReproject, ShowsABoardFromAbove) {
  good_run(with("--plane --target " + path("set/target.yaml") +
                " --m-per-px 0.0005 --rectangle 0,0,0.06,0.06 --mask --out " + path("top")));
  const Image8 top = read_image(root() / "top/000.png");
  ASSERT_EQ(top.size(), (ImageSize{120, 120}));  // tag 0 alone, whose border is black
  for (int i = 8; i < 112; ++i)
    for (const int edge : {5, 114}) {
      EXPECT_LT(top(i, edge), 90) << i;
      EXPECT_LT(top(edge, i), 90) << i;
    }
  EXPECT_TRUE(fs::exists(root() / "top/000-mask.png"));
  EXPECT_HAS(slurp(root() / "top/plane.yaml"), "camera_from_plane:");

  // By the pose of the calibration's own view.
  ASSERT_EQ(run("calibrate " + path("set") + " --out " + path("fit.yaml")).exit_code, 0);
  const std::string by_view = "--plane --view 000.png --m-per-px 0.0005 ";
  const Outcome two = good_run(
      with(by_view + "--rectangle 0,0,0.06,0.06 --maps --out " + path("top2"), "fit.yaml") +
      picture("001.png"));
  EXPECT_HAS(two.err, ", map.npy, 100.0 % seen");
  EXPECT_HAS(slurp(root() / "top2/map.npy"), "'shape': (120, 120, 2)");
  const Outcome beside =
      run(with(by_view + "--rectangle 50,0,50.01,0.01 --out " + path("beside"), "fit.yaml"));
  EXPECT_HAS(beside.err, "\ntagcal: warning: the camera sees nothing of it");
  const Image8 again = read_image(root() / "top2/000.png");
  int different = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 120; ++x) different += std::abs(top(x, y) - again(x, y)) > 30;
  EXPECT_LT(different, 400);
}

TEST_F(CliReproject, AWideFisheyeBecomesAPanoramaOrSeveralPinholes) {
  expect_bad_input(with("--undistort all --out " + path("no"), "wide.yaml"),
                   {"wide.yaml: the picture reaches", "--panorama", "--pinholes"});
  EXPECT_FALSE(fs::exists(root() / "no"));
  ASSERT_EQ(run(with("--pinholes 5 --out " + path("cube"), "wide.yaml")).exit_code, 0);
  for (const char* face : {"front", "left", "right", "up", "down"}) {
    const fs::path folder = root() / "cube" / face;
    EXPECT_EQ(read_image(folder / "000.png").size(),
              read_calibration(folder / "camera.yaml").camera.image_size);
  }
  good_run(with("--panorama equirectangular --px-per-deg 2 --out " + path("round"), "wide.yaml"));
  EXPECT_HAS(slurp(root() / "round/panorama.yaml"), "panorama: equirectangular");
}

TEST_F(CliReproject, TilesAreThePartsOfTheWhole) {
  const std::string task = "--undistort 400 --rotate 5,-3,10 --interpolation lanczos4 ";
  ASSERT_EQ(run(with(task + "--out " + path("whole"))).exit_code, 0);
  ASSERT_EQ(run(with(task + "--tiles 256x256 --threads 2 --out " + path("tiles"))).exit_code, 0);
  const Image8 whole = read_image(root() / "whole/000.png");
  const Image8 tile = read_image(root() / "tiles/tile_1_2/000.png");
  ASSERT_EQ(tile.size(), (ImageSize{640 - 512, 400 - 256}));
  for (int y = 0; y < tile.height(); ++y)
    for (int x = 0; x < tile.width(); ++x)
      ASSERT_NEAR(tile(x, y), whole(512 + x, 256 + y), 1) << x << " " << y;
}

TEST_F(CliReproject, KeepsTheKindOfThePicture) {
  ImageRgb16 colour({640, 400}, {1000, 40000, 65535});
  write_png(root() / "colour.png", colour);
  good_run("reproject --camera " + path("camera.yaml") + " " + path("colour.png") +
           " --rotate 0,0,5 --border 700 --out " + path("colours"));
  const auto result = std::get<ImageRgb16>(read_picture(root() / "colours/colour.png"));
  EXPECT_EQ(result(300, 200), (Rgb16{1000, 40000, 65535}));
  EXPECT_EQ(result(639, 200), (Rgb16{700, 700, 700}));  // to the right of the picture
}

TEST_F(CliReproject, ReplacesNothingUnasked) {
  ASSERT_EQ(run(with("--undistort valid --out " + path("once"))).exit_code, 0);
  const auto before = bytes_of(root() / "once");
  expect_bad_input(with("--undistort all --out " + path("once")),
                   {"once/camera.yaml: exists", "--force"});
  EXPECT_EQ(bytes_of(root() / "once"), before);
  EXPECT_EQ(run(with("--undistort all --force --out " + path("once"))).exit_code, 0);
  EXPECT_NE(bytes_of(root() / "once"), before);
  expect_bad_input(with("--undistort all --force --out " + path("set/images")),
                   {"000.png: would be replaced"});
}

// As other commands take them.
TEST_F(CliReproject, FoldersAndPatternsAreTheirPictures) {
  const std::string task = "reproject --camera " + path("camera.yaml") + " --rotate 0,0,5 --out ";
  good_run(task + path("all") + " " + path("set/images"));
  EXPECT_EQ(bytes_of(root() / "all").size(), 7u);
  good_run(task + path("some") + " '" + path("set/images/00[12].png") + "'");
  EXPECT_EQ(bytes_of(root() / "some").size(), 3u);
  EXPECT_EQ(slurp(root() / "some/001.png"), slurp(root() / "all/001.png"));
  good_run("calibrate " + path("set") + " --out " + path("views.yaml"));
  good_run("reproject --camera " + path("views.yaml") +
           " --plane --view 000.png --m-per-px 0.001 " + "--rectangle 0,0,0.06,0.06 --mask --out " +
           path("mask"));
  EXPECT_EQ(read_image(root() / "mask/mask.png").size(), (ImageSize{60, 60}));
}

TEST_F(CliReproject, WrongArgumentsAreNamed) {
  const std::string out = "--out " + path("wrong");
  expect_bad_input(with(out), {"one of --undistort"});
  expect_bad_input(with("--undistort all --plane " + out), {"only one of them"});
  expect_bad_input(with("--undistort near " + out), {"--undistort: must be all, valid or", "near"});
  expect_bad_input(with("--undistort -3 " + out), {"--undistort"});
  expect_bad_input(with("--rotate 1,2 " + out), {"--rotate: must be 3 numbers"});
  expect_bad_input(with("--undistort all --size 10 " + out), {"--size: must be WIDTHxHEIGHT"});
  expect_bad_input(with("--undistort all --tiles 0x5 " + out), {"--tiles: must be WIDTHxHEIGHT"});
  expect_bad_input(with("--plane " + out), {"--plane: needs --m-per-px"});
  expect_bad_input(with("--plane --m-per-px 1 " + out), {"--plane: needs --target"});
  expect_bad_input(with("--plane --m-per-px 1 --view 000.png --rectangle 0,0,1,1 " + out),
                   {"has no views"});
  expect_bad_input(with("--panorama cylindrical --m-per-px 1 " + out), {"--m-per-px: belongs to"});
  expect_bad_input(with("--undistort all " + out, "set/target.yaml"), {"target.yaml"});
  expect_bad_input("reproject --camera " + path("camera.yaml") + " --undistort all " + out,
                   {"no pictures given"});
  write_png(root() / "small.png", Image8({10, 10}));
  expect_bad_input(with("--undistort all " + out) + " " + path("small.png"),
                   {"small.png: must be 640x400 pixels", "got 10x10", "--resize or --crop"});
  spill(root() / "cut.pgm", "P5\n640 400\n255\nabc");  // a whole header
  expect_bad_input(
      with("--plane --m-per-px 0.001 --target " + path("set/target.yaml") + " " + out) + " " +
          path("cut.pgm"),
      {"cut.pgm: is truncated"});
  EXPECT_FALSE(fs::exists(root() / "wrong"));
}

TEST_F(CliReproject, APictureWithoutTheTargetIsNoAnswer) {
  write_png(root() / "blank.png", Image8({640, 400}, 128));
  const Outcome none = run("reproject --camera " + path("camera.yaml") + " " + path("blank.png") +
                           " --plane --target " + path("set/target.yaml") +
                           " --m-per-px 0.001 --out " + path("none"));
  EXPECT_EQ(none.exit_code, 3) << none.err;
  EXPECT_FALSE(fs::exists(root() / "none"));
}

}  // namespace
}  // namespace tagcal::tools
