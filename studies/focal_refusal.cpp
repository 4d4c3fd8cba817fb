// How often a focal length that cannot be known is refused. Usage: focal_refusal [SEEDS]
// Fronto-parallel views, one frontal view, and a 300,000 px lens at 400 m, each with several
// models; and two sets in which it is known, which must be answered.

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

Dataset views(int num_views, double max_tilt_deg, int seed) {
  WorldOptions options;
  options.num_views = num_views;
  options.max_tilt_deg = max_tilt_deg;
  return make_world(pinhole(900, 900, 639.5, 399.5), static_cast<std::uint64_t>(seed), options);
}

Dataset long_lens(int seed) {
  WorldOptions options;
  options.num_views = 5;
  options.min_distance_m = 400;
  options.max_distance_m = 420;
  return make_world(pinhole(300'000, 300'000, 639.5, 399.5), static_cast<std::uint64_t>(seed),
                    options);
}

Dataset one_tilted(int seed) {
  WorldOptions options;
  options.num_views = 1;
  options.min_tilt_deg = 30;
  return make_world(pinhole(900, 900, 639.5, 399.5), static_cast<std::uint64_t>(seed), options);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  using namespace tagcal;
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 1000;
  const std::pair<const char*, std::function<Dataset(int)>> sets[] = {
      {"10 frontal views", [](int seed) { return views(10, 0, seed); }},
      {"1 frontal view", [](int seed) { return views(1, 0, seed); }},
      {"300,000 px at 400 m", [](int seed) { return long_lens(seed); }},
      {"1 view tilted 30-50 deg", [](int seed) { return one_tilted(seed); }},
      {"5 views tilted 0-50 deg", [](int seed) { return views(5, 50, seed); }}};
  for (const auto& [name, make] : sets) {
    for (const char* model : {"auto", "f", "opencv5", "opencv8", "fisheye4"}) {
      std::map<std::string, int> count;
      for (int seed = 1; seed <= seeds; ++seed) {
        CalibrateOptions options;
        options.model = model;
        const Dataset set = make(seed);
        const Calibration c = calibrate(set, options);
        std::string what = c.model + " " + std::string(status_name(c.status));
        if (is_answer(c.status)) {
          const double truth = parameters(set.truth->camera.lens)[0];
          const double error = std::abs(parameters(c.camera->lens)[0] - truth) / c.sigmas[0];
          what += error > 4 ? " and beyond 4 sd" : "";
        }
        ++count[what];
      }
      std::printf("%-24s --model %-5s", name, model);
      for (const auto& [what, n] : count) std::printf(" %s: %d;", what.c_str(), n);
      std::printf("\n");
      std::fflush(stdout);
    }
  }
}
