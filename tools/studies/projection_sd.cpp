// Compares the predicted uncertainty of the projection with solves with fresh noise
// (docs/trust/how_sure.md).
//   projection_sd [SOLVES, default 5000]

#include <cstdio>
#include <cstdlib>

#include "fresh_noise.hpp"

int main(int argc, char** argv) {
  using namespace tagcal;
  const int solves = argc > 1 ? std::atoi(argv[1]) : 5000;
  const std::pair<const char*, Lens> cases[] = {
      {"f", pinhole(900, 900, 639.5, 399.5)},
      {"radial1", Perspective({900, 900, 651, 392, -0.15})},
      {"opencv5", opencv5_lens()},
      {"fisheye4", fisheye_lens()}};
  std::printf("observed / predicted standard deviation over %d solves, sigma 0.3 px, 10 views\n",
              solves);
  std::printf("%-9s %-9s %8s %8s %8s %8s %8s | predicted: centre, corners (px)\n", "model",
              "distance", "centre", "corner1", "corner2", "corner3", "corner4");
  for (const auto& [name, lens] : cases) {
    WorldOptions options;
    options.num_views = 10;
    options.min_distance_m = name[0] == 'f' && name[1] == 'i' ? 0.35 : 0.6;
    options.max_distance_m = name[0] == 'f' && name[1] == 'i' ? 0.8 : 1.2;
    const Bundle exact = exact_bundle(Model::named(name), lens, 4, options);
    for (const double distance : {kInfinitelyFar, 1.0}) {
      const PredictedAndObserved r = fresh_noise(exact, 0.3, distance, solves);
      const auto& p = r.predicted.sigma_px;
      std::printf("%-9s %-9g %8.3f %8.3f %8.3f %8.3f %8.3f | %.3f %.3f %.3f %.3f %.3f (%d)\n", name,
                  distance, r.ratio(6, 10), r.ratio(0, 0), r.ratio(0, 20), r.ratio(12, 0),
                  r.ratio(12, 20), p(6, 10), p(0, 0), p(0, 20), p(12, 0), p(12, 20), r.solves);
      std::fflush(stdout);
    }
  }
}
