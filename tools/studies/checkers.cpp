// Measures the corners of rendered checkerboards (docs/trust/corners.md) on the same pixels: the
// fit of detect() with the lens unknown and known, cv::cornerSubPix from 0.3 px off the truth, and
// cv::findChessboardCornersSB, beside the Cramer-Rao bound of the noise: the covariance of a fit
// under the true lens to the picture with more noise, scaled to the noise and its rounding. (With
// next to no noise the misfit of the model counts.)
// Tasks: boards of one size, tilt, blur and noise; and boards and ChArUco boards of any, through
// three lenses, for the share that is found; and grids of circles under strong lenses, beside
// cv::findCirclesGrid. A corner is wrong if it is off by more than 0.5 px. With inputs: pictures in
// files instead (checker_pictures.hpp).

#include <fmt/format.h>
#include <Eigen/LU>

#include "checker_pictures.hpp"
#include "rendered_checkerboard.hpp"
#include "studies/studies.hpp"
#include "study/chart/circle_methods.hpp"

namespace tagcal {
using namespace study;
namespace {

const CheckerViewSpec kSpecs[] = {{10, 30, .8, 2},    {15, 0, .8, 2},   {15, 30, .8, 2},
                                  {15, 30, .5, 2},    {15, 30, 1.5, 2}, {20, 30, .8, 2},
                                  {20, 60, .8, 2},    {20, 30, .8, 8},  {20, 30, .8, 0},
                                  {15, 30, 1.5, 0.5}, {30, 30, .8, 2},  {50, 30, .8, 2}};

const CheckerViewSpec kCircleSpecs[] = {{24, 0, .8, 2},  {24, 30, .8, 2}, {24, 45, .8, 2},
                                        {24, 60, .8, 2}, {14, 30, .8, 2}, {14, 60, .8, 2},
                                        {34, 60, .8, 2}, {24, 60, .8, 8}, {24, 60, 1.5, 2}};

FoundCorners by_corner_sub_pix(const CheckerView& view, double square_px, Random& random) {
  std::vector<Eigen::Vector2d> starts;
  for (const auto& [id, at] : view.corners)
    starts.push_back(at + Eigen::Vector2d(random.uniform(-.3, .3), random.uniform(-.3, .3)));
  const auto find = [&](const Image8& image) {
    return corners_by_sub_pix(image, starts, square_px);
  };
  return corners_by_peer({"cornerSubPix", find}, view.image, view.corners);
}

FoundCorners by_sectors(const CheckerView& view) {
  return corners_by_peer(peer_detectors(view.board).back(), view.image, view.corners);
}

FoundCorners by_circles_grid(const CheckerView& view) {
  const auto& grid = std::get<CircleGrid>(view.board.pattern);
  const PeerDetector peer{"findCirclesGrid",
                          [&](const Image8& image) { return circles_by_opencv(image, grid); }};
  return corners_by_peer(peer, view.image, view.corners);
}

// The mean variance of a coordinate at the bound. `random`: as before the view was made.
double bound_of(const CheckerView& view, CheckerViewSpec spec, Random random) {
  const auto variance = [](double levels) { return levels * levels + 1.0 / 12; };  // with rounding
  const double noise = variance(spec.noise_levels);
  spec.noise_levels = 8;
  const CheckerView loud = checker_view(view.board, view.camera, spec, random);
  double sum = 0, corners = 0;
  for (const Observation& seen :
       corners_by_fit(loud.image, loud.board, &loud.camera).view.observations)
    if (seen.covariance_px2) ++corners, sum += seen.covariance_px2->trace() / 2;
  return sum * noise / variance(spec.noise_levels) / corners;
}

std::vector<Values> measure(const CheckerViewSpec& spec, std::uint64_t trial) {
  const Camera camera{Perspective({520, 520, 322, 238, -.2, .05}), {640, 480}};
  Random random(31, trial);
  const Random again = random;
  const CheckerView view =
      checker_view(make_board(Checkerboard{8, 5, .03, .03}), camera, spec, random);
  const double bound = bound_of(view, spec, again);
  return {checker_row("fit", view.corners, corners_by_fit(view.image, view.board, nullptr), bound),
          checker_row("fit, lens known", view.corners,
                      corners_by_fit(view.image, view.board, &view.camera), bound),
          checker_row("cornerSubPix", view.corners, by_corner_sub_pix(view, spec.square_px, random),
                      bound),
          checker_row("findChessboardCornersSB", view.corners, by_sectors(view), bound)};
}

// Symmetric and asymmetric grids in turn, through a barrel lens and a fisheye.
std::vector<Values> measure_circles(CheckerViewSpec spec, std::uint64_t trial) {
  const ImageSize size{640, 480};
  const Camera cameras[] = {{Perspective({530, 530, 322, 238, -.4, .18}), size},
                            {Fisheye({270, 270, 322, 238, -.02, .004, -.002, 0}), size}};
  const Board boards[] = {make_board(CircleGrid{8, 6, .02, .01}),
                          make_board(CircleGrid{4, 9, .02, .014, true})};
  Random random(41, trial);
  spec.roll_rad = random.uniform(-1, 1);
  const Random again = random;
  const CheckerView view = checker_view(boards[trial % 2], cameras[trial / 2 % 2], spec, random);
  if (!view.is_whole) return {};
  const double bound = bound_of(view, spec, again);
  return {checker_row("fit", view.corners, corners_by_fit(view.image, view.board, nullptr), bound),
          checker_row("fit, lens known", view.corners,
                      corners_by_fit(view.image, view.board, &view.camera), bound),
          checker_row("findCirclesGrid", view.corners, by_circles_grid(view), bound)};
}

// A ChArUco board may be seen in part.
std::vector<Values> measure_any(bool with_markers, std::uint64_t trial) {
  const ImageSize size{640, 480};
  const Camera cameras[] = {{pinhole(520, 520, 322, 238), size},
                            {Perspective({520, 520, 322, 238, -.3, .1}), size},
                            {Fisheye({210, 210, 322, 238, -.02, .004, -.002, 0}), size}};
  Random random(7, trial);
  const int columns = 6 + static_cast<int>(random.index(5));
  const int rows = columns - 1 - 2 * static_cast<int>(random.index(2));
  const CheckerViewSpec spec{random.uniform(with_markers ? 22 : 10, 45), random.uniform(0, 60),
                             random.uniform(.5, 1.5), random.uniform(1, 5), random.uniform(-1, 1)};
  const Board board = with_markers
                          ? make_board(Charuco{columns + 1, rows + 1, .03, .022, "DICT_4X4_100"})
                          : make_board(Checkerboard{columns, rows, .03, .03});
  const CheckerView view = checker_view(board, cameras[trial % 3], spec, random);
  if (with_markers ? view.corners.size() < 4 : !view.is_whole || view.least_px < 5) return {};
  const double none = std::nan("");
  std::vector<Values> result = {
      checker_row("fit", view.corners, corners_by_fit(view.image, view.board, nullptr), none)};
  if (!with_markers)
    result.push_back(checker_row("findChessboardCornersSB", view.corners, by_sectors(view), none));
  return result;
}

std::vector<Task> checkers_tasks(const StudyOptions& options) {
  if (!options.inputs.empty()) return picture_tasks(options.inputs, options.text("target"));
  std::vector<Task> tasks;
  const auto name = [](const CheckerViewSpec& spec) {
    return fmt::format("{:.0f} px, tilt {:.0f}, blur {:.1f} px, noise {:.0f}", spec.square_px,
                       spec.tilt_deg, spec.blur_px, spec.noise_levels);
  };
  for (const CheckerViewSpec& spec : kSpecs)
    tasks.push_back({name(spec), [&spec](std::uint64_t trial) { return measure(spec, trial); }});
  for (const CheckerViewSpec& spec : kCircleSpecs)
    tasks.push_back({"circles " + name(spec),
                     [&spec](std::uint64_t trial) { return measure_circles(spec, trial); }});
  const int any = 15 * options.count;
  tasks.push_back({"any", [](std::uint64_t trial) { return measure_any(false, trial); }, any});
  tasks.push_back(
      {"any ChArUco", [](std::uint64_t trial) { return measure_any(true, trial); }, any});
  return tasks;
}

}  // namespace

Study checkers_study() {
  return {
      .name = "checkers",
      .summary = "corners of checkerboards and centres of circles, beside OpenCV's and the bound",
      .inputs =
          "pictures, folders of pictures with a target.yaml, or data sets with a truth, "
          "instead of rendered ones",
      .needs_inputs = false,
      .count = 10,
      .options = {{"target", "", "target file of the pictures"}},
      .columns = checker_columns(),
      .tasks = checkers_tasks,
      .tables = {{{"task", "method"}, checker_figures("boards", true)}}};
}

}  // namespace tagcal
