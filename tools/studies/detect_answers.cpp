// The corners that `detect` finds in a fixed collection of pictures, a row a picture, as the
// referee of the constants of detect/policy (tools/sensitivity.py, docs/trust/sensitivity.md).
// Rendered are views of random worlds (docs/trust/worlds.md) with AprilGrids, whose tags are
// fitted, or half of them again by their sides only (`edges`), and with checkerboards and ChArUco
// boards in their place, all with the worlds' lenses, light, noise and blur; and pictures without
// targets. --pictures keeps them for the next run. An input is a folder of real pictures with a
// target.yaml; the truth of its corners is a calibration of all of them by `fisheye4`.
// Columns: corners that are visible; found; of these wrong (hidden, or off by more than 1 px);
// of the others the sum of squared errors, the number with a covariance and the sum of their
// squared Mahalanobis distances, and how many of them are beyond five standard deviations.

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "checker_pictures.hpp"
#include "false_tag_pictures.hpp"
#include "studies/studies.hpp"
#include "studies/worlds/draw.hpp"
#include "studies/worlds/record.hpp"
#include "study/quantile.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
using namespace study;
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSeed = 31;
constexpr double kWrongPx = 1;

struct Picture {
  std::string group, name;
  Board board;
  Image8 image;
  ExactCorners exact;
};

Values row_of(const Picture& picture, const FoundCorners& seen) {
  double wrong = 0, claimed = 0, beyond = 0, squares = 0, distances = 0;
  for (const Observation& o : seen.view.observations) {
    const auto truth = picture.exact.find(o.id);
    if (truth == picture.exact.end() || !((o.pixel - truth->second).norm() < kWrongPx)) {
      ++wrong;
      continue;
    }
    const Eigen::Vector2d error = o.pixel - truth->second;
    squares += error.squaredNorm();
    if (!o.covariance_px2) continue;
    const double square = squared_distance(error, *o.covariance_px2);
    ++claimed;
    distances += square;
    beyond += !(square >= 0 && square <= kFiveSigma2 * kFiveSigma2);  // no covariance, if below 0
  }
  return {picture.name,
          static_cast<double>(picture.exact.size()),
          static_cast<double>(seen.view.observations.size()),
          wrong,
          squares,
          claimed,
          distances,
          beyond,
          1e-3 * seen.ms};
}

std::vector<Values> measure(const Picture& picture) {
  const Refinement by = picture.group == "edges" ? Refinement::edges : Refinement::fit;
  return {row_of(picture, corners_by_fit(picture.image, picture.board, nullptr, by))};
}

Image8 kept(const fs::path& file, const std::function<Image8()>& render) {
  if (file.empty()) return render();
  if (!fs::exists(file)) write_png(file, render());
  return read_image(file);
}

// A checkerboard, or a ChArUco board, in the place of the grid of tags.
PlacedBoard squares_for(const AprilGrid& grid, bool with_markers) {
  const double pitch = grid.tag_size * (1 + grid.tag_spacing);
  const double side = with_markers ? pitch : pitch / 2;
  const auto squares = [&](int tags) {
    return static_cast<int>((tags * pitch - grid.tag_spacing * grid.tag_size) / side);
  };
  Checkerboard board{.columns = std::max(3, squares(grid.columns) - 1),
                     .rows = std::max(3, squares(grid.rows) - 1),
                     .column_spacing = side,
                     .row_spacing = side};
  board.columns += (board.columns + board.rows + 1) % 2;  // so that it has no symmetry
  const Pose shifted(Eigen::Quaterniond::Identity(), Eigen::Vector3d(side, side, 0));
  if (!with_markers) return {make_board(board), shifted};
  return {make_board(Charuco{.square_columns = board.columns + 1,
                             .square_rows = board.rows + 1,
                             .square_size = side,
                             .marker_size = 0.73 * side,
                             .dictionary = "DICT_4X4_250"}),
          shifted};
}

// The first view of a world, of a checkerboard the first one that shows all of it. False if there
// is none.
bool draw(std::uint64_t index, const std::string& group, const fs::path& folder, Picture& picture) {
  const bool is_grid = group == "tags" || group == "edges";
  const World world =
      draw_world({kSeed, index, std::string(kPixels), is_grid ? "" : "-bend-twist"});
  Scene scene = world.scene;
  if (!is_grid)
    scene.boards = {
        squares_for(std::get<AprilGrid>(scene.boards[0].board.pattern), group == "charuco")};
  picture = {group, std::to_string(index), scene.boards[0].board, {}, {}};
  if (is_grid) scene = real_scene(world);
  const auto& poses = std::get<ExplicitPath>(scene.path).camera_from_world;
  const std::size_t all = group == "checkers" ? target_points(picture.board).size() : 8;
  const auto pose = std::ranges::find_if(poses, [&](const Pose& p) {
    picture.exact = corners_of(visible_corners(scene, p));
    return picture.exact.size() >= all;
  });
  if (pose == poses.end()) return false;
  const std::string name = (is_grid ? "tags" : group) + picture.name + ".png";
  picture.image = kept(folder.empty() ? folder : folder / name, [&] {
    TagFamilies families;
    if (const auto kind = tag_kind(picture.board))
      families[kind->family] = tag_family(kind->family, kind->border_bits);
    return expose(render_light(scene, families, *pose), scene.sensor, Random(index, 1).next());
  });
  return true;
}

Task worlds_task(const std::string& group, int count, const fs::path& folder) {
  return {group,
          [=](std::uint64_t index) -> std::vector<Values> {
            Picture picture;
            return draw(index, group, folder, picture) ? measure(picture) : std::vector<Values>();
          },
          count, true};
}

Task empty_task(const std::string& name, int count, const Board& board) {
  return {"empty " + name,
          [=](std::uint64_t seed) {
            return measure(
                {"empty", name + std::to_string(seed), board, picture_without_tags(seed), {}});
          },
          count};
}

std::vector<Values> measure_set(const fs::path& folder) {
  const Board board = read_target(folder / "target.yaml");
  const std::vector<fs::path> files = list_pictures(folder);
  Dataset set;
  set.boards = {{board, Pose()}};
  std::vector<FoundCorners> found;
  for (const fs::path& file : files) {
    const Image8 image = read_image(file);
    set.image_size = image.size();
    found.push_back(corners_by_fit(image, board, nullptr));
    set.views.push_back(found.back().view);
  }
  const auto exact = exact_by_calibration(set);
  std::vector<Values> rows;
  for (std::size_t i = 0; i < files.size(); ++i)
    rows.push_back(row_of({"", files[i].filename().string(), board, {}, exact[i]}, found[i]));
  return rows;
}

std::vector<Task> detect_answers_tasks(const StudyOptions& options) {
  const fs::path folder = options.text("pictures");
  if (!folder.empty()) fs::create_directories(folder);
  std::vector<Task> tasks = {
      worlds_task("tags", 70, folder),
      worlds_task("edges", 35, folder),
      worlds_task("checkers", 40, folder),
      worlds_task("charuco", 40, folder),
      empty_task("kalibr", 3, make_board(AprilGrid{6, 6, 0.088, 0.3})),
      empty_task("tag16h5", 15, make_board(AprilGrid{6, 5, 0.04, 1.2, 0, "tag16h5", 1, false})),
      empty_task("checkers", 3, make_board(Checkerboard{8, 5, 0.03, 0.03})),
      empty_task("charuco", 3, make_board(Charuco{9, 6, 0.03, 0.022, "DICT_4X4_100"}))};
  for (const std::string& set : options.inputs)
    tasks.push_back(
        {fs::path(set).filename().string(), [set](std::uint64_t) { return measure_set(set); }, 1});
  return tasks;
}

}  // namespace

Study detect_answers_study() {
  return {.name = "detect_answers",
          .summary = "the corners that `detect` finds in a fixed collection of pictures",
          .inputs = "folders of pictures with a target.yaml",
          .needs_inputs = false,
          .count = 1,
          .first = 0,
          .options = {{"pictures", "", "folder that keeps the rendered pictures"}},
          .columns = {"picture", "visible", "found", "wrong", "squares", "claimed", "distances",
                      "beyond", "detect_s"},
          .tasks = detect_answers_tasks,
          .tables = {{{"task"},
                      {rows_in("pictures"), sum_of("visible", "visible"), sum_of("found", "found"),
                       sum_of("wrong", "wrong"), ratio_of("NEES", "distances", "claimed", 2),
                       sum_of("beyond 5 sd", "beyond"), sum_of("time, s", "detect_s", 1)}}}};
}

}  // namespace tagcal
