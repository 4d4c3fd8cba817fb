// Which model `auto` chooses against the one that made the data. Usage: model_confusion [SETS]
// A set counts where its model is needed: fitted with the next smaller model, some corner moves by
// more than 0.3 px, and by more than five posterior standard deviations can be: then the sum of
// squares grows by 25 sigma^2 at least (Cauchy-Schwarz).

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

constexpr std::array<const char*, 8> kModels = {"f",       "f+c",     "pinhole", "radial1",
                                                "radial2", "opencv5", "opencv8", "fisheye4"};
const std::map<std::string, std::string> kBelow = {
    {"f+c", "f"},           {"pinhole", "f+c"},     {"radial1", "f+c"},     {"radial2", "radial1"},
    {"opencv5", "radial2"}, {"opencv8", "opencv5"}, {"fisheye4", "opencv5"}};

Lens random_lens(const std::string& model, Random& random) {
  const double f = random.uniform(700, 1100);
  if (model == "f") return pinhole(f, f, 639.5, 399.5);
  const double cx = 639.5 + 15 * random.normal(), cy = 399.5 + 15 * random.normal();
  if (model == "f+c") return pinhole(f, f, cx, cy);
  const double sign = random.uniform() < 0.5 ? -1 : 1;
  const double fy = f * (1 + sign * random.uniform(0.002, 0.01));
  if (model == "pinhole") return pinhole(f, fy, cx, cy);
  const double k1 = random.uniform(-0.3, 0.05), k2 = random.uniform(-0.05, 0.15);
  if (model == "radial1") return Perspective({f, f, cx, cy, k1});
  if (model == "radial2") return Perspective({f, f, cx, cy, k1, k2});
  const double p1 = 1e-3 * random.normal(), p2 = 1e-3 * random.normal();
  if (model == "opencv5")
    return Perspective({f, fy, cx, cy, k1, k2, p1, p2, random.uniform(-0.05, 0.05)});
  if (model == "opencv8") {
    const double k4 = random.uniform(0.2, 0.8), k5 = random.uniform(0, 0.2);
    return Perspective({0.6 * f, 0.6 * fy, cx, cy, k4 - random.uniform(0.1, 0.3), k5, p1, p2, 0.01,
                        k4, k5, random.uniform(0, 0.03)});
  }
  return Fisheye({0.45 * f, 0.45 * fy, cx, cy, random.uniform(-0.03, 0.03),
                  random.uniform(-0.01, 0.01), 0.002, -0.0005});
}

double largest_move(const Dataset& set, const Calibration& a, const Calibration& b) {
  const auto points = points_in_world(set.boards);
  double largest = 0;
  for (const CalibratedView& in_a : a.views) {
    for (const CalibratedView& in_b : b.views) {
      if (in_a.image != in_b.image) continue;
      for (const auto& [id, x] : points) {
        const auto p = project(a.camera->lens, in_a.camera_from_world * x);
        const auto q = project(b.camera->lens, in_b.camera_from_world * x);
        if (!p || !q || !contains(set.image_size, *p)) continue;
        largest = std::max(largest, (*p - *q).norm());
      }
    }
  }
  return largest;
}

// Whether the smaller model visibly fails on the set.
bool needs(const std::string& model, const Dataset& set, double sigma_px) {
  const auto below = kBelow.find(model);
  if (below == kBelow.end()) return true;
  CalibrateOptions options;
  options.reject_outliers = false;
  options.model = model;
  const Calibration large = calibrate(set, options);
  options.model = below->second;
  const Calibration small = calibrate(set, options);
  if (large.status != Status::ok || !small.camera) return false;
  const double gain = small.num_corners * small.rms_px * small.rms_px -
                      large.num_corners * large.rms_px * large.rms_px;
  return largest_move(set, large, small) > 0.3 && gain > 25 * sigma_px * sigma_px;
}

int order(const std::string& model) {
  for (std::size_t i = 0; i < kModels.size(); ++i)
    if (model == kModels[i]) return static_cast<int>(i);
  return -1;
}

void print(const std::map<std::string, std::map<std::string, int>>& table) {
  std::printf("%-10s", "truth");
  for (const char* model : kModels) std::printf("%9s", model);
  std::printf("%9s%9s\n", "weak", "refused");
  int all = 0, right = 0, larger = 0;
  for (const char* truth : kModels) {
    std::printf("%-10s", truth);
    const auto row = table.find(truth);
    for (const char* chosen : {"f", "f+c", "pinhole", "radial1", "radial2", "opencv5", "opencv8",
                               "fisheye4", "weak", "refused"}) {
      const int n =
          row == table.end() || !row->second.contains(chosen) ? 0 : row->second.at(chosen);
      std::printf("%9d", n);
      all += n;
      right += std::string(truth) == chosen ? n : 0;
      if (order(chosen) > order(truth)) larger += n;
    }
    std::printf("\n");
  }
  std::printf("sets %d, right %.1f %%, larger %.1f %%\n", all, 100.0 * right / all,
              100.0 * larger / all);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  using namespace tagcal;
  const int wanted = argc > 1 ? std::atoi(argv[1]) : 500;
  std::map<std::string, std::map<std::string, int>> table;
  int counted = 0;
  for (int seed = 1; counted < wanted; ++seed) {
    Random random(2026, static_cast<std::uint64_t>(seed));
    const std::string model = kModels[random.index(kModels.size())];
    WorldOptions options;
    options.num_views = 6 + static_cast<int>(random.index(15));
    options.sigma_px = random.uniform(0.05, 0.5);
    const Lens lens = random_lens(model, random);
    const bool wide = model == "fisheye4" || model == "opencv8";
    options.min_distance_m = wide ? 0.35 : 0.6;
    options.max_distance_m = wide ? 0.8 : 1.2;
    const Dataset set = make_world(lens, static_cast<std::uint64_t>(seed), options);
    if (!needs(model, set, options.sigma_px)) continue;
    ++counted;
    const Calibration c = calibrate(set);
    const std::string chosen = is_answer(c.status) || c.model == "weak" ? c.model : "refused";
    ++table[model][chosen];
    if (chosen == model) continue;
    std::fprintf(stderr, "seed %d sigma %.2f views %d: %s -> %s (%s)\n", seed, options.sigma_px,
                 options.num_views, model.c_str(), c.model.c_str(),
                 std::string(status_name(c.status)).c_str());
    for (const ModelStep& s : c.steps)
      std::fprintf(stderr, "   %-9s bic %.1f diff %.3f %s\n", s.model.c_str(), s.bic,
                   s.difference_px.value_or(-1), s.sentence.c_str());
  }
  print(table);
}
