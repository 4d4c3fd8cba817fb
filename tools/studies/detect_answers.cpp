// The corners that `detect` finds in a fixed collection of pictures, a row a picture, as the
// referee of the constants of detect/policy (tools/sensitivity.py, docs/trust/sensitivity.md).
//   detect_answers OUT.csv PICTURES [SET...]
// Rendered are views of random worlds (docs/trust/worlds.md) with AprilGrids, whose tags are
// fitted, or half of them again by their sides only (`edges`), and with checkerboards and ChArUco
// boards in their place, all with the worlds' lenses, light, noise and blur; and pictures without
// targets. PICTURES keeps them for the next run. A SET is a folder of real pictures with a
// target.yaml; the truth of its corners is a calibration of all of them by `fisheye4`.
// Columns: corners that are visible; found; of these wrong (hidden, or off by more than 1 px);
// of the others the sum of squared errors, the number with a covariance and the sum of their
// squared Mahalanobis distances, and how many of them are beyond five standard deviations.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/LU>

#include "false_tag_pictures.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"
#include "worlds/draw.hpp"

namespace tagcal {
namespace {

namespace fs = std::filesystem;

using Corners = std::map<CornerId, Eigen::Vector2d>;

constexpr std::uint64_t kSeed = 31;
constexpr double kWrongPx = 1;
constexpr double kFiveSigma2 = 5.3613;  // as in worlds/record.hpp

struct Picture {
  std::string group, name;
  Board board;
  Image8 image;
  Corners exact;
};

class Answers {
 public:
  explicit Answers(const std::string& file) : file_(std::fopen(file.c_str(), "w")) {
    if (!file_) throw Error(file + ": cannot be written");
    std::fprintf(file_,
                 "group,picture,visible,found,wrong,squares,claimed,distances,beyond,detect_s\n");
  }
  ~Answers() { std::fclose(file_); }

  void add(const Picture& picture) {
    const std::clock_t start = std::clock();
    DetectOptions options;
    options.threads = 1;
    if (picture.group == "edges") options.refinement = Refinement::edges;
    const View view = detect(picture.image, {{picture.board, Pose()}}, options).view;
    add(picture, view, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }

  void add(const Picture& picture, const View& view, double seconds) {
    int wrong = 0, claimed = 0, beyond = 0;
    double squares = 0, distances = 0;
    for (const Observation& o : view.observations) {
      const auto truth = picture.exact.find(o.id);
      if (truth == picture.exact.end() || !((o.pixel - truth->second).norm() < kWrongPx)) {
        ++wrong;
        continue;
      }
      const Eigen::Vector2d error = o.pixel - truth->second;
      squares += error.squaredNorm();
      if (!o.covariance_px2) continue;
      const double square = error.dot(o.covariance_px2->inverse() * error);
      ++claimed;
      distances += square;
      beyond += square > kFiveSigma2 * kFiveSigma2;
    }
    std::fprintf(file_, "%s,%s,%zu,%zu,%d,%.6g,%d,%.6g,%d,%.4f\n", picture.group.c_str(),
                 picture.name.c_str(), picture.exact.size(), view.observations.size(), wrong,
                 squares, claimed, distances, beyond, seconds);
  }

 private:
  std::FILE* file_;
};

Image8 kept(const fs::path& file, const std::function<Image8()>& render) {
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

Corners exact_corners(const Scene& scene, const Pose& pose) {
  Corners corners;
  for (const Observation& o : visible_corners(scene, pose)) corners[o.id] = o.pixel;
  return corners;
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
    picture.exact = exact_corners(scene, p);
    return picture.exact.size() >= all;
  });
  if (pose == poses.end()) return false;
  picture.image = kept(folder / ((is_grid ? "tags" : group) + picture.name + ".png"), [&] {
    TagFamilies families;
    if (const auto kind = tag_kind(picture.board))
      families[kind->family] = tag_family(kind->family, kind->border_bits);
    return expose(render_light(scene, families, *pose), scene.sensor, Random(index, 1).next());
  });
  return true;
}

void add_worlds(const std::string& group, int count, const fs::path& folder, Answers& answers) {
  Picture picture;
  for (std::uint64_t index = 0; count > 0; ++index) {
    if (!draw(index, group, folder, picture)) continue;
    answers.add(picture);
    --count;
  }
}

void add_empty(Answers& answers) {
  const std::tuple<const char*, int, Board> boards[] = {
      {"kalibr", 3, make_board(AprilGrid{6, 6, 0.088, 0.3})},
      {"tag16h5", 15, make_board(AprilGrid{6, 5, 0.04, 1.2, 0, "tag16h5", 1, false})},
      {"checkers", 3, make_board(Checkerboard{8, 5, 0.03, 0.03})},
      {"charuco", 3, make_board(Charuco{9, 6, 0.03, 0.022, "DICT_4X4_100"})}};
  for (const auto& [name, count, board] : boards)
    for (int seed = 0; seed < count; ++seed)
      answers.add({"empty",
                   name + std::to_string(seed),
                   board,
                   picture_without_tags(static_cast<std::uint64_t>(seed)),
                   {}});
}

// The corners by the set's own calibration, or as found if there are too few pictures for one.
std::vector<Corners> exact_in_set(const Dataset& set) {
  std::vector<Corners> exact(set.views.size());
  Calibration calibration;
  CalibrateOptions options;
  options.model = "fisheye4";
  const bool is_calibrated = set.views.size() > 2;
  if (is_calibrated) calibration = calibrate(set, options);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    if (!is_calibrated)
      for (const Observation& o : set.views[i].observations) exact[i][o.id] = o.pixel;
    for (const CalibratedView& view : calibration.views)
      for (const TargetPoint& point : target_points(set.boards[0].board))
        if (const auto pixel =
                project(calibration.camera->lens, view.camera_from_world * point.position);
            pixel && view.image == set.views[i].image)
          exact[i][point.id] = *pixel;
  }
  return exact;
}

void add_set(const fs::path& folder, Answers& answers) {
  const Board board = read_target(folder / "target.yaml");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (is_picture_name(entry.path())) files.push_back(entry.path());
  std::ranges::sort(files);
  Dataset set;
  set.boards = {{board, Pose()}};
  std::vector<double> seconds;
  for (const fs::path& file : files) {
    const Image8 image = read_image(file);
    set.image_size = image.size();
    const std::clock_t start = std::clock();
    set.views.push_back(detect(image, set.boards, {.threads = 1}, file.filename().string()).view);
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  const auto exact = exact_in_set(set);
  for (std::size_t i = 0; i < files.size(); ++i)
    answers.add({folder.filename().string(), set.views[i].image, board, {}, exact[i]}, set.views[i],
                seconds[i]);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  using namespace tagcal;
  if (argc < 3) {
    std::fprintf(stderr, "usage: detect_answers OUT.csv PICTURES [SET...]\n");
    return 2;
  }
  try {
    fs::create_directories(argv[2]);
    Answers answers(argv[1]);
    add_worlds("tags", 70, argv[2], answers);
    add_worlds("edges", 35, argv[2], answers);
    add_worlds("checkers", 40, argv[2], answers);
    add_worlds("charuco", 40, argv[2], answers);
    add_empty(answers);
    for (int i = 3; i < argc; ++i) add_set(argv[i], answers);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "detect_answers: %s\n", error.what());
    return 2;
  }
}
