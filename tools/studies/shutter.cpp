// The finding rolling_shutter, and the focal length of cameras that moved while their rows were
// read (docs/trust/how_sure.md). Every seed has its own 20 views, velocities and noise of 0.2 px.
// Worlds of a global shutter have errors that the model does not have: a smooth field of the lens,
// corners of the board that are not where its file says, a skew of the sensor, smooth fields of
// single views. The velocities of a moving camera are normal, each axis moves the corners alike.
// At 6 sd they are so small that the expected likelihood ratio is that of a normal variable which
// is off by 6 standard deviations (MotionEffect); else the corners move by the stated pixels (root
// mean square) during the readout. Films are of 2 s, with the times of their pictures (`film`), or
// along half a ring about the board (`ring_film`); found is there a readout that is taken out. f:
// against cv::calibrateCamera on the same corners.

#include <cmath>
#include <numbers>
#include <opencv2/core/utility.hpp>

#include "rolling_worlds.hpp"
#include "studies/studies.hpp"
#include "study/peers/opencv_views.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr double kSigmaPx = 0.2, kReadout = 0.02;

// A wave over the plane, along both axes, of random direction, length and phase.
class Wave {
 public:
  Wave(double size, double amplitude, Random& random) {
    for (Axis& axis : axes_) {
      const double turn = random.uniform(0, 2 * std::numbers::pi);
      const double length = size * random.uniform(0.5, 1.5);
      axis.by = 2 * std::numbers::pi / length * Eigen::Vector2d(std::cos(turn), std::sin(turn));
      axis.phase = random.uniform(0, 2 * std::numbers::pi);
      axis.amplitude = amplitude * random.uniform(-1, 1);
    }
  }

  Eigen::Vector2d at(const Eigen::Vector2d& x) const {
    const auto value = [&](const Axis& a) { return a.amplitude * std::sin(a.by.dot(x) + a.phase); };
    return {value(axes_[0]), value(axes_[1])};
  }

 private:
  struct Axis {
    Eigen::Vector2d by;
    double phase = 0, amplitude = 0;
  };
  Axis axes_[2];
};

enum class Kind {
  exact,
  lens_error,
  board_error,
  skew,
  view_errors,
  six_sd,
  moving,
  film,
  bent_film,
  ring
};

struct FilmCase {
  const char* name;
  Kind kind;
  double motion_px = 0;
  double readout_s = 0;  // of a film
};

// A board whose corners are off by 0.1 mm, at random, and by a wave of up to 0.3 mm.
Dataset with_board_error(Dataset world, Random& random) {
  const Wave wave(0.7, 3e-4, random);
  std::map<CornerId, Eigen::Vector3d> shifts;
  const auto points = points_in_world(world.boards);
  for (const auto& [id, x] : points) {
    shifts[id].head<2>() =
        wave.at(x.head<2>()) + 1e-4 * Eigen::Vector2d(random.normal(), random.normal());
    shifts[id].z() = 0;
  }
  for (View& view : world.views)
    for (Observation& o : view.observations)
      o.pixel = *project(world.truth->camera.lens, world.truth->camera_from_world.at(view.image) *
                                                       (points.at(o.id) + shifts[o.id]));
  return world;
}

Dataset with_lens_error(Dataset world, Random& random) {
  const Wave wave(1280, 0.3, random);
  for (View& view : world.views)
    for (Observation& o : view.observations) o.pixel += wave.at(o.pixel);
  return world;
}

Dataset with_skew(Dataset world, double skew) {
  for (View& view : world.views)
    for (Observation& o : view.observations) o.pixel.x() += skew * (o.pixel.y() - 400);
  return world;
}

Dataset moving(const FilmCase& c, const Dataset& still, Random& random) {
  const double distance_m = 1.1, focal_px = 900;  // of the worlds
  Vector6d unit;
  unit << Eigen::Vector3d::Constant(1 / focal_px), Eigen::Vector3d::Constant(distance_m / focal_px);
  const MotionEffect effect(still, unit);
  const double scale =
      c.kind == Kind::six_sd ? effect.scale_at(6, kSigmaPx) : c.motion_px / effect.motion_px();
  return rolling_world(still,
                       random_velocities(still.views.size(), scale * unit[0] / kReadout,
                                         scale * unit[3] / kReadout, random),
                       kReadout);
}

Dataset make_case(const FilmCase& c, std::uint64_t seed) {
  WorldOptions options;
  options.sigma_px = 0;
  const Dataset still = make_world(opencv5_lens(), seed, options);
  Random random(seed, 7);
  switch (c.kind) {
    case Kind::exact:
      return still;
    case Kind::lens_error:
      return with_lens_error(still, random);
    case Kind::board_error:
      return with_board_error(still, random);
    case Kind::skew:
      return with_skew(still, 0.003);
    case Kind::view_errors:
      return with_fields(still, 0.3, seed);
    default:
      return moving(c, still, random);
  }
}

std::vector<Values> measured(const Dataset& set, const CalibrateOptions& options, bool moves,
                             double true_readout_s) {
  const Calibration r = calibrate(set, options);
  if (!is_answer(r.status)) return {{0., NAN, NAN, NAN, NAN, NAN, NAN, NAN}};
  const bool is_found = options.times_s.empty()
                            ? std::ranges::count(r.findings, "rolling_shutter", &Finding::code) > 0
                            : r.readout && r.readout->is_seen;
  const double found = is_found ? 100 : 0;
  const Lens truth = opencv5_lens();
  const auto error2 = [&](double fx) { return std::pow(fx - parameters(truth)[0], 2); };
  const double own = error2(parameters(r.camera->lens)[0]), claim = r.sigmas[0] * r.sigmas[0];
  Values values{1., found, own, claim, own / claim, NAN, NAN, NAN};
  if (moves) {
    OpenCvViews opencv(set);
    opencv.calibrate(0);
    values[5] = error2(opencv.values()[0]);
  }
  if (r.readout) {
    const double error_ms2 = std::pow(1e3 * (r.readout->seconds - true_readout_s), 2);
    values[6] = error_ms2;
    values[7] = error_ms2 / std::pow(1e3 * r.readout->sigma_s, 2);
  }
  return {values};
}

std::vector<Values> measure(const FilmCase& c, std::uint64_t seed) {
  CalibrateOptions options;
  options.model = "opencv5";
  if (c.kind < Kind::film)
    return measured(with_noise(make_case(c, seed), kSigmaPx, seed), options, c.kind >= Kind::six_sd,
                    NAN);
  constexpr int kNumViews = 60;
  const auto direction = c.readout_s < 0 ? ReadDirection::up : ReadDirection::down;
  Film exact = c.kind == Kind::ring ? ring_film(c.readout_s, kNumViews)
                                    : film(seed, std::abs(c.readout_s), direction, kNumViews);
  Random random(seed, 7);
  if (c.kind == Kind::bent_film) exact.dataset = with_lens_error(exact.dataset, random);
  options.times_s = exact.times_s;
  return measured(with_noise(exact.dataset, kSigmaPx, seed), options, c.readout_s != 0,
                  c.readout_s);
}

std::vector<Task> shutter_tasks(const StudyOptions&) {
  cv::setNumThreads(1);
  std::vector<Task> tasks;
  for (const FilmCase& c :
       {FilmCase{"global", Kind::exact}, FilmCase{"global, lens error", Kind::lens_error},
        FilmCase{"global, board error", Kind::board_error}, FilmCase{"global, skew", Kind::skew},
        FilmCase{"global, fields of views", Kind::view_errors},
        FilmCase{"rolling, 6 sd", Kind::six_sd}, FilmCase{"rolling, 2 px", Kind::moving, 2},
        FilmCase{"rolling, 5 px", Kind::moving, 5}, FilmCase{"rolling, 10 px", Kind::moving, 10},
        FilmCase{"rolling, 20 px", Kind::moving, 20}, FilmCase{"film, global", Kind::film},
        FilmCase{"film, 30 ms", Kind::film, 0, 0.03},
        FilmCase{"film, -15 ms", Kind::film, 0, -0.015},
        FilmCase{"film, global, lens error", Kind::bent_film},
        FilmCase{"film, ring, 20 ms", Kind::ring, 0, 0.02}})
    tasks.push_back({c.name, [c](std::uint64_t seed) { return measure(c, seed); }});
  return tasks;
}

}  // namespace

Study shutter_study() {
  return {
      .name = "shutter",
      .summary = "rolling shutters: what is found, and the focal length under motion",
      .count = 1000,
      .columns = {"answer", "found", "f2", "f2_claim", "nees", "f2_opencv", "ms2", "nees_readout"},
      .tasks = shutter_tasks,
      .tables = {{{"task"},
                  {rows_in("worlds"), sum_of("answers", "answer"), mean_of("found, %", "found", 2),
                   root_ratio_of("error of fx, px", "f2", "answer", 2),
                   root_ratio_of("claimed sd : error", "f2_claim", "f2", 2),
                   mean_of("NEES of fx", "nees", 2),
                   root_ratio_of("error : OpenCV's", "f2", "f2_opencv", 2),
                   root_ratio_of("error of the readout, ms", "ms2", "answer", 3),
                   mean_of("NEES of the readout", "nees_readout", 2)}}}};
}

}  // namespace tagcal
