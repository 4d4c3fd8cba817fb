// Each limit of docs/reference/limits.md: what is at the limit is read, what is beyond it is
// refused.
#include "tagcal/io/text/limits.hpp"

#include <fmt/format.h>

#include <cstring>
#include <fstream>

#include "file_fixture.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/visibility/polygon.hpp"

namespace tagcal {
using namespace internal;
namespace {

std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

class Limits : public FileTest {
 protected:
  // `text_of(n)` is read for the limit n, and refused with `message` for n + 1.
  template <typename TextOf, typename Read>
  void expect_limit(std::size_t limit, const std::string& message, TextOf text_of, Read read) {
    SCOPED_TRACE(message);
    const fs::path good = write("good.yaml", text_of(limit));
    EXPECT_NO_THROW(read(good));
    const fs::path bad = write("bad.yaml", text_of(limit + 1));
    const std::string error = error_of([&] { read(bad); });
    EXPECT_TRUE(error.starts_with(bad.string() + ": ")) << error.substr(0, 300);
    EXPECT_HAS(error, message);
  }
};

TEST_F(Limits, Yaml) {
  const auto parse = [](const fs::path& file) { YamlValue::read(file); };
  expect_limit(
      limits::kMaxYamlDepth - 1, "64 levels",
      [](std::size_t n) { return "a: " + repeated("[", n) + repeated("]", n); }, parse);
  expect_limit(
      limits::kMaxYamlBytes, "16 MiB",
      [](std::size_t n) { return "a: " + std::string(n - 3, 'x'); }, parse);
  expect_limit(
      limits::kMaxYamlValues - 2, "2 million values",
      [](std::size_t n) { return "a: [" + repeated("1,", n) + "]"; }, parse);
}

// A chain of aliases is as deep as brackets are, for those that walk it.
TEST_F(Limits, AliasesNestToo) {
  const auto chain = [](std::size_t n) {
    std::string text = "a1: &a1 []\n";
    for (std::size_t i = 2; i <= n; ++i) text += fmt::format("a{}: &a{} [*a{}]\n", i, i, i - 1);
    return text;
  };
  expect_limit(limits::kMaxYamlDepth - 1, "64 levels", chain,
               [](const fs::path& file) { YamlValue::read(file); });
  EXPECT_HAS(error_of([&] { YamlValue::read(write("long.yaml", chain(400'000))); }), "64 levels");
}

TEST_F(Limits, PartsOfAllBoardsOfAFile) {
  write("board.yaml",
        "{target_type: checkerboard, targetCols: 1000, targetRows: 50, rowSpacingMeters: 1, "
        "colSpacingMeters: 1}");
  write("corners.csv", "image,tag_id,corner,x_px,y_px\n");
  const auto dataset = [](std::size_t n) {
    std::string text = "image_size: [64, 48]\nobservations: corners.csv\ntarget:\n";
    for (std::size_t i = 0; i < n; ++i)
      text += fmt::format("- {{file: board.yaml, first_id: {}}}\n", 50'000 * i);
    return text;
  };
  expect_limit(2, "target: the boards must have at most 100000 tags, corners and points in all",
               dataset, [&](const fs::path& file) {
                 fs::rename(file, folder_ / "dataset.yaml");
                 try {
                   read_dataset(folder_);
                 } catch (const Error& error) {
                   throw Error(replaced(error.what(), "dataset.yaml", file.filename().string()));
                 }
               });
}

const std::string kSmallScene =
    "camera: {image_size: [64, 48], model: f, f: 50}\nboards:\n- target: {target_type: tags, tags: "
    "[{id: 0, size: 1}]}\n";

TEST_F(Limits, Scenes) {
  const auto read = [](const fs::path& file) { read_moving_scene(file); };
  const std::string ring = "path: {type: ring, radius_m: 1}\n";
  const auto scene = [&](const std::string& more) {
    return kSmallScene + ring + "views: 1\n" + more;
  };
  expect_limit(
      limits::kMaxViews, "views: must be",
      [&](std::size_t n) { return kSmallScene + ring + fmt::format("views: {}\n", n); }, read);
  expect_limit(
      limits::kMaxSheets, "occluders: must be a list of at most 10000",
      [&](std::size_t n) {
        return scene("occluders:\n- &o {corners: [[0,0,0],[1,0,0],[0,1,0]]}\n" +
                     repeated("- *o\n", n - 1));
      },
      read);
  expect_limit(
      limits::kMaxSteps, "must be a list of at most 100",
      [&](std::size_t n) {
        return scene("frames: [{name: a}]\nmotion: [{frame: a, steps: [&s {rotate_z_deg: 1}" +
                     repeated(",*s", n - 1) + "]}]\n");
      },
      read);
  expect_limit(
      limits::kMaxValuesOfPath, "must be a list of at most 1000",
      [&](std::size_t n) {
        return kSmallScene + "path: {type: orbit, distance_m: [1" + repeated(",1", n - 1) + "]}\n";
      },
      read);
  expect_limit(
      limits::kMaxVignettingTerms, "must be a list of at most 10",
      [&](std::size_t n) {
        return scene("sensor: {vignetting: [0" + repeated(",0", n - 1) + "]}\n");
      },
      read);
}

TEST_F(Limits, SidesOfImages) {
  expect_limit(
      limits::kMaxSidePx, "must be a whole number from 1 to 100000",
      [&](std::size_t n) {
        return replaced(kSmallScene, "[64, 48]", fmt::format("[{}, 48]", n)) +
               "path: {type: ring, radius_m: 1}\nviews: 1\n";
      },
      [](const fs::path& file) { read_moving_scene(file); });
}

// Sizes that a file of so few bytes cannot have are refused before anything is allocated.
TEST_F(Limits, PixelsOfSmallFiles) {
  const auto refusal = [&](int width) {
    std::string bmp = "BM" + std::string(98, '\0');
    const std::int32_t numbers[] = {40, width, 1000, 24 << 16};
    std::memcpy(bmp.data() + 14, numbers, sizeof numbers);
    return error_of([&] { read_image_size(write("a.bmp", bmp)); });
  };
  EXPECT_HAS(refusal(4001), "4001x1000 pixels cannot be in a file of 100 bytes");
  EXPECT_HAS(refusal(4000), "is truncated");
}

TEST_F(Limits, BytesOfPictures) {
  const fs::path file = write("a.png", "\x89PNG");
  fs::resize_file(file, limits::kMaxPictureBytes + 1);  // sparse: takes no room
  EXPECT_ERROR(read_image_size(file), file.string() + ": is larger than 1 GiB");
}

// The page names each constant with its value.
TEST(LimitsPage, StatesEachLimit) {
  const std::string page = read_text(TAGCAL_SOURCE_DIR "/docs/reference/limits.md");
  const std::pair<const char*, double> all[] = {
      {"kMaxTextBytes", limits::kMaxTextBytes},
      {"kMaxYamlBytes", limits::kMaxYamlBytes},
      {"kMaxYamlDepth", limits::kMaxYamlDepth},
      {"kMaxYamlValues", limits::kMaxYamlValues},
      {"kMaxListedPoses", limits::kMaxListedPoses},
      {"kMaxSidePx", limits::kMaxSidePx},
      {"kMaxMatrixSide", limits::kMaxMatrixSide},
      {"kMaxBoards", limits::kMaxBoards},
      {"kMaxViews", limits::kMaxViews},
      {"kMaxRigCameras", limits::kMaxRigCameras},
      {"kMaxSheets", limits::kMaxSheets},
      {"kMaxFrames", limits::kMaxFrames},
      {"kMaxSteps", limits::kMaxSteps},
      {"kMaxValuesOfPath", limits::kMaxValuesOfPath},
      {"kMaxVignettingTerms", limits::kMaxVignettingTerms},
      {"kMaxPictureBytes", limits::kMaxPictureBytes},
      {"kMaxSequenceFrames", limits::kMaxSequenceFrames},
      {"kMaxBagTopics", limits::kMaxBagTopics},
      {"kMaxBagChunkBytes", limits::kMaxBagChunkBytes},
      {"kMaxBagBytesAByte", limits::kMaxBagBytesAByte},
      {"kMaxBagBytesOfFewBytes", limits::kMaxBagBytesOfFewBytes},
      {"kMaxPixels", limits::kMaxPixels},
      {"kMaxPixelsAByte", limits::kMaxPixelsAByte},
      {"kMaxPixelsOfFewBytes", limits::kMaxPixelsOfFewBytes},
      {"kMaxJpegScans", limits::kMaxJpegScans},
      {"kMaxBoardParts", kMaxBoardParts},
      {"kMaxPolygonCorners", kMaxPolygonCorners},
  };
  for (const auto& [name, value] : all)
    EXPECT_HAS(page, fmt::format("| {:.0f} | `{}` |", value, name));
  const std::string code = read_text(TAGCAL_SOURCE_DIR "/lib/tagcal/io/text/limits.hpp");
  std::size_t num_constants = 2;  // those of boards
  for (std::size_t at = 0; (at = code.find("inline constexpr", at)) != std::string::npos; ++at)
    ++num_constants;
  EXPECT_EQ(num_constants, std::size(all));
}

}  // namespace
}  // namespace tagcal
