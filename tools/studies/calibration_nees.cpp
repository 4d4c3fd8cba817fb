// Compares claimed covariances of calibrations with their errors, with the true model
// (docs/trust/how_sure.md).
// Every seed has its own views and noise; 10 views of 144 corners. sqrt(NEES / p), 1 where the
// covariance is that of the errors: of the p free parameters, of the first view's pose, and of the
// projection at infinity over the region of the corners (claims and errors averaged alike). f: root
// mean square of the claimed standard deviation over that of the errors of fx.

#include <fmt/format.h>

#include <string>

#include "studies/studies.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace study;
namespace {

struct NoiseCase {
  const char* model;
  Lens lens;
  bool corner_covariances = false;  // each corner has its own, of random size and direction
};

WorldOptions world_options(const NoiseCase& c) {
  WorldOptions options;
  options.num_views = 10;
  const bool wide = std::string(c.model) == "fisheye4" || std::string(c.model) == "opencv8";
  options.min_distance_m = wide ? 0.35 : 0.6;
  options.max_distance_m = wide ? 0.8 : 1.2;
  options.sigma_px = c.corner_covariances ? 0 : 0.3;
  return options;
}

// Standard deviations from 0.1 to 0.6 px along and across a random direction.
void add_own_noise(Dataset& set, Random random) {
  for (View& view : set.views) {
    for (Observation& o : view.observations) {
      const double angle = random.uniform(0, 3.2);
      const Eigen::Vector2d sigmas(random.uniform(0.1, 0.6), random.uniform(0.1, 0.6));
      const Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
      o.pixel += turn * sigmas.cwiseProduct(Eigen::Vector2d(random.normal(), random.normal()));
      o.covariance_px2 = Matrix2(turn * sigmas.cwiseAbs2().asDiagonal() * turn.transpose());
    }
  }
}

// The coefficients of the rational lens (p > 9) are correlated and not compared one by one.
std::vector<Values> measure(const NoiseCase& c, std::uint64_t seed) {
  Dataset set = make_world(c.lens, seed, world_options(c));
  if (c.corner_covariances) add_own_noise(set, Random(seed, 3));
  CalibrateOptions options;
  options.model = c.model;
  const Calibration r = calibrate(set, options);
  const double none = std::nan("");
  if (!is_answer(r.status)) return {{0., none, none, none, none, none, none}};
  const Model& model = Model::named(c.model);
  const int p = model.num_free();
  const double parameters_nees =
      normalised_squared_error(model, r.camera->lens, c.lens, r.covariance);
  const CalibratedView& view = r.views.front();
  const Vector6d error = minus(view.camera_from_world, set.truth->camera_from_world.at(view.image));
  const double pose_nees = error.dot(Eigen::MatrixXd(view.covariance).ldlt().solve(error));
  const auto d =
      lens_difference({c.lens, set.image_size}, *r.camera, r.seen.samples(), kInfinitelyFar);
  const double region_px = r.projection.front().region_px;
  const double focal = parameters(r.camera->lens)[0] - parameters(c.lens)[0];
  return {{1., p > 9 ? none : std::sqrt(parameters_nees / p), std::sqrt(pose_nees / 6),
           d ? 0.5 * d->rms_px * d->rms_px : none, d ? region_px * region_px : none, focal * focal,
           r.sigmas[0] * r.sigmas[0]}};
}

std::vector<Task> calibration_nees_tasks(const StudyOptions&) {
  const Lens rational =
      Perspective({500, 501, 651, 392, 0.5, 0.1, 5e-4, -3e-4, 0.01, 0.8, 0.15, 0.02});
  const std::vector<NoiseCase> cases = {{"f", pinhole(900, 900, 639.5, 399.5)},
                                        {"f+c", pinhole(900, 900, 651, 392)},
                                        {"pinhole", pinhole(900, 896, 651, 392)},
                                        {"radial1", Perspective({900, 900, 651, 392, -0.1})},
                                        {"radial2", Perspective({900, 900, 651, 392, -0.2, 0.08})},
                                        {"opencv5", opencv5_lens()},
                                        {"opencv8", rational},
                                        {"fisheye4", fisheye_lens()},
                                        {"f", pinhole(900, 900, 639.5, 399.5), true},
                                        {"opencv5", opencv5_lens(), true},
                                        {"fisheye4", fisheye_lens(), true}};
  std::vector<Task> tasks;
  for (const NoiseCase& c : cases)
    tasks.push_back({fmt::format("{}{}", c.model, c.corner_covariances ? ", own noise" : ""),
                     [c](std::uint64_t seed) { return measure(c, seed); }});
  return tasks;
}

}  // namespace

Study calibration_nees_study() {
  return {.name = "calibration_nees",
          .summary = "claimed covariances of calibrations against their errors",
          .count = 2000,
          .columns = {"answer", "parameters", "pose", "projection", "projection_claim", "f2",
                      "f2_claim"},
          .tasks = calibration_nees_tasks,
          .tables = {{{"task"},
                      {rows_in("seeds"), sum_of("answers", "answer"),
                       rms_of("parameters", "parameters", 3), rms_of("pose", "pose", 3),
                       root_ratio_of("projection", "projection", "projection_claim", 3),
                       root_ratio_of("sd of f", "f2_claim", "f2", 3)}}}};
}

}  // namespace tagcal
