// Measures the corners in pictures and their effect on the calibration (docs/trust/corners.md). An
// input is a scene, which is rendered again for every seed, or a data set that `tagcal render`
// made. Its tags are found with each refinement, and the camera is calibrated with the model of the
// truth; `fit+lens` fits the corners again under the lens that `fit` gave, and calibrates again,
// and `fit+truth` fits them under the true lens. Corners: distance to the truth, RMS per
// coordinate; NEES/2: squared error in claimed variances, 1 where these are right, and how many
// have a Mahalanobis distance beyond 3 and 5. f: claimed standard deviation, RMS and largest error
// in units of it.

#include <fmt/format.h>

#include <memory>

#include "checker_pictures.hpp"
#include "studies/studies.hpp"
#include "study/quantile.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/refine_views.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/scene_file.hpp"

namespace tagcal {
using namespace study;
namespace {

namespace fs = std::filesystem;

// Pictures with their truth.
struct Pictures : ExactPictures {
  Camera camera;
  std::string model;
  std::vector<PlacedBoard> boards;
};

Pictures read(const fs::path& folder) {
  const DatasetFolder set = read_dataset(folder);
  if (!set.dataset.truth) throw Error(folder.string() + ": needs a truth");
  const Truth& truth = *set.dataset.truth;
  Pictures result{{}, truth.camera, truth.model, set.dataset.boards};
  for (const fs::path& file : set.images) {
    const std::string name = file.filename().string();
    result.sources.push_back({name, [file] { return read_image(file); }});
    auto& corners = result.corners.emplace_back();
    for (const auto& [id, point] : points_in_world(set.dataset.boards))
      if (const auto pixel = project(truth.camera.lens, truth.camera_from_world.at(name) * point))
        corners[id] = *pixel;
  }
  return result;
}

struct CornerErrors {
  std::vector<double> distances;  // to the truth, px
  double squares = 0, nees = 0, claims = 0, beyond_3 = 0, beyond_5 = 0, largest = 0;
  std::string worst;  // the corner of the largest Mahalanobis distance

  void add(const Observation& o, const Eigen::Vector2d& truth, const std::string& image) {
    const Eigen::Vector2d error = o.pixel - truth;
    distances.push_back(error.norm());
    squares += error.squaredNorm() / 2;
    if (!o.covariance_px2) return;
    const double square = squared_distance(error, *o.covariance_px2), d = std::sqrt(square);
    ++claims, nees += square / 2;
    beyond_3 += !(d <= 3), beyond_5 += !(d <= 5);  // not a number: no covariance
    if (!(d > largest)) return;
    largest = d;
    worst = fmt::format("{} tag {} corner {}", image, o.id.tag_id, o.id.corner);
  }
};

Values row_of(const std::string& refinement, const Pictures& set, const std::vector<View>& views,
              const Calibration& c) {
  CornerErrors e;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const Observation& o : views[v].observations)
      if (const auto truth = set.corners[v].find(o.id); truth != set.corners[v].end())
        e.add(o, truth->second, views[v].image);
  const double none = std::nan("");
  Values row = {refinement,
                static_cast<double>(e.distances.size()),
                e.squares,
                quantile(e.distances, 0.5),
                quantile(e.distances, 0.999),
                e.claims,
                e.claims > 0 ? e.nees : none,
                e.beyond_3,
                e.beyond_5,
                e.largest,
                e.worst};
  if (!is_answer(c.status)) {
    row.insert(row.end(), {0., none, none});
    return row;
  }
  const double error = parameters(c.camera->lens)[0] - parameters(set.camera.lens)[0];
  row.insert(row.end(), {1., c.sigmas[0], error / c.sigmas[0]});
  return row;
}

std::vector<Values> measure(const Pictures& set) {
  CalibrateOptions options;
  options.model = set.model;
  Dataset dataset{set.camera.image_size, set.boards, {}, {}};
  Calibration c;
  std::vector<Values> rows;
  for (const auto& [name, refinement] : {std::pair{"stock", Refinement::stock},
                                         {"edges", Refinement::edges},
                                         {"fit", Refinement::fit}}) {
    DetectOptions detect;
    detect.threads = 1;
    detect.refinement = refinement;
    dataset.views = views_of(detect_all(set.sources, set.boards, detect));
    c = calibrate(dataset, options);
    rows.push_back(row_of(name, set, dataset.views, c));
  }
  const std::vector<View> found = dataset.views;
  const auto add = [&](const char* name, const Camera& camera) {
    dataset.views = found;
    dataset.views = refine_views(dataset, set.sources, camera).views;
    rows.push_back(row_of(name, set, dataset.views, calibrate(dataset, options)));
  };
  if (is_answer(c.status)) add("fit+lens", *c.camera);
  add("fit+truth", set.camera);
  return rows;
}

std::vector<Task> end_to_end_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  for (const std::string& input : options.inputs) {
    if (fs::is_directory(input)) {
      tasks.push_back({fs::path(input).filename().string(),
                       [input](std::uint64_t) { return measure(read(input)); }, 1});
      continue;
    }
    Scene scene = read_scene(input);
    if (const int views = static_cast<int>(options.number("views")); views > 0)
      scene.num_views = views;
    tasks.push_back(
        {fs::path(input).stem().string(), [scene](std::uint64_t seed) {
           return measure({rendered(scene, seed), scene.camera, scene.model, scene.boards});
         }});
  }
  return tasks;
}

}  // namespace

Study end_to_end_study() {
  return {
      .name = "end_to_end",
      .summary = "corners in pictures, by refinement, and the calibrations that they give",
      .inputs = "scenes, or data sets with a truth",
      .count = 10,
      .options = {{"views", "0", "of a scene; 0: its own number"}},
      .columns = {"corners", "found", "squares", "median_px", "p999_px", "claims", "nees",
                  "beyond_3", "beyond_5", "largest", "worst", "answer", "sd_f", "f_over_sd"},
      .tasks = end_to_end_tasks,
      .tables = {{{"task", "corners"},
                  {sum_of("corners found", "found"), quantile_of("median px", "median_px", .5, 4),
                   root_ratio_of("rms px", "squares", "found", 4),
                   quantile_of("1 in 1,000, px", "p999_px", .5, 3),
                   ratio_of("NEES/2", "nees", "claims", 2), sum_of("> 3", "beyond_3"),
                   sum_of("> 5", "beyond_5"), largest_of("largest", "largest", 1),
                   sum_of("answers", "answer"), mean_of("sd(f) px", "sd_f", 4),
                   rms_of("rms/sd", "f_over_sd", 2), largest_of("largest/sd", "f_over_sd", 2)}}}};
}

}  // namespace tagcal
