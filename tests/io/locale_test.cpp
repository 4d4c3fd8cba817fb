// A program may have called setlocale and std::locale::global with a locale of decimal commas: what
// the library reads, writes and says stays the same. (The command never calls them:
// tests/same/locale_test.py.)
#include <fmt/format.h>

#include "file_fixture.hpp"
#include "german_locale.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/reproject/cameras.hpp"

namespace tagcal {
namespace {

const fs::path kData = fs::path(TAGCAL_SOURCE_DIR) / "data-synthetic";

class LocaleTest : public FileTest {
 protected:
  // What the library reads of files, calculates and writes; one text.
  std::string everything(const fs::path& out) const {
    fs::create_directories(out);
    return calibrated() + formats(out) + scenes() + messages();
  }

 private:
  static std::string calibrated() {
    const DatasetFolder desk = read_dataset(kData / "golden/desk");
    Dataset half = desk.dataset;
    half.views.resize(4);  // so that there is something to find fault with
    std::string text = observations_csv(desk.dataset.views);
    for (const Dataset& dataset : {desk.dataset, half}) {
      const Calibration c = calibrate(dataset, {});
      text += calibration_yaml(c);
      for (const Finding& finding : c.findings) text += finding.sentence + "\n";
      for (const auto& step : c.steps) text += step.sentence + "\n";
      for (const auto& direction : c.weak_directions) text += direction.sentence + "\n";
      if (const auto advised = advise(dataset, c)) text += advised->sentence + "\n";
    }
    return text;
  }

  static std::string formats(const fs::path& out) {
    CameraFile file;
    file.cameras.push_back({"front", read_calibration(calibration_file(out))});
    std::string text;
    for (const CameraFormat& format : camera_formats()) {
      const fs::path place = out / format.name;
      try {
        write_camera_file(place, file, format.name);
        text += numbers_of(read_camera_file(place));
      } catch (const Error& error) {
        const std::string message = error.what();  // without the folder
        text += message.substr(message.find_last_of('/') + 1);
      }
      for (const auto& entry : fs::recursive_directory_iterator(out))
        if (entry.is_regular_file()) text += read_text(entry.path());
    }
    return text;
  }

  static fs::path calibration_file(const fs::path& out) {
    Calibration c = calibrate(read_dataset(kData / "golden/desk").dataset, {});
    write_whole(out / "camera.yaml", calibration_yaml(c));
    return out / "camera.yaml";
  }

  static std::string numbers_of(const CameraFile& file) {
    std::string text;
    for (const FileCamera& camera : file.cameras)
      for (const double p : parameters(camera.calibration.camera.lens))
        text += fmt::format("{}\n", p);
    return text;
  }

  static std::string scenes() {
    std::string text;
    for (const char* name : {"desk", "charuco", "doorway", "fisheye_room"}) {
      const Scene scene = read_scene(kData / "scenes" / (std::string(name) + ".yaml"));
      for (const double p : parameters(scene.camera.lens)) text += fmt::format("{}\n", p);
      for (const PlacedBoard& placed : scene.boards)
        text += fmt::format("{}\n", placed.world_from_board.translation().x());
    }
    return text;
  }

  std::string messages() const {
    const Camera camera{Fisheye({420, 419, 633, 405, 0, 0, 0, 0}), {1280, 800}};
    return error_of([] { pinhole(-1.5, 1, 0, 0); }) + error_of([] {
             HeldModels({{"fx", -2.5}}, kind_of<Perspective>());
           }) +
           error_of([&] {
             pinhole_of_focal_length(camera, -0.5, {100, 100});
           }) +
           error_of([] { calibrate(Dataset(), {.tolerance_px = -0.25}); });
  }
};

TEST_F(LocaleTest, DecimalCommasChangeNothing) {
  const std::string expected = everything(folder_ / "c");
  ASSERT_GT(expected.size(), 10000U);
  std::string german;
  {
    const GermanLocale locale(folder_ / "locale");
    if (!locale.is_there()) GTEST_SKIP() << "localedef cannot make the locale de_DE.UTF-8";
    ASSERT_EQ(std::to_string(1.5), "1,500000");
    german = everything(folder_ / "de");
  }
  EXPECT_TRUE(expected == german);  // the texts are too long to be printed
}

}  // namespace
}  // namespace tagcal
