#include "tagcal/detect/checker_search/checker_corners.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d on_board(const CheckerCell& cell) { return {cell.first, cell.second}; }

constexpr double kNear = 3.0 / 2;  // squares: the corners beside one, and halfway to the next
constexpr double kNearPx = 0.25;   // numeric: TagFitOptions::is_near

struct LocalHomography {
  Matrix3d pixel_from_board;  // the corner is (0, 0)
  double error_px = 0;        // largest, of the places that it is from
};

// By the places within some squares of a corner. No value if they do not determine it.
std::optional<LocalHomography> local_homography(const CheckerCell& cell,
                                                const PlacesByCell& known) {
  for (const double reach : {kNear, 1 + kNear}) {
    const std::vector<CheckerPlace> near = known.near(cell, reach);
    if (near.size() < 4) continue;
    // Pixels are seen as by a camera of a narrow view: homography() takes them for rays.
    Matrix3d pixel_from_ray = Matrix3d::Identity();
    for (const CheckerPlace& place : near)
      pixel_from_ray.topRightCorner<2, 1>() += place.at / static_cast<double>(near.size());
    const Vector2d middle = pixel_from_ray.topRightCorner<2, 1>();
    for (const CheckerPlace& place : near)
      pixel_from_ray(0, 0) = std::max(pixel_from_ray(0, 0), (place.at - middle).norm());
    pixel_from_ray(1, 1) = pixel_from_ray(0, 0);
    std::vector<Vector2d> points;
    std::vector<Vector3d> rays;
    for (const CheckerPlace& place : near) {
      points.push_back(place.on_board - on_board(cell));
      rays.push_back(((place.at - middle) / pixel_from_ray(0, 0)).homogeneous());
    }
    const auto h = homography(points, rays);
    if (!h || std::abs((*h)(2, 2)) == 0) continue;
    LocalHomography result{pixel_from_ray * *h / (*h)(2, 2)};
    for (std::size_t i = 0; i < near.size(); ++i) {
      const Vector2d at = (result.pixel_from_board * points[i].homogeneous()).hnormalized();
      result.error_px = std::max(result.error_px, (at - near[i].at).norm());
    }
    return result;
  }
  return std::nullopt;
}

// Length of a square's shorter side at the origin, px.
double shorter_side(const Matrix3d& h) {
  const Vector2d origin = h.col(2).hnormalized();
  const auto side = [&](const Vector3d& to) { return ((h * to).hnormalized() - origin).norm(); };
  constexpr double kDelta = 1e-3;  // numeric: of differences, small against a square
  return std::min(side({kDelta, 0, 1}), side({0, kDelta, 1})) / kDelta;
}

CheckerCorner corner_of(const CornerFit& fit) { return {fit.corner, fit.covariance_px2}; }

}  // namespace

PlacesByCell::PlacesByCell(const std::vector<CheckerPlace>& places) {
  for (const CheckerPlace& place : places) put(place);
}

void PlacesByCell::put(const CheckerPlace& place) {
  std::vector<Numbered>& at_cell = by_cell_[{static_cast<int>(std::lround(place.on_board.x())),
                                             static_cast<int>(std::lround(place.on_board.y()))}];
  std::erase_if(at_cell, [&](const Numbered& old) {
    return (old.place.on_board - place.on_board).norm() <
           1e-6;  // numeric: squares, equal but for rounding
  });
  at_cell.push_back({count_++, place});
}

std::vector<CheckerPlace> PlacesByCell::near(const CheckerCell& cell, double reach) const {
  const int cells = static_cast<int>(std::ceil(reach));
  std::vector<Numbered> found;
  for (int column = cell.first - cells; column <= cell.first + cells; ++column)
    for (auto it = by_cell_.lower_bound({column, cell.second - cells});
         it != by_cell_.end() && it->first <= CheckerCell{column, cell.second + cells}; ++it)
      for (const Numbered& one : it->second)
        if ((one.place.on_board - on_board(cell)).cwiseAbs().maxCoeff() <= reach)
          found.push_back(one);
  std::ranges::sort(found, {}, &Numbered::number);
  std::vector<CheckerPlace> places;
  for (const Numbered& one : found) places.push_back(one.place);
  return places;
}

CheckerFitter::CheckerFitter(const ImageView8& image, const CheckerPrint& print,
                             const Camera* camera)
    : image_(image), print_(print), camera_(camera) {}

std::optional<CornerFit> CheckerFitter::fit_one(const CheckerCell& cell, const PlacesByCell& known,
                                                TagFitOptions options) const {
  const auto local = local_homography(cell, known);
  if (!local) return std::nullopt;
  const Matrix3d& h = local->pixel_from_board;
  const Vector2d start = h.col(2).hnormalized();
  const double side = shorter_side(h);
  if (!start.allFinite()) return std::nullopt;
  options.is_near &= local->error_px < kNearPx;
  for (const double outside : {1.0, policy::kCheckerOutside}) {
    if (outside < 1 && !print_.is_at_edge(cell)) break;
    const CornerFit fit = refine_corner(image_, print_.about(cell, outside), h,
                                        with_usual_priors(options, image_.size()));
    if (fit.status != TagFitStatus::converged) continue;
    if ((fit.corner - start).norm() > policy::kMaxMoveShare * side) continue;
    return fit;
  }
  return std::nullopt;
}

CameraProcessing CheckerFitter::processing_of(const CheckerCorners& corners,
                                              const PlacesByCell& places) const {
  std::vector<std::pair<double, CheckerCell>> order;
  for (const auto& [cell, corner] : corners)
    if (const auto local = local_homography(cell, places))
      order.emplace_back(order_of_part(2 * shorter_side(local->pixel_from_board)), cell);
  std::ranges::sort(order);
  std::vector<PatternPart> parts;
  for (const auto& [place, cell] : order)
    parts.push_back([&, cell = cell](const CameraProcessing& processing, int row_step) {
      const auto fit = fit_one(
          cell, places,
          {.camera = camera_, .row_step = row_step, .is_near = true, .processing = processing});
      return fit ? PatternFit(*fit) : PatternFit();
    });
  return processing_of_parts(parts);
}

CheckerCorners CheckerFitter::fit(const std::vector<CheckerPlace>& known) const {
  CheckerCorners corners;
  PlacesByCell places(known);
  std::map<CheckerCell, std::size_t> tried;  // number of places near it in the last try
  bool has_new = true;
  while (has_new) {
    std::vector<CheckerPlace> found;
    for (int row = 0; row < print_.rows(); ++row) {
      for (int column = 0; column < print_.columns(); ++column) {
        const CheckerCell cell{column, row};
        if (corners.contains(cell)) continue;
        const std::size_t near = places.near(cell, kNear).size();
        if (near < 2 || near <= tried[cell]) continue;
        tried[cell] = near;
        TagFitOptions options{.camera = camera_, .lens_follows = true, .is_near = true};
        auto corner = fit_one(cell, places, options);
        options.is_near = false;
        if (!corner) corner = fit_one(cell, places, options);
        if (!corner) continue;
        corners[cell] = corner_of(*corner);
        found.push_back({on_board(cell), corner->corner});
      }
    }
    for (const CheckerPlace& place : found) places.put(place);
    has_new = !found.empty();
  }
  return corners;
}

CheckerCorners CheckerFitter::fit_again(const CheckerCorners& corners) const {
  PlacesByCell places;
  for (const auto& [cell, corner] : corners) places.put({on_board(cell), corner.at});
  const CameraProcessing processing = processing_of(corners, places);
  CheckerCorners again;
  for (const auto& [cell, corner] : corners)
    if (const auto fit = fit_one(cell, places, {.camera = camera_, .processing = processing}))
      again[cell] = corner_of(*fit);
  return again;
}

void CheckerFitter::fit_under_lens(CheckerCorners& corners) const {
  std::vector<PanelCorner> on_panel;
  PlacesByCell places;
  for (const auto& [cell, corner] : corners) {
    on_panel.push_back({on_board(cell), corner.at, std::sqrt(corner.covariance_px2.trace() / 2)});
    places.put({on_board(cell), corner.at});
  }
  const CameraProcessing processing = processing_of(corners, places);
  TagFitOptions options{.camera = camera_, .is_near = true, .processing = processing};
  const auto lens = camera_ ? std::nullopt : lens_of_panel(on_panel, image_.size());
  if (lens && lens->spread <= policy::kPanelTailSpreads) options.camera = &lens->camera;
  CheckerCorners all;
  for (const auto& [cell, corner] : corners) {
    auto fitted = fit_one(cell, places, options);
    if (!fitted) fitted = fit_one(cell, places, {.camera = camera_, .processing = processing});
    if (fitted) all[cell] = corner_of(*fitted);
  }
  corners = std::move(all);
}

bool CheckerFitter::drop_outliers(CheckerCorners& corners) const {
  constexpr double kFittedSdPx = 0.1;  // numeric: equal weights; near the edge claims are too small
  std::vector<PanelCorner> on_panel;
  for (const auto& [cell, corner] : corners)
    on_panel.push_back({on_board(cell), corner.at, kFittedSdPx});
  const auto lens = lens_of_panel(on_panel, image_.size());
  if (!lens) return false;
  std::erase_if(corners, [&](const auto& fitted) {
    const auto& [cell, corner] = fitted;
    const auto expected = lens->pixel(on_board(cell));
    const double variance =
        std::pow(kFittedSdPx * lens->spread, 2) + corner.covariance_px2.trace() / 2;
    return !expected || (corner.at - *expected).squaredNorm() >
                            policy::kOutlierSds * policy::kOutlierSds * variance;
  });
  return true;
}

bool is_verified(const CheckerCorners& corners, const CheckerPrint& print) {
  const int columns = print.columns(), rows = print.rows();
  const auto count = [&](const auto& test) {
    return static_cast<double>(
        std::ranges::count_if(corners, [&](const auto& corner) { return test(corner.first); }));
  };
  const double column = policy::kMinLineShare * rows;
  const double row = policy::kMinLineShare * columns;
  return 2 * static_cast<int>(corners.size()) > columns * rows &&
         count([](const CheckerCell& c) { return c.first == 0; }) >= column &&
         count([&](const CheckerCell& c) { return c.first == columns - 1; }) >= column &&
         count([](const CheckerCell& c) { return c.second == 0; }) >= row &&
         count([&](const CheckerCell& c) { return c.second == rows - 1; }) >= row;
}

std::vector<Observation> observations_of(const CheckerCorners& corners, const Checkerboard& board) {
  std::vector<Observation> result;
  for (const auto& [cell, corner] : corners)
    result.push_back({{board.first_id + cell.second * board.columns + cell.first, 0},
                      corner.at,
                      corner.covariance_px2});
  std::ranges::sort(result, {}, &Observation::id);
  return result;
}

}  // namespace tagcal::internal
