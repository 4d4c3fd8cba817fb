#include "page_data/page_parts.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "tagcal/scene/surfaces.hpp"

namespace tagcal::tools {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Square = std::vector<Vector3d>;

constexpr std::size_t kMostSquares = 2000;

AlignedBox3d box_of(const std::vector<TargetPoint>& points) {
  AlignedBox3d box;
  for (const TargetPoint& p : points) box.extend(p.position);
  return box;
}

Square rectangle(const Vector3d& low, const Vector3d& high) {
  return {low, {high.x(), low.y(), low.z()}, high, {low.x(), high.y(), high.z()}};
}

// The printed part of checkerboards and grids of circles; of other boards their points.
Square outline_of(const Board& board) {
  if (point_grid(board)) {
    const Rectangle paper = board_panels(board, 0).front().paper;
    return {paper.begin(), paper.end()};
  }
  const AlignedBox3d box = box_of(target_points(board));
  return rectangle(box.min(), box.max());
}

std::vector<Square> squares_of(const Board& board) {
  std::vector<Square> squares;
  const auto add = [&](const auto& corners) {
    squares.emplace_back(corners.begin(), corners.end());
  };
  if (point_kind(board) == PointKind::circle_centre)
    squares = drawn_print(board, board_panels(board, 0).front());
  else if (checkers(board))
    std::ranges::for_each(black_squares(board), add);
  else
    for (const Tag& tag : tags_of(board)) add(tag_corners(tag));
  if (squares.size() > kMostSquares) squares.resize(kMostSquares);
  return squares;
}

PageJson square_json(const Square& square) {
  PageJson list = PageJson::array();
  for (const Vector3d& x : square) list.push_back(point_json(x));
  return list;
}

const PlacedBoard* flat_board(const std::vector<PlacedBoard>& boards) {
  return boards.size() == 1 ? &boards.front() : nullptr;
}

// Height in metres at a place from (-1, -1) to (1, 1) over the board.
double height_m(const BoardWarp& warp, double x, double y) {
  return (warp.bend_mm.x() * (1 - x * x) + warp.bend_mm.y() * (1 - y * y) + warp.twist_mm * x * y) /
         1000;
}

// From -1 to 1 over the box.
Vector3d relative_place(const AlignedBox3d& box, const Vector3d& x) {
  return (x - box.center()).cwiseQuotient((box.sizes() / 2).cwiseMax(1e-12));  // numeric: flat box
}

// The sides in `steps` parts, so that they bend as the lens bends them. Null if a point of them has
// no image.
PageJson image_of(const Square& square, const Camera& camera, const Pose& camera_from_board,
                  int steps) {
  PageJson list = PageJson::array();
  for (std::size_t i = 0; i < square.size(); ++i) {
    const Vector3d along = square[(i + 1) % square.size()] - square[i];
    for (int k = 0; k < steps; ++k) {
      const auto pixel = project(camera.lens, camera_from_board * (square[i] + along * k / steps));
      if (!pixel) return nullptr;
      list.push_back(point_json(*pixel));
    }
  }
  return list;
}

// As advise() chooses it: the board with most points.
const Board& largest(const std::vector<PlacedBoard>& boards) {
  return std::ranges::max_element(
             boards, {},
             [](const PlacedBoard& placed) { return target_points(placed.board).size(); })
      ->board;
}

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::optional<Vector2d> reprojected(const PageContent& content, const CalibratedView& view,
                                    const Vector3d& x_in_world) {
  const Camera& camera = *content.calibration.camera;
  const Vector3d x = view.camera_from_world * x_in_world;
  if (view.scale_px_per_m)
    return Vector2d(*view.scale_px_per_m * x.head<2>() + image_centre(camera.image_size));
  return project(camera.lens, x);
}

// The standard deviation that the calibration gives to a corner.
double claimed_sd_px(const Calibration& calibration, const Observation& seen) {
  if (!calibration.sigma_of_corners)
    return calibration.sigma_px > 0 ? calibration.sigma_px : kUnknown;
  constexpr double kWithoutCovariance = 0.5;  // as CalibrateOptions::sigma_px
  const double variance = seen.covariance_px2 ? seen.covariance_px2->trace() / 2
                                              : kWithoutCovariance * kWithoutCovariance;
  return std::sqrt(variance + calibration.model_error_px * calibration.model_error_px);
}

// Points of the boards in the world; of the one flat board as BoardWarp places them, if there is
// one.
std::map<CornerId, Vector3d> bent_points_in_world(const std::vector<PlacedBoard>& boards,
                                                  const std::optional<BoardWarp>& warp) {
  const PlacedBoard* const placed = warp ? flat_board(boards) : nullptr;
  if (!placed) return points_in_world(boards);
  const std::vector<TargetPoint> points = target_points(placed->board);
  const AlignedBox3d box = box_of(points);
  std::map<CornerId, Vector3d> bent;
  for (const TargetPoint& p : points) {
    const Vector3d place = relative_place(box, p.position);
    const Vector3d by(0, warp->aspect * (p.position.y() - box.center().y()),
                      height_m(*warp, place.x(), place.y()));
    bent[p.id] = placed->world_from_board * Vector3d(p.position + by);
  }
  return bent;
}

}  // namespace

PageJson boards_json(const std::vector<PlacedBoard>& boards) {
  PageJson list = PageJson::array();
  for (const PlacedBoard& placed : boards) {
    PageJson squares = PageJson::array(), points = PageJson::array();
    for (const Square& square : squares_of(placed.board)) squares.push_back(square_json(square));
    for (const TargetPoint& p : target_points(placed.board))
      if (points.size() < 4 * kMostSquares) points.push_back(point_json(p.position));
    list.push_back({{"name", fmt::format("board {}", list.size() + 1)},
                    {"world_from_board", matrix_json(placed.world_from_board)},
                    {"outline", square_json(outline_of(placed.board))},
                    {"squares", std::move(squares)},
                    {"points", std::move(points)}});
  }
  return list;
}

PageJson warp_json(const std::vector<PlacedBoard>& boards, const std::optional<BoardWarp>& warp) {
  const PlacedBoard* const placed = warp ? flat_board(boards) : nullptr;
  if (!placed) return nullptr;
  constexpr int kNodes = 21;
  const Vector3d size = box_of(target_points(placed->board)).sizes();
  MatrixX height_mm(kNodes, kNodes);
  for (int row = 0; row < kNodes; ++row)
    for (int column = 0; column < kNodes; ++column)
      height_mm(row, column) =
          1000 * height_m(*warp, 2.0 * column / (kNodes - 1) - 1, 2.0 * row / (kNodes - 1) - 1);
  return {{"bend_mm", {significant(warp->bend_mm.x()), significant(warp->bend_mm.y())}},
          {"sigma_mm", {significant(warp->sigma_mm.x()), significant(warp->sigma_mm.y())}},
          {"twist_mm", significant(warp->twist_mm)},
          {"sigma_twist_mm", significant(warp->sigma_twist_mm)},
          {"aspect", significant(warp->aspect)},
          {"sigma_aspect", significant(warp->sigma_aspect)},
          {"size_mm", {significant(1000 * size.x()), significant(1000 * size.y())}},
          {"columns", kNodes},
          {"rows", kNodes},
          {"height_mm", grid_json(height_mm)}};
}

PageJson advice_json(const PageContent& content) {
  if (!content.advice || content.dataset.boards.empty()) return nullptr;
  const AdvisedView& advice = *content.advice;
  PageJson json = {{"sentence", advice.sentence},
                   {"camera_from_board", matrix_json(advice.camera_from_board)},
                   {"outline_px", nullptr},
                   {"squares_px", PageJson::array()},
                   {"focal_sigma_px", significant(advice.focal_sigma_px)},
                   {"focal_sigma_now_px", significant(advice.focal_sigma_now_px)}};
  // Without a focal length the advice is for a nominal one, of which there is no camera here.
  if (!is_answer(content.calibration.status) || !content.calibration.camera ||
      content.calibration.model == "weak")
    return json;
  const Camera& camera = *content.calibration.camera;
  const Board& board = largest(content.dataset.boards);
  json["outline_px"] = image_of(outline_of(board), camera, advice.camera_from_board, 12);
  for (const Square& square : squares_of(board)) {
    PageJson image = image_of(square, camera, advice.camera_from_board, 2);
    if (!image.is_null()) json["squares_px"].push_back(std::move(image));
  }
  return json;
}

std::vector<PageCorner> page_corners(const PageContent& content) {
  const Calibration& calibration = content.calibration;
  std::set<std::pair<std::size_t, std::size_t>> outliers;
  for (const Outlier& o : calibration.outliers) outliers.emplace(o.view, o.corner);
  const auto points = bent_points_in_world(content.dataset.boards, calibration.board_warp);
  const bool answered = is_answer(calibration.status) && calibration.camera;
  std::vector<PageCorner> corners;
  for (std::size_t v = 0; v < content.dataset.views.size(); ++v) {
    const CalibratedView* const estimate = answered ? content.estimate_of(v) : nullptr;
    const auto& seen = content.dataset.views[v].observations;
    std::size_t inlier = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      PageCorner corner{v,
                        seen[i].id,
                        seen[i].pixel,
                        Vector2d::Constant(kUnknown),
                        (answered && !estimate) || outliers.contains({v, i}),
                        claimed_sd_px(calibration, seen[i])};
      const auto point = points.find(corner.id);
      if (estimate && point != points.end()) {
        if (!corner.rejected && inlier < estimate->residuals_px.size())
          corner.residual_px = -estimate->residuals_px[inlier++];
        else if (const auto p = reprojected(content, *estimate, point->second))
          corner.residual_px = corner.pixel - *p;
      }
      corners.push_back(corner);
    }
  }
  return corners;
}

PageJson corners_json(const std::vector<PageCorner>& corners) {
  PageJson columns;
  for (const char* name : {"view", "u", "v", "du", "dv", "rejected", "tag", "corner", "sd_px"})
    columns[name] = PageJson::array();
  for (const PageCorner& c : corners) {
    columns["view"].push_back(c.view);
    columns["u"].push_back(decimals(c.pixel.x(), 2));
    columns["v"].push_back(decimals(c.pixel.y(), 2));
    columns["du"].push_back(significant(c.residual_px.x(), 4));
    columns["dv"].push_back(significant(c.residual_px.y(), 4));
    columns["rejected"].push_back(c.rejected ? 1 : 0);
    columns["tag"].push_back(c.id.tag_id);
    columns["corner"].push_back(c.id.corner);
    columns["sd_px"].push_back(significant(c.sd_px, 3));
  }
  return columns;
}

}  // namespace tagcal::tools
