#include "tagcal/estimate/rig/rig_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kThird =
    1.0 / 3;  // numeric: from the image's middle to that of a third, over its size

// A place of a board before a camera: in a third or the middle of its image.
struct PossiblePlace {
  Vector3d x;  // in the camera
  int column = 0, row = 0;
};

// At the smallest, the median and the largest distance of the boards that it saw.
std::vector<PossiblePlace> places_before(const Bundle& camera) {
  const std::vector<double> distances = distances_m(camera);
  if (distances.empty()) return {};
  const auto [least, most] = std::ranges::minmax(distances);
  const Vector2d third = kThird * Vector2d(camera.image_size.width, camera.image_size.height);
  std::vector<PossiblePlace> places;
  for (const int row : {0, -1, 1})
    for (const int column : {0, -1, 1}) {
      const auto ray = ray_in_camera(camera.lens(), image_centre(camera.image_size) +
                                                        third.cwiseProduct(Vector2d(column, row)));
      for (const double distance : {median(distances), least, most})
        if (ray) places.push_back({distance * ray->direction, column, row});
    }
  return places;
}

// The standard deviation (px) of the projection of a point into a camera, by that of its pose. No
// value if the point is not well inside of the image.
std::optional<double> sigma_of_projection(const Bundle& camera, const Vector3d& x,
                                          const Matrix6& of_pose) {
  PointJacobian by_point;
  const auto pixel = std::visit(
      [&](const auto& lens) { return lens.project(x, &by_point, nullptr); }, camera.lens());
  if (!pixel) return std::nullopt;
  const Vector2d size(camera.image_size.width, camera.image_size.height);
  const Vector2d outwards = (*pixel - image_centre(camera.image_size)).cwiseQuotient(size);
  if (outwards.cwiseAbs().maxCoeff() > kThird) return std::nullopt;
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose << -cross_matrix(x), Eigen::Matrix3d::Identity();
  const Eigen::Matrix<double, 2, 6> by = by_point * by_pose;
  const Eigen::Matrix<double, 6, 6> c = of_pose;
  return std::sqrt(std::max(0.0, (by * c * by.transpose()).trace() / 2));
}

}  // namespace

std::optional<NearestViews> nearest_views(const RigState& state,
                                          const std::vector<std::vector<std::size_t>>& groups) {
  std::vector<std::size_t> group(state.cameras.size(), 0);
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (const std::size_t c : groups[g]) group[c] = g;
  // In the order of time the nearest view of another group is the last one before, or the next.
  struct Seen {
    std::size_t instant, camera, board;
  };
  std::vector<Seen> all;
  for (std::size_t c = 0; c < state.cameras.size(); ++c)
    for (std::size_t v = 0; v < state.instant[c].size(); ++v)
      if (const auto& t = state.instant[c][v])
        all.push_back({*t, c, state.poses.links[c][v].board});
  std::ranges::stable_sort(all, {}, [&](const Seen& s) { return state.time[s.instant]; });
  std::optional<NearestViews> nearest;
  std::vector<std::vector<std::optional<Seen>>> last(
      state.poses.world_from_board.size(), std::vector<std::optional<Seen>>(groups.size()));
  for (const Seen& seen : all) {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const auto& other = last[seen.board][g];
      if (!other || g == group[seen.camera]) continue;
      const double apart = state.time[seen.instant] - state.time[other->instant];
      if (!nearest || apart < nearest->apart)
        nearest = {other->camera, seen.camera, other->instant, seen.instant, apart};
    }
    last[seen.board][group[seen.camera]] = seen;
  }
  return nearest;
}

std::optional<AdvisedPair> advised_pair(const SolvedRig& solved) {
  const RigState& state = *solved.state;
  std::optional<AdvisedPair> worst;
  std::string where;
  for (std::size_t a = 0; a < state.cameras.size(); ++a) {
    const std::vector<PossiblePlace> places = places_before(state.cameras[a]);
    for (std::size_t b = a + 1; b < state.cameras.size(); ++b) {
      if (!solved.start.has(a) || !solved.start.has(b)) continue;
      const auto& place = state.poses.camera_from_rig;
      const Matrix6 covariance = covariance_of_pair(solved, a, b);
      for (const PossiblePlace& p : places) {
        const auto sigma =
            sigma_of_projection(state.cameras[b], place[b] * place[a].inverse() * p.x, covariance);
        if (!sigma || (worst && *sigma <= worst->sigma_px)) continue;
        worst = {a, b, p.x.norm(), *sigma, {}};
        where = side_name(p.column, p.row, "middle");
        if (where != "middle") where += " part";
      }
    }
  }
  if (!worst) return worst;
  const auto& cameras = solved.data->cameras;
  const std::string &a = cameras[worst->a].name, &b = cameras[worst->b].name;
  worst->sentence = fmt::format(
      "show the board to {} and {} at the same time, {:.2g} m from {}, in the {} of its picture: "
      "by their places its projection into {} is known to {:.2g} px there",
      a, b, worst->distance_m, a, where, b, worst->sigma_px);
  return worst;
}

}  // namespace tagcal::internal
