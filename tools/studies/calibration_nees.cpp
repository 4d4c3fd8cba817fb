// Compares claimed covariances of calibrations with their errors, with the true model
// (docs/trust/how_sure.md).
//   calibration_nees [SEEDS, default 2000 [FIRST_SEED, default 1]]
// Every seed has its own views and noise. sqrt(NEES / p), 1 where the covariance is that of the
// errors: of the p free parameters, of the first view's pose, and of the projection at infinity
// over the region of the corners (claims and errors averaged alike). f: root mean square of the
// claimed standard deviation over that of the errors of fx.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

namespace tagcal {
using namespace internal;
namespace {

struct Case {
  const char* model;
  Lens lens;
  bool corner_covariances = false;  // each corner has its own, of random size and direction
};

WorldOptions world_options(const Case& c) {
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

struct Sums {
  int seeds = 0, answers = 0;
  double parameters = 0, pose = 0, projection = 0, projection_claimed = 0;
  double focal = 0, focal_claimed = 0;
};

void add(Sums& sums, const Dataset& set, const Case& c) {
  CalibrateOptions options;
  options.model = c.model;
  options.distances_m = {kInfinitelyFar};
  const Calibration r = calibrate(set, options);
  ++sums.seeds;
  if (!is_answer(r.status)) return;
  ++sums.answers;
  sums.parameters +=
      normalised_squared_error(Model::named(c.model), r.camera->lens, c.lens, r.covariance);
  const CalibratedView& view = r.views.front();
  const Vector6d error = minus(view.camera_from_world, set.truth->camera_from_world.at(view.image));
  sums.pose += error.dot(Eigen::MatrixXd(view.covariance).ldlt().solve(error));
  const auto d =
      lens_difference({c.lens, set.image_size}, *r.camera, r.seen.samples(), kInfinitelyFar);
  if (d) {
    sums.projection += 0.5 * d->rms_px * d->rms_px;
    sums.projection_claimed += r.projection.front().region_px * r.projection.front().region_px;
  }
  const double focal = parameters(r.camera->lens)[0] - parameters(c.lens)[0];
  sums.focal += focal * focal;
  sums.focal_claimed += r.sigmas[0] * r.sigmas[0];
}

// The coefficients of the rational lens (p > 9) are correlated and not compared one by one.
void print(const Case& c, const Sums& sums) {
  const double n = sums.answers;
  const int p = Model::named(c.model).num_free();
  std::printf("%-10s %-7s %7d %8d", c.model, c.corner_covariances ? "own" : "one", sums.seeds,
              sums.answers);
  if (p > 9)
    std::printf("%12s", "-");
  else
    std::printf("%12.3f", std::sqrt(sums.parameters / n / p));
  std::printf("%7.3f%12.3f%8.3f\n", std::sqrt(sums.pose / n / 6),
              std::sqrt(sums.projection / sums.projection_claimed),
              std::sqrt(sums.focal_claimed / sums.focal));
  std::fflush(stdout);
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  using namespace tagcal;
  const int seeds = argc > 1 ? std::atoi(argv[1]) : 2000;
  const int first = argc > 2 ? std::atoi(argv[2]) : 1;
  const Lens rational =
      Perspective({500, 501, 651, 392, 0.5, 0.1, 5e-4, -3e-4, 0.01, 0.8, 0.15, 0.02});
  const std::vector<Case> cases = {{"f", pinhole(900, 900, 639.5, 399.5)},
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
  std::printf("sqrt(mean NEES / p), 10 views of 144 corners, noise 0.3 px or each corner's own\n");
  std::printf("%-10s %-7s %7s %8s %11s %6s %11s %7s\n", "model", "noise", "seeds", "answers",
              "parameters", "pose", "projection", "sd of f");
  for (const Case& c : cases) {
    Sums sums;
    for (int seed = first; seed < first + seeds; ++seed) {
      Dataset set = make_world(c.lens, static_cast<std::uint64_t>(seed), world_options(c));
      if (c.corner_covariances) add_own_noise(set, Random(static_cast<std::uint64_t>(seed), 3));
      add(sums, set, c);
    }
    print(c, sums);
  }
}
