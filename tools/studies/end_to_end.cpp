// Measures the effect of the refinement of corners on the calibration, from pictures to the camera
// (docs/trust/corners.md).
//   end_to_end SCENE.yaml [SEEDS, default 10 [FIRST_SEED, default 1 [VIEWS]]]
// For every seed the scene is rendered, its tags are detected with each refinement, and the camera
// is calibrated with the model of the scene; `fit+lens` fits the corners again under the lens that
// `fit` gave, and calibrates again. Corners: distance to the truth, its median, RMS per coordinate
// and 99.9 % point; NEES/2: squared error in claimed variances, 1 where these are right. f: mean
// claimed standard deviation, RMS and largest error in units of it. NEES/p: of all free parameters.
// gain: sd(f) of `stock` over this one.

#include <cstdio>
#include <cstdlib>
#include <map>

#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/refine_views.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

struct Sums {
  int answers = 0;
  std::vector<double> errors;  // of corners, px
  double corner_nees = 0;
  int num_covariances = 0;
  double sigma = 0, squares = 0, largest = 0, nees = 0;
};

struct Rendered {
  std::vector<ImageSource> sources;
  std::vector<std::map<CornerId, Eigen::Vector2d>> truth;
};

Rendered rendered(const Scene& scene, std::uint64_t seed) {
  const TagFamilies families = tag_families(scene.boards);
  const std::vector<Pose> poses = camera_poses(scene, seed);
  Rendered result;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const ImageF light = render_light(scene, families, poses[i]);
    const Image8 picture = expose(light, scene.sensor, Random(seed, i).next());
    result.sources.push_back({image_name(static_cast<int>(i)), [picture] { return picture; }});
    auto& corners = result.truth.emplace_back();
    for (const Observation& o : visible_corners(scene, poses[i])) corners[o.id] = o.pixel;
  }
  return result;
}

void add(Sums& sums, const Rendered& set, const std::vector<View>& views, const Calibration& c,
         const Scene& scene) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Observation& o : views[v].observations) {
      const auto truth = set.truth[v].find(o.id);
      if (truth == set.truth[v].end()) continue;
      const Eigen::Vector2d error = o.pixel - truth->second;
      sums.errors.push_back(error.norm());
      if (!o.covariance_px2) continue;
      const Eigen::Matrix2d covariance = *o.covariance_px2;
      sums.corner_nees += error.dot(covariance.inverse() * error) / 2;
      ++sums.num_covariances;
    }
  }
  if (!is_answer(c.status)) return;
  ++sums.answers;
  const double error =
      (parameters(c.camera->lens)[0] - parameters(scene.camera.lens)[0]) / c.sigmas[0];
  sums.sigma += c.sigmas[0];
  sums.squares += error * error;
  sums.largest = std::max(sums.largest, std::abs(error));
  const Model& model = Model::named(c.model);
  sums.nees += normalised_squared_error(model, c.camera->lens, scene.camera.lens, c.covariance) /
               model.num_free();
}

int run(int argc, char** argv) {
  if (argc < 2) throw Error("usage: end_to_end SCENE.yaml [SEEDS [FIRST_SEED [VIEWS]]]");
  Scene scene = read_scene(argv[1]);
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 10;
  const int first = argc > 3 ? std::atoi(argv[3]) : 1;
  if (argc > 4) scene.num_views = std::atoi(argv[4]);
  const char* names[] = {"stock", "edges", "fit", "fit+lens"};
  Sums sums[4];
  CalibrateOptions options;
  options.model = scene.model;
  options.distances_m = {kInfinitelyFar};
  for (int s = first; s < first + seeds; ++s) {
    const Rendered set = rendered(scene, static_cast<std::uint64_t>(s));
    Dataset dataset{scene.camera.image_size, scene.boards, {}, {}};
    Calibration c;
    for (const Refinement refinement : {Refinement::stock, Refinement::edges, Refinement::fit}) {
      DetectOptions detect;
      detect.refinement = refinement;
      dataset.views = views_of(detect_all(set.sources, scene.boards, detect));
      c = calibrate(dataset, options);
      add(sums[static_cast<int>(refinement)], set, dataset.views, c, scene);
    }
    if (!is_answer(c.status)) continue;
    dataset.views = refine_views(dataset, set.sources, *c.camera).views;
    add(sums[3], set, dataset.views, calibrate(dataset, options), scene);
  }
  std::printf("%-9s %7s | %8s %8s %8s %7s | %9s %7s %7s %7s %6s\n", "corners", "answers",
              "median px", "rms px", "99.9 %", "NEES/2", "sd(f) px", "rms/sd", "max/sd", "NEES/p",
              "gain");
  for (int i = 0; i < 4; ++i) {
    Sums& n = sums[i];
    std::ranges::sort(n.errors);
    const auto size = static_cast<double>(n.errors.size());
    double squares = 0;
    for (const double e : n.errors) squares += e * e / 2;
    std::printf("%-9s %4d/%-3d | %8.4f %8.4f %8.4f %7.2f | %9.4f %7.2f %7.2f %7.2f %6.1f\n",
                names[i], n.answers, seeds, n.errors[n.errors.size() / 2],
                std::sqrt(squares / size), n.errors[static_cast<std::size_t>(0.999 * size)],
                n.corner_nees / std::max(1, n.num_covariances), n.sigma / n.answers,
                std::sqrt(n.squares / n.answers), n.largest, n.nees / n.answers,
                sums[0].sigma / sums[0].answers / (n.sigma / n.answers));
  }
  return 0;
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  try {
    return tagcal::run(argc, argv);
  } catch (const tagcal::Error& error) {
    std::fprintf(stderr, "end_to_end: %s\n", error.what());
    return 2;
  }
}
