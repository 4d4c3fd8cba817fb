// Measures the corners of rendered checkerboards (docs/trust/corners.md) on the same pixels: the
// fit of detect(), cv::cornerSubPix and cv::findChessboardCornersSB, beside the Cramer-Rao bound of
// noise.
//   checker_accuracy [views per row, default 12 [row]]
// The share of boards that are found, over sizes, tilts to 60 degrees, blur, noise and lenses,
// beside cv::findChessboardCornersSB:
//   checker_accuracy found [views, default 300]
// The same for ChArUco boards:
//   checker_accuracy charuco [views, default 100]
// Centres of circles under a strong lens, beside the bound and cv::findCirclesGrid:
//   checker_accuracy circles [views per row, default 12]

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "rendered_checkerboard.hpp"
#include "tagcal/detect/detector.hpp"

namespace {

using namespace tagcal;
using Corners = std::map<CornerId, Eigen::Vector2d>;

cv::Mat as_mat(const Image8& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0))};
}

View found_in(const Image8& image, const CheckerView& view, const Camera* camera) {
  DetectOptions options;
  options.camera = camera;
  return detect(image, {{view.board, Pose()}}, options).view;
}

class Errors {
 public:
  void add(const Eigen::Vector2d& found, const Eigen::Vector2d& truth) {
    squares_ += (found - truth).squaredNorm();
    mean_ += found - truth;
    ++count_;
  }
  int count() const { return count_; }
  double rms() const { return std::sqrt(squares_ / (2 * count_)); }
  Eigen::Vector2d mean() const { return mean_ / count_; }

 private:
  int count_ = 0;
  double squares_ = 0;
  Eigen::Vector2d mean_ = Eigen::Vector2d::Zero();
};

void add_corner_sub_pix(const CheckerView& view, double window, Random& random, Errors& errors) {
  std::vector<cv::Point2f> corners;
  for (const auto& [id, at] : view.corners)
    corners.emplace_back(static_cast<float>(at.x() + random.uniform(-.3, .3)),
                         static_cast<float>(at.y() + random.uniform(-.3, .3)));
  const int half = std::max(2, static_cast<int>(window));
  cv::cornerSubPix(as_mat(view.image), corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 40, 1e-3});
  std::size_t i = 0;
  for (const auto& [id, at] : view.corners) {
    errors.add(Eigen::Vector2d(corners[i].x, corners[i].y), at);
    ++i;
  }
}

bool add_sector_based(const CheckerView& view, Errors* errors) {
  std::vector<cv::Point2f> corners;
  const Checkerboard squares = checkers(view.board).value();
  if (!cv::findChessboardCornersSB(as_mat(view.image), {squares.columns, squares.rows}, corners,
                                   cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY))
    return false;
  for (const cv::Point2f& corner : corners) {
    const Eigen::Vector2d found(corner.x, corner.y);
    const Eigen::Vector2d* nearest = nullptr;
    for (const auto& [id, at] : view.corners)
      if (!nearest || (at - found).norm() < (*nearest - found).norm()) nearest = &at;
    if (errors) errors->add(found, *nearest);
  }
  return true;
}

struct Fits {
  Errors errors;
  double nees = 0, predicted = 0;

  void add(const View& found, const CheckerView& view) {
    for (const Observation& seen : found.observations) {
      const auto truth = view.corners.find(seen.id);
      if (truth == view.corners.end() || !seen.covariance_px2) continue;
      const Eigen::Vector2d error = seen.pixel - truth->second;
      errors.add(seen.pixel, truth->second);
      nees += error.dot(seen.covariance_px2->inverse() * error) / 2;
      predicted += seen.covariance_px2->trace();
    }
  }

  void print(const char* name, double bound) const {
    const double n = errors.count();
    std::printf("  %-12s %5d corners  rms %.4f  bound %.4f (%.2f)  NEES/2 %.2f  mean %+.4f %+.4f\n",
                name, errors.count(), errors.rms(), bound, errors.rms() / bound, nees / n,
                errors.mean().x(), errors.mean().y());
  }
};

// Of a bound in px, scaled from the noise of its picture to that of a row, each with its rounding.
double scale_of_bound(const CheckerViewSpec& spec, double noise_levels) {
  return std::hypot(spec.noise_levels, std::sqrt(1.0 / 12)) /
         std::hypot(noise_levels, std::sqrt(1.0 / 12));
}

void print(const CheckerViewSpec& spec) {
  std::printf("%.0f px, tilt %.0f deg, blur %.1f px, noise %.0f\n", spec.square_px, spec.tilt_deg,
              spec.blur_px, spec.noise_levels);
}

struct Row {
  CheckerViewSpec spec;
};

const Row kRows[] = {{{10, 30, .8, 2}},  {{15, 0, .8, 2}},  {{15, 30, .8, 2}}, {{15, 30, .5, 2}},
                     {{15, 30, 1.5, 2}}, {{20, 30, .8, 2}}, {{20, 60, .8, 2}}, {{20, 30, .8, 8}},
                     {{20, 30, .8, 0}},  {{30, 30, .8, 2}}, {{50, 30, .8, 2}}};

// The bound is the covariance of a fit under the true lens to the picture with next to no noise,
// scaled to the noise and its rounding.
void run(const Row& row, int count) {
  const Camera camera{Perspective({520, 520, 322, 238, -.2, .05}), {640, 480}};
  const Board board = make_board(Checkerboard{8, 5, .03, .03});
  Random random(31);
  Fits unknown, known, exact;
  Errors sub_pix, sector_based;
  double bound = 0;
  for (int i = 0; i < count; ++i) {
    const CheckerView view = checker_view(board, camera, row.spec, random);
    unknown.add(found_in(view.image, view, nullptr), view);
    known.add(found_in(view.image, view, &view.camera), view);
    exact.add(found_in(view.quiet, view, &view.camera), view);
    add_corner_sub_pix(view, std::min(5.0, row.spec.square_px / 3), random, sub_pix);
    add_sector_based(view, &sector_based);
  }
  bound = scale_of_bound(row.spec, 0.5) * std::sqrt(exact.predicted / (2 * exact.errors.count()));
  print(row.spec);
  unknown.print("fit", bound);
  known.print("known lens", bound);
  for (const auto& [name, errors] : {std::pair{"cornerSubPix", &sub_pix}, {"SB", &sector_based}})
    std::printf("  %-12s %5d corners  rms %.4f  (%.2f)\n", name, errors->count(), errors->rms(),
                errors->rms() / bound);
}

// The distances of the true centres to the nearest ones that OpenCV finds.
bool add_circles_grid(const CheckerView& view, Errors& errors) {
  const auto& grid = std::get<CircleGrid>(view.board.pattern);
  std::vector<cv::Point2f> centres;
  if (!cv::findCirclesGrid(
          as_mat(view.image), {grid.columns, grid.rows}, centres,
          grid.asymmetric ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID))
    return false;
  for (const auto& [id, at] : view.corners) {
    Eigen::Vector2d nearest(1e9, 1e9);
    for (const cv::Point2f& centre : centres)
      if (const Eigen::Vector2d found(centre.x, centre.y);
          (found - at).norm() < (nearest - at).norm())
        nearest = found;
    errors.add(nearest, at);
  }
  return true;
}

const Row kCircleRows[] = {{{24, 0, .8, 2}},  {{24, 30, .8, 2}}, {{24, 45, .8, 2}},
                           {{24, 60, .8, 2}}, {{14, 30, .8, 2}}, {{14, 60, .8, 2}},
                           {{34, 60, .8, 2}}, {{24, 60, .8, 8}}, {{24, 60, 1.5, 2}}};

// Symmetric and asymmetric grids in turn, through a barrel lens and a fisheye. The bound is the
// covariance of a fit under the true lens to the picture with more noise, scaled to its noise: with
// next to none the misfit of the model counts.
void run_circles(const Row& row, int count) {
  const ImageSize size{640, 480};
  const Camera cameras[] = {{Perspective({530, 530, 322, 238, -.4, .18}), size},
                            {Fisheye({270, 270, 322, 238, -.02, .004, -.002, 0}), size}};
  const Board boards[] = {make_board(CircleGrid{8, 6, .02, .01}),
                          make_board(CircleGrid{4, 9, .02, .014, true})};
  Random random(41);
  CheckerViewSpec loud = row.spec;
  loud.noise_levels = 8;
  Fits unknown, known, exact;
  Errors theirs;
  int whole = 0, found = 0, found_by_opencv = 0;
  for (int i = 0; i < count; ++i) {
    CheckerViewSpec spec = row.spec;
    spec.roll_rad = random.uniform(-1, 1);
    Random again = random;
    const CheckerView view = checker_view(boards[i % 2], cameras[i / 2 % 2], spec, random);
    if (!view.is_whole) continue;
    ++whole;
    const View seen = found_in(view.image, view, nullptr);
    found += seen.observations.size() == view.corners.size() ? 1 : 0;
    unknown.add(seen, view);
    known.add(found_in(view.image, view, &view.camera), view);
    loud.roll_rad = spec.roll_rad;
    const CheckerView same = checker_view(view.board, view.camera, loud, again);
    exact.add(found_in(same.image, same, &view.camera), same);
    found_by_opencv += add_circles_grid(view, theirs) ? 1 : 0;
  }
  const double bound = scale_of_bound(row.spec, loud.noise_levels) *
                       std::sqrt(exact.predicted / (2 * exact.errors.count()));
  print(row.spec);
  unknown.print("fit", bound);
  known.print("known lens", bound);
  std::printf("  %-12s %5d centres  rms %.4f  (%.2f)\n", "OpenCV", theirs.count(), theirs.rms(),
              theirs.rms() / bound);
  std::printf("  found whole: %d of %d; findCirclesGrid %d\n", found, whole, found_by_opencv);
}

void run_found(int count, bool with_markers) {
  const ImageSize size{640, 480};
  const Camera cameras[] = {{pinhole(520, 520, 322, 238), size},
                            {Perspective({520, 520, 322, 238, -.3, .1}), size},
                            {Fisheye({210, 210, 322, 238, -.02, .004, -.002, 0}), size}};
  Random random(7);
  int whole = 0, found = 0, corners = 0, wrong = 0, all = 0, theirs = 0;
  Fits fits;
  for (int i = 0; i < count; ++i) {
    const int columns = 6 + static_cast<int>(random.index(5));
    const int rows = columns - 1 - 2 * static_cast<int>(random.index(2));
    const Checkerboard squares{
        .columns = columns, .rows = rows, .column_spacing = .03, .row_spacing = .03};
    const double least = with_markers ? 22 : 10;
    CheckerViewSpec spec{random.uniform(least, 45), random.uniform(0, 60), random.uniform(.5, 1.5),
                         random.uniform(1, 5), random.uniform(-1, 1)};
    const Board board = with_markers
                            ? make_board(Charuco{columns + 1, rows + 1, .03, .022, "DICT_4X4_100"})
                            : make_board(squares);
    const CheckerView view = checker_view(board, cameras[i % 3], spec, random);
    // A ChArUco board may be seen in part.
    if (with_markers ? view.corners.size() < 4 : !view.is_whole || view.least_px < 5) continue;
    ++whole;
    const View seen = found_in(view.image, view, nullptr);
    fits.add(seen, view);
    all += static_cast<int>(view.corners.size());
    corners += static_cast<int>(seen.observations.size());
    for (const Observation& one : seen.observations) {
      const auto truth = view.corners.find(one.id);
      wrong += truth == view.corners.end() || (truth->second - one.pixel).norm() > 0.5 ? 1 : 0;
    }
    const bool is_found = seen.observations.size() * 10 >= view.corners.size() * 9;
    found += is_found ? 1 : 0;
    if (!with_markers) theirs += add_sector_based(view, nullptr) ? 1 : 0;
    if (!is_found)
      std::printf(
          "  missed: view %d, camera %d, %d x %d, %.0f px, least %.1f px, tilt %.0f, blur "
          "%.1f, noise %.1f: %zu of %zu\n",
          i, i % 3, columns, rows, spec.square_px, view.least_px, spec.tilt_deg, spec.blur_px,
          spec.noise_levels, seen.observations.size(), view.corners.size());
  }
  std::printf(
      "found %d of %d boards; findChessboardCornersSB %d; corners %d of %d, %d off by more "
      "than 0.5 px; NEES/2 %.2f\n",
      found, whole, theirs, corners, all, wrong, fits.nees / fits.errors.count());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string kind = argc > 1 ? argv[1] : "";
  if (kind == "found" || kind == "charuco") {
    const bool with_markers = kind == "charuco";
    run_found(argc > 2 ? std::atoi(argv[2]) : with_markers ? 100 : 300, with_markers);
    return 0;
  }
  if (kind == "circles") {
    for (const Row& row : kCircleRows) run_circles(row, argc > 2 ? std::atoi(argv[2]) : 12);
    return 0;
  }
  const int count = argc > 1 ? std::atoi(argv[1]) : 12;
  const int only = argc > 2 ? std::atoi(argv[2]) : -1;
  for (int i = 0; i < static_cast<int>(std::size(kRows)); ++i)
    if (only < 0 || i == only) run(kRows[i], count);
  return 0;
}
