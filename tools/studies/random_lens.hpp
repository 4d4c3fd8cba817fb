#pragma once

#include <array>
#include <map>
#include <string>

#include "tagcal/estimate/bundle/bundle_adjustment.hpp"
#include "worlds.hpp"

// Random lenses of every model of the ladder, and data sets seen through them.

namespace tagcal {

inline constexpr std::array<const char*, 9> kModels = {
    "f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5", "opencv8", "fisheye4"};

// The next smaller model; empty for the smallest.
inline std::string model_below(const std::string& model) {
  static const std::map<std::string, std::string> below = {
      {"f+c", "f"},           {"pinhole", "f+c"},     {"radial1", "f+c"},
      {"radial2", "radial1"}, {"opencv4", "radial2"}, {"opencv5", "opencv4"},
      {"opencv8", "opencv5"}, {"fisheye4", "opencv5"}};
  const auto found = below.find(model);
  return found == below.end() ? "" : found->second;
}

// `share` scales the parameters that the model has beside the one below it.
inline Lens random_lens(const std::string& model, double share, Random& random) {
  const double f = random.uniform(700, 1100);
  if (model == "f") return pinhole(f, f, 639.5, 399.5);
  const double away = model == "f+c" ? share : 1;
  const double cx = 639.5 + 15 * away * random.normal(), cy = 399.5 + 15 * away * random.normal();
  if (model == "f+c") return pinhole(f, f, cx, cy);
  const double sign = random.uniform() < 0.5 ? -1 : 1;
  const double aspect = sign * random.uniform(0.002, 0.01);
  const double fy = f * (1 + (model == "pinhole" ? share : 1) * aspect);
  if (model == "pinhole") return pinhole(f, fy, cx, cy);
  const double k1 = random.uniform(-0.3, 0.05), k2 = random.uniform(-0.05, 0.15);
  if (model == "radial1") return Perspective({f, f, cx, cy, share * k1});
  if (model == "radial2") return Perspective({f, f, cx, cy, k1, share * k2});
  const double p1 = 1e-3 * random.normal(), p2 = 1e-3 * random.normal();
  if (model == "opencv4")
    return Perspective({f, f * (1 + share * aspect), cx, cy, k1, k2, share * p1, share * p2});
  if (model == "opencv5")
    return Perspective({f, fy, cx, cy, k1, k2, p1, p2, share * random.uniform(-0.05, 0.05)});
  if (model == "opencv8") {
    const double k4 = random.uniform(0.2, 0.8), k5 = random.uniform(0, 0.2);
    return Perspective({0.6 * f, 0.6 * fy, cx, cy, k4 - random.uniform(0.1, 0.3), k5, p1, p2, 0.01,
                        k4, k5, random.uniform(0, 0.03)});
  }
  return Fisheye({0.45 * f, 0.45 * fy, cx, cy, random.uniform(-0.03, 0.03),
                  random.uniform(-0.01, 0.01), 0.002, -0.0005});
}

// A lens and 6 to 20 views with noise of 0.05 to 0.5 px, drawn from a seed.
struct LensWorld {
  explicit LensWorld(std::uint64_t world_seed, bool small_steps = false)
      : seed(world_seed), random(2026, world_seed), lens(pinhole(900, 900, 639.5, 399.5)) {
    model = kModels[random.index(kModels.size())];
    options.num_views = 6 + static_cast<int>(random.index(15));
    options.sigma_px = random.uniform(0.05, 0.5);
    // Log-uniform from 0.01 to 1.
    const double share = small_steps ? std::pow(10.0, random.uniform(-2, 0)) : 1;
    lens = random_lens(model, share, random);
    const bool wide = model == "fisheye4" || model == "opencv8";
    options.min_distance_m = wide ? 0.35 : 0.6;
    options.max_distance_m = wide ? 0.8 : 1.2;
  }

  Dataset make() const { return make_world(lens, seed, options); }

  // True if the model below fails visibly: some corner moves by more than 0.3 px, and the sum of
  // squares grows by more than 25 sigma^2, which is necessary for a move by more than five
  // posterior standard deviations (Cauchy-Schwarz).
  bool needs_model(const Dataset& set) const;

  std::uint64_t seed;
  Random random;
  std::string model;
  WorldOptions options;
  Lens lens;
};

// A world as a problem of a model: the observed pixels, the lens and poses of the truth as its
// start, a flat board and no row terms.
inline internal::Bundle bundle_of(const Dataset& set, const Model& model, double sigma_px) {
  const auto points = points_in_world(set.boards);
  internal::Bundle bundle;
  bundle.model = &model;
  bundle.image_size = set.image_size;
  bundle.free_values = model.free_values(set.truth->camera.lens);
  bundle.sigma = sigma_px;
  for (const View& view : set.views) {
    internal::ViewProblem problem;
    for (const Observation& o : view.observations)
      problem.correspondences.push_back({points.at(o.id), o.pixel});
    bundle.views.push_back(problem);
    bundle.camera_from_target.push_back(set.truth->camera_from_world.at(view.image));
  }
  return bundle;
}

inline double largest_move(const internal::Bundle& a, const internal::Bundle& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.views.size(); ++v) {
    for (const Correspondence& c : a.views[v].correspondences) {
      const auto p = project(a.lens(), a.camera_from_target[v] * c.point);
      const auto q = project(b.lens(), b.camera_from_target[v] * c.point);
      if (p && q) largest = std::max(largest, (*p - *q).norm());
    }
  }
  return largest;
}

inline bool LensWorld::needs_model(const Dataset& set) const {
  const std::string below = model_below(model);
  if (below.empty()) return true;
  internal::Bundle small = bundle_of(set, Model::named(below), options.sigma_px);
  internal::Bundle large = bundle_of(set, Model::named(model), options.sigma_px);
  const double gain = internal::solve(small, 100).cost - internal::solve(large, 100).cost;
  return largest_move(large, small) > 0.3 && gain > 25 * options.sigma_px * options.sigma_px;
}

}  // namespace tagcal
