#pragma once

#include <functional>
#include <set>
#include <string>
#include <utility>

#include "worlds.hpp"

// Data sets with wrong corners, and which of them are wrong; or with a wrong board.

namespace tagcal {

using CornerName = std::pair<std::string, CornerId>;  // image, corner

struct SpoiledWorld {
  Dataset dataset;
  std::set<CornerName> wrong;
};

inline SpoiledWorld untouched(Dataset dataset) { return {std::move(dataset), {}}; }

inline void move_corner(SpoiledWorld& world, View& view, Observation& seen,
                        const Eigen::Vector2d& pixel) {
  if ((pixel - seen.pixel).norm() < 3) return;  // could be noise
  seen.pixel = pixel;
  world.wrong.insert({view.image, seen.id});
}

inline Eigen::Vector2d anywhere(const SpoiledWorld& world, Random& random) {
  return {random.uniform(0, world.dataset.image_size.width),
          random.uniform(0, world.dataset.image_size.height)};
}

// Moves a share of all corners, each by 3 to `reach_px`, or to a random pixel (0).
inline void spoil_corners(SpoiledWorld& world, double share, double reach_px, Random& random) {
  for (View& view : world.dataset.views)
    for (Observation& seen : view.observations) {
      if (random.uniform() >= share) continue;
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      const Eigen::Vector2d moved = seen.pixel + random.uniform(3, std::max(4.0, reach_px)) *
                                                     Eigen::Vector2d(cos(angle), sin(angle));
      move_corner(world, view, seen, reach_px > 0 ? moved : anywhere(world, random));
    }
}

// Moves every corner of a view to a random pixel.
inline void spoil_view(SpoiledWorld& world, std::size_t v, Random& random) {
  View& view = world.dataset.views[v];
  for (Observation& seen : view.observations)
    move_corner(world, view, seen, anywhere(world, random));
}

// Corners of a view get the pixels of others: `from` names where each corner's pixel is taken.
inline void permute(SpoiledWorld& world, std::size_t v,
                    const std::function<CornerId(const CornerId&)>& from) {
  View& view = world.dataset.views[v];
  std::map<CornerId, Eigen::Vector2d> pixels;
  for (const Observation& seen : view.observations) pixels[seen.id] = seen.pixel;
  std::vector<Observation> kept;
  for (Observation seen : view.observations) {
    const auto pixel = pixels.find(from(seen.id));
    if (pixel == pixels.end()) continue;
    move_corner(world, view, seen, pixel->second);
    kept.push_back(seen);
  }
  view.observations = kept;
}

inline std::function<CornerId(const CornerId&)> swapping(int a, int b) {
  return [=](const CornerId& id) {
    return CornerId{id.tag_id == a ? b : id.tag_id == b ? a : id.tag_id, id.corner};
  };
}

// The tags' corners rotated by `turns`; tag -1: of all tags.
inline std::function<CornerId(const CornerId&)> rotating(int tag, int turns) {
  return [=](const CornerId& id) {
    return tag < 0 || id.tag_id == tag ? CornerId{id.tag_id, (id.corner + turns) % 4} : id;
  };
}

// Exchanges left and right.
inline void mirror(SpoiledWorld& world, std::size_t v) {
  View& view = world.dataset.views[v];
  for (Observation& seen : view.observations) {
    seen.pixel.x() = world.dataset.image_size.width - 1 - seen.pixel.x();
    world.wrong.insert({view.image, seen.id});
  }
}

// The tags of the right half of the board (columns 3 to 5), or the odd corners, moved by so much.
enum class Half { right, odd };
inline void shift_half(SpoiledWorld& world, std::size_t v, Half half,
                       const Eigen::Vector2d& by_px) {
  View& view = world.dataset.views[v];
  for (Observation& seen : view.observations) {
    const bool moved =
        half == Half::right ? seen.id.tag_id % 6 >= 3 : (seen.id.tag_id + seen.id.corner) % 2 == 1;
    if (!moved) continue;
    seen.pixel += by_px;
    world.wrong.insert({view.image, seen.id});
  }
}

// Two boards; from view `first` to before `last` the second one hangs `by` off its stated place.
inline SpoiledWorld moved_board(const Lens& lens, std::uint64_t seed, int num_views, int first,
                                int last, const Pose& by) {
  SpoiledWorld world;
  Dataset& dataset = world.dataset;
  dataset.image_size = {1280, 800};
  dataset.boards = {
      {make_board(AprilGrid{4, 4, 0.08, 0.3, 0}), Pose(exp_rotation({0, -0.7, 0}), {-0.45, 0, 0})},
      {make_board(AprilGrid{4, 4, 0.08, 0.3, 16}), Pose(exp_rotation({0, 0.7, 0}), {0, 0, 0.1})}};
  auto moved = dataset.boards;
  moved[1].world_from_board = moved[1].world_from_board * by;
  Random random(seed);
  for (int i = 0; i < num_views; ++i) {
    const bool off = i >= first && i < last;
    std::vector<TargetPoint> points;
    for (const auto& [id, position] : points_in_world(off ? moved : dataset.boards))
      points.push_back({id, position});
    const Pose pose = looking_at_board({0, 0.2, 0}, random.uniform(0, 0.7), 1.1, random);
    View view = observe({lens, dataset.image_size}, pose, points, {}, random);
    view.image = std::to_string(i) + ".png";
    for (const Observation& seen : view.observations)
      if (off && seen.id.tag_id >= 16) world.wrong.insert({view.image, seen.id});
    dataset.views.push_back(view);
  }
  return world;
}

// A world whose file says one thing and whose board is another: `moved` gives the place of a corner
// in truth.
inline Dataset seen_otherwise(Dataset world, const WorldOptions& options,
                              const std::function<void(TargetPoint&)>& moved,
                              std::uint64_t seed = 11) {
  auto points = target_points(world.boards[0].board);
  for (TargetPoint& p : points) moved(p);
  Random random(seed);
  for (View& view : world.views) {
    const std::string image = view.image;
    view = observe(world.truth->camera, world.truth->camera_from_world.at(image), points, options,
                   random);
    view.image = image;
  }
  return world;
}

inline Dataset made_of(Dataset world, const Substrate& substrate) {
  world.boards[0].board.substrate = substrate;
  return world;
}

}  // namespace tagcal
