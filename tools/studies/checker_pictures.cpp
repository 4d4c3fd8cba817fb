#include "checker_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "study/quantile.hpp"
#include "study/study_threads.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
using namespace study;
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Of real pictures: the calibration that gives the exact corners leaves the board's bend.
constexpr double kWrongInRealPx = 1.5;

struct PictureSet {
  std::string name;
  Board board;
  std::vector<Image8> images;
  std::vector<ExactCorners> exact;  // only with a truth
};

// The found corners of all pictures by one method.
struct MethodAnswer {
  std::string name;
  std::vector<FoundCorners> found;
};

// Corners in OpenCV's order, row by row, numbered as ours: the board's y points up.
ExactCorners numbered(const std::vector<Vector2d>& corners, const Checkerboard& board) {
  ExactCorners result;
  const auto at = [&](int column, int row) {
    return corners[static_cast<std::size_t>(row * board.columns + column)];
  };
  const Vector2d x = at(1, 0) - at(0, 0), y = at(0, 1) - at(0, 0);
  const bool is_from_above = x.x() * y.y() - x.y() * y.x() > 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      result[{board.first_id + row * board.columns + column, 0}] =
          at(column, is_from_above ? board.rows - 1 - row : row);
  return result;
}

Dataset set_of(const PictureSet& set, const std::vector<View>& views) {
  return {set.images.front().size(), {{set.board, Pose()}}, views, {}};
}

Calibration calibrated(const Dataset& set) {
  CalibrateOptions options;
  options.model = "fisheye4";
  return calibrate(set, options);
}

std::optional<Vector2d> expected(const Calibration& calibration, const CalibratedView& view,
                                 const TargetPoint& point) {
  return project(calibration.camera->lens, view.camera_from_world * point.position);
}

// True if a corner is among those of a view, and not wrong.
const Observation* right_corner(const View& view, const CornerId& id, const ExactCorners& exact) {
  const auto seen = std::ranges::find(view.observations, id, &Observation::id);
  const auto truth = exact.find(id);
  if (seen == view.observations.end() || truth == exact.end()) return nullptr;
  return (seen->pixel - truth->second).norm() < kWrongInRealPx ? &*seen : nullptr;
}

// Replaces the squares of real pictures by those of held-out residuals, over the corners that all
// methods have.
struct HeldOut {
  double squares = 0, count = 0;
};

std::vector<HeldOut> held_out(const PictureSet& set, const std::vector<ExactCorners>& exact,
                              const std::vector<MethodAnswer>& answers, std::size_t method) {
  const Checkerboard squares = checkers(set.board).value();
  std::vector<View> views(exact.size()), others(exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    for (const auto& [id, at] : exact[i]) {
      if (std::ranges::any_of(answers, [&](const MethodAnswer& answer) {
            return !right_corner(answer.found[i].view, id, exact[i]);
          }))
        continue;
      const int corner = id.tag_id - squares.first_id;
      const bool is_other = (corner / squares.columns + corner % squares.columns) % 2 == 1;
      (is_other ? others : views)[i].observations.push_back(
          *right_corner(answers[method].found[i].view, id, exact[i]));
    }
  }
  std::vector<HeldOut> result(exact.size());
  const Calibration calibration = calibrated(set_of(set, views));
  if (!is_answer(calibration.status)) return result;
  for (const CalibratedView& view : calibration.views) {
    for (const TargetPoint& point : target_points(set.board)) {
      const auto& seen = others[view.view].observations;
      const auto one = std::ranges::find(seen, point.id, &Observation::id);
      const auto pixel = expected(calibration, view, point);
      if (one == seen.end() || !pixel) continue;
      result[view.view].squares += (one->pixel - *pixel).squaredNorm() / 2;
      ++result[view.view].count;
    }
  }
  return result;
}

std::vector<Values> rows_of(const PictureSet& set, const std::vector<ExactCorners>& exact,
                            const std::vector<MethodAnswer>& answers) {
  const bool has_truth = !set.exact.empty();
  std::vector<Values> rows;
  for (std::size_t m = 0; m < answers.size(); ++m) {
    const std::vector<HeldOut> residuals =
        has_truth ? std::vector<HeldOut>() : held_out(set, exact, answers, m);
    for (std::size_t i = 0; i < set.images.size(); ++i) {
      Values row = checker_row(answers[m].name, exact[i], answers[m].found[i], kNone,
                               has_truth ? 0.5 : kWrongInRealPx);
      // The calibration leaves the board's bend, so that it does not judge claims.
      if (!has_truth) row[5] = residuals[i].squares, row[6] = residuals[i].count, row[9] = kNone;
      rows.push_back(row);
    }
  }
  return rows;
}

std::vector<Values> measure(const PictureSet& set) {
  if (!checkers(set.board))
    throw Error(set.name + ": only pictures of checkerboards and ChArUco boards are compared");
  const OneOpenCvThread one_thread;
  std::vector<MethodAnswer> answers = {{"fit", {}}};
  for (const Image8& image : set.images)
    answers[0].found.push_back(corners_by_fit(image, set.board, nullptr));
  const std::vector<PeerDetector> peers = peer_detectors(set.board);
  std::vector<ExactCorners> exact = set.exact;
  if (exact.empty()) {
    std::vector<View> most;
    for (std::size_t i = 0; i < set.images.size(); ++i) {
      ExactCorners corners = corners_of(answers[0].found[i].view.observations);
      for (const PeerDetector& peer : peers)
        if (!tag_kind(set.board))
          if (const auto seen = peer.find(set.images[i]); seen.size() > corners.size())
            corners = numbered(seen, checkers(set.board).value());
      View& view = most.emplace_back();
      for (const auto& [id, at] : corners) view.observations.push_back({id, at, {}});
    }
    exact = exact_by_calibration(set_of(set, most));
  }
  for (const PeerDetector& peer : peers) {
    MethodAnswer& answer = answers.emplace_back(MethodAnswer{peer.name, {}});
    for (std::size_t i = 0; i < set.images.size(); ++i)
      answer.found.push_back(corners_by_peer(peer, set.images[i], exact[i]));
  }
  return rows_of(set, exact, answers);
}

// The exact corners in a picture.
ExactCorners corners_in_truth(const Truth& truth, const std::string& name, const Board& board,
                              const Pose& world_from_board) {
  ExactCorners corners;
  for (const TargetPoint& point : target_points(board)) {
    const auto pixel = project(
        truth.camera.lens, truth.camera_from_world.at(name) * (world_from_board * point.position));
    if (pixel && contains(truth.camera.image_size, *pixel)) corners[point.id] = *pixel;
  }
  return corners;
}

PictureSet read_folder(const fs::path& folder, const std::string& target) {
  PictureSet set{folder.filename().string(), {}, {}, {}};
  if (!fs::exists(folder / "dataset.yaml")) {
    const fs::path own = folder / "target.yaml";
    set.board = read_target(fs::exists(own) ? own : fs::path(target));
    for (const fs::path& file : list_pictures(folder)) set.images.push_back(read_image(file));
    return set;
  }
  const DatasetFolder read = read_dataset(folder);
  if (!read.dataset.truth) throw Error(folder.string() + ": needs a truth");
  const PlacedBoard& placed = read.dataset.boards.at(0);
  set.board = placed.board;
  for (const fs::path& file : read.images) {
    set.images.push_back(read_image(file));
    set.exact.push_back(corners_in_truth(*read.dataset.truth, file.filename().string(),
                                         placed.board, placed.world_from_board));
  }
  return set;
}

}  // namespace

ExactCorners corners_of(const std::vector<Observation>& observations) {
  ExactCorners corners;
  for (const Observation& o : observations) corners[o.id] = o.pixel;
  return corners;
}

ExactPictures rendered(const Scene& scene, std::uint64_t seed) {
  const TagFamilies families = tag_families(scene.boards);
  const std::vector<Pose> poses = camera_poses(scene, seed);
  ExactPictures result;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const ImageF light = render_light(scene, families, poses[i]);
    const Image8 picture = expose(light, scene.sensor, Random(seed, i).next());
    result.sources.push_back({image_name(static_cast<int>(i)), [picture] { return picture; }});
    result.corners.push_back(corners_of(visible_corners(scene, poses[i])));
  }
  return result;
}

std::vector<ExactCorners> exact_by_calibration(const Dataset& set) {
  std::vector<ExactCorners> exact(set.views.size());
  if (set.views.size() < 3) {
    for (std::size_t i = 0; i < exact.size(); ++i) exact[i] = corners_of(set.views[i].observations);
    return exact;
  }
  const Calibration calibration = calibrated(set);
  for (const CalibratedView& view : calibration.views)
    for (const TargetPoint& point : target_points(set.boards[0].board))
      if (const auto pixel = expected(calibration, view, point))
        exact[view.view][point.id] = *pixel;
  return exact;
}

std::vector<std::string> checker_columns() {
  return {"method",   "corners", "found",  "right", "wrong", "squares",
          "measured", "bound",   "claims", "nees",  "ms"};
}

std::vector<Figure> checker_figures(const std::string& boards, bool with_bound) {
  std::vector<Figure> figures = {rows_in(boards), sum_of("found", "found"),
                                 sum_of("corners", "corners"), sum_of("right", "right"),
                                 sum_of("wrong", "wrong")};
  if (with_bound) figures.push_back(root_ratio_of("bound, px", "bound", "measured", 4));
  figures.push_back(root_ratio_of("rms, px", "squares", "measured", 4));
  if (with_bound) figures.push_back(root_ratio_of("rms / bound", "squares", "bound", 2));
  figures.push_back(ratio_of("NEES/2", "nees", "claims", 2));
  figures.push_back(mean_of("CPU, ms", "ms", 1));
  return figures;
}

Values checker_row(const std::string& method, const ExactCorners& exact, const FoundCorners& found,
                   double bound_square, double wrong_px) {
  double squares = 0, nees = 0, claims = 0, right = 0, wrong = 0;
  for (const Observation& seen : found.view.observations) {
    const auto truth = exact.find(seen.id);
    const Vector2d error =
        truth == exact.end() ? Vector2d(kNone, kNone) : seen.pixel - truth->second;
    if (!(error.norm() <= wrong_px)) {
      ++wrong;
      continue;
    }
    ++right, squares += error.squaredNorm() / 2;
    if (seen.covariance_px2) ++claims, nees += squared_distance(error, *seen.covariance_px2) / 2;
  }
  const auto all = static_cast<double>(exact.size());
  return {method,
          all,
          all > 0 && right >= 0.9 * all ? 1. : 0.,
          right,
          wrong,
          squares,
          right,
          bound_square * right,
          claims,
          claims > 0 ? nees : kNone,
          found.ms};
}

std::vector<Task> picture_tasks(const std::vector<std::string>& inputs, const std::string& target) {
  std::vector<Task> tasks;
  std::vector<fs::path> files;
  for (const std::string& input : inputs) {
    if (!fs::is_directory(input)) {
      files.emplace_back(input);
      continue;
    }
    const fs::path folder = fs::weakly_canonical(input);
    tasks.push_back({folder.filename().string(),
                     [=](std::uint64_t) { return measure(read_folder(folder, target)); }, 1});
  }
  if (files.empty()) return tasks;
  const auto measure_files = [=](std::uint64_t) {
    PictureSet set{"pictures", read_target(target), {}, {}};
    for (const fs::path& file : files) set.images.push_back(read_image(file));
    return measure(set);
  };
  tasks.push_back({"pictures", measure_files, 1});
  return tasks;
}

}  // namespace tagcal
