// What `render` writes as exact corners and what `detect` finds in its pictures are the same where
// boards and occluders cut each other.
#include <set>
#include <tuple>

#include "cli_fixture.hpp"

namespace tagcal::tools {
namespace {

using Tag = std::pair<std::string, std::string>;  // image, id

// The number of corners of each tag in a CSV of corners.
std::map<Tag, int> corners_of_tags(const std::string& csv) {
  std::map<Tag, int> counts;
  std::istringstream rows(csv);
  std::string row, image, tag;
  std::getline(rows, row);
  while (std::getline(rows, row)) {
    std::istringstream fields(row);
    std::getline(std::getline(fields, image, ','), tag, ',');
    ++counts[{image, tag}];
  }
  return counts;
}

class CliVisibility : public Cli {
 protected:
  // Renders the scene, and expects the tags whose four corners are exact to be the detected ones.
  void expect_agreement(const std::string& name, const std::string& scene, std::size_t least) {
    spill(root() / (name + ".yaml"), scene);
    ASSERT_EQ(run("render " + path(name + ".yaml") + " --out " + path(name)).exit_code, 0);
    std::set<Tag> exact, detected;
    for (const auto& [tag, count] :
         corners_of_tags(slurp(root() / name / "observations_exact.csv")))
      if (count == 4) exact.insert(tag);
    for (const auto& [tag, count] : corners_of_tags(run("detect " + path(name)).out))
      detected.insert(tag);
    EXPECT_EQ(exact, detected);
    EXPECT_GE(exact.size(), least);
  }
};

const std::string kBoard =
    "{target_type: aprilgrid, tagCols: 6, tagRows: 6, tagSize: 0.088, tagSpacing: 0.3, "
    "border_bits: 1}";

TEST_F(CliVisibility, AnOccluderCutsThroughABoard) {
  expect_agreement("cut",
                   R"(
camera: {image_size: [640, 480], model: f, f: 600}
boards: [{target: )" + kBoard +
                       R"(, world_from_board: {translation_m: [-0.33, -0.33, 0]}}]
occluders:
  - {corners: [[-0.6, -0.6, -0.1], [0.6, -0.6, 0.1], [0.6, 0.6, 0.1], [-0.6, 0.6, -0.1]]}
path: {type: ring, centre_m: [0, 0, 1], radius_m: 0.2}
views: 4
)",
                   72);
  const std::string view = "view " + path("cut.yaml") + " --at ";
  EXPECT_HAS(run(view + "5:0").out, "not seen: hidden by occluder 0");
  EXPECT_HAS(run(view + "5:0 --json").out, "\"hidden_by\": \"occluder 0\"");
  EXPECT_HAS(run(view + "0:0 --json").out, "\"hidden_by\": null");
}

TEST_F(CliVisibility, TwoBoardsCrossLikeAnX) {
  expect_agreement("cross", R"(
camera: {image_size: [640, 480], model: f, f: 500}
boards:
  - target: )" + kBoard + R"(
    world_from_board: {rotation: [0.98006658, 0, 0.19866933, 0], translation_m: [-0.30395013, -0.33, 0.12850805]}
  - target: )" + kBoard + R"(
    first_id: 36
    world_from_board: {rotation: [0.98006658, 0, -0.19866933, 0], translation_m: [-0.30395013, -0.33, -0.12850805]}
path: {type: ring, centre_m: [0, 0, 1], radius_m: 0.02}
views: 3
)",
                   100);
}

}  // namespace
}  // namespace tagcal::tools
