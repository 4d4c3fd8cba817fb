// Rigs of two cameras with rolling shutters (docs/trust/how_sure.md): lenses, places and readouts
// by films of 60 pictures in 2 s, with a noise of 0.2 px. `ring`: half a ring about the board in
// which the rig also rises and falls; `hand`: each coordinate of the motion is a wave. "Without
// times" is the answer of a rig whose readouts are not looked for. Numbers of cameras are means
// over both.

#include <algorithm>
#include <cmath>

#include "rig_worlds.hpp"
#include "rolling_worlds.hpp"
#include "studies/studies.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr double kRigSigmaPx = 0.2, kRigReadout = 0.02;
constexpr int kNumFrames = 60;

struct RigFilm {
  const char* name;
  bool is_ring = false;
  double readout_s = 0;
  bool has_times = true;
};

double percent_warned(const RigCalibration& rig) {
  return std::ranges::count(rig.findings, Severity::warning, &Finding::severity) > 0 ? 100 : 0;
}

std::vector<Values> measure(const RigFilm& c, std::uint64_t seed) {
  const RigDataset exact =
      rig_film(c.is_ring ? rising_ring(seed) : hand_motion(seed), c.readout_s, kNumFrames);
  RigOptions options;
  options.calibrate.front().model = "opencv5";
  options.find_readouts = c.has_times;
  const RigCalibration rig = calibrate_rig(with_noise(exact, kRigSigmaPx, seed), options);
  if (!is_answer(rig.status)) return {{0., NAN, percent_warned(rig), NAN, NAN, NAN, NAN, NAN, NAN}};
  const Lens truth = opencv5_lens();
  const double share = 1.0 / static_cast<double>(rig.cameras.size());
  double found = 0, fx2 = 0, fx2_claim = 0, nees_fx = 0, ms2 = 0, nees_readout = 0;
  for (const RigCameraEstimate& camera : rig.cameras) {
    const double fx = parameters(camera.camera.camera.lens)[0],
                 sigma = lens_sigmas(camera.camera)[0];
    const double error = fx - parameters(truth)[0];
    const Readout readout = camera.own.readout.value_or(Readout{NAN, NAN});
    const double error_s = readout.seconds - c.readout_s;
    found += share * (readout.is_seen ? 100 : 0);
    fx2 += share * error * error;
    fx2_claim += share * sigma * sigma;
    nees_fx += share * std::pow(error / sigma, 2);
    ms2 += share * 1e6 * error_s * error_s;
    nees_readout += share * std::pow(error_s / readout.sigma_s, 2);
  }
  return {{1., found, percent_warned(rig), fx2, fx2_claim, nees_fx, nees_of_extrinsics(exact, rig),
           ms2, nees_readout}};
}

std::vector<Task> rig_shutter_tasks(const StudyOptions&) {
  std::vector<Task> tasks;
  for (const RigFilm& c : {RigFilm{"ring, global", true}, RigFilm{"ring, 20 ms", true, kRigReadout},
                           RigFilm{"ring, 20 ms, without times", true, kRigReadout, false},
                           RigFilm{"hand, global"}, RigFilm{"hand, 20 ms", false, kRigReadout},
                           RigFilm{"hand, 20 ms, without times", false, kRigReadout, false}})
    tasks.push_back({c.name, [c](std::uint64_t seed) { return measure(c, seed); }});
  return tasks;
}

}  // namespace

Study rig_shutter_study() {
  return {.name = "rig_shutter",
          .summary = "rigs with rolling shutters: what is found, lenses and places",
          .count = 200,
          .columns = {"answer", "found", "warned", "f2", "f2_claim", "nees_f", "nees_places", "ms2",
                      "nees_readout"},
          .tasks = rig_shutter_tasks,
          .tables = {
              {{"task"},
               {rows_in("rigs"), sum_of("answers", "answer"), mean_of("found, %", "found", 2),
                mean_of("with a warning, %", "warned", 2),
                root_ratio_of("error of fx, px", "f2", "answer", 2),
                root_ratio_of("claimed sd : error", "f2_claim", "f2", 2),
                mean_of("NEES of fx", "nees_f", 2), mean_of("NEES of the places", "nees_places", 2),
                root_ratio_of("error of the readout, ms", "ms2", "answer", 3),
                mean_of("NEES of the readout", "nees_readout", 2)}}}};
}

}  // namespace tagcal
