// Random rigs with defects: what calibrate_rig answers, and whether its claims hold
// (docs/trust/how_sure.md).
// 2 to 6 cameras, 10 to 50 instants, noise of 0.03 to 0.5 px. Wrong: a number that is stated with a
// standard deviation is beyond 5 of them, silently so if no warning says why. NEES: of all
// extrinsics, over their number; of rows: the vertical disparities of a rectified pair.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "rig_worlds.hpp"
#include "studies/studies.hpp"
#include "study/processor_time.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/reproject/rectify.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr double kWrongSd = 5;

// A rig, and whether it should have an answer.
struct RigProblem {
  RigDataset rig;
  RigOptions options;
  bool is_right = true;
  std::vector<double> offset;  // as in RigWorldOptions
};
using DrawRig = std::function<RigProblem(std::uint64_t seed, Random& random)>;

RigWorldOptions usual_rig(Random& random) {
  RigWorldOptions world;
  world.num_cameras = 2 + static_cast<int>(random.uniform(0, 4.999));
  world.num_instants = 10 + static_cast<int>(random.uniform(0, 40));
  world.sigma_px = std::exp(random.uniform(std::log(0.03), std::log(0.5)));
  world.with_covariances = random.uniform() < 0.5;
  world.smooth = random.uniform() < 0.5;
  world.seen_share = random.uniform(0.6, 1);
  return world;
}

// The usual rig after a change of its options.
DrawRig changed(bool is_right, const std::function<void(RigWorldOptions&, Random&)>& change,
                const Board& board = usual_board()) {
  return [=](std::uint64_t seed, Random& random) {
    RigWorldOptions world = usual_rig(random);
    change(world, random);
    return RigProblem{make_rig_world(seed, world, board), {}, is_right, world.offset};
  };
}

int other_than_first(const RigWorldOptions& world, Random& random) {
  return 1 + static_cast<int>(random.uniform(0, world.num_cameras - 1.001));
}

void set_few_instants(RigWorldOptions& world, Random& random) {
  world.num_instants = 3 + static_cast<int>(random.uniform(0, 7));
}

// A camera whose pictures are later by a part of the time between instants, or by whole ones.
void set_out_of_time(RigWorldOptions& world, Random& random) {
  world.smooth = true;
  world.offset.assign(static_cast<std::size_t>(world.num_cameras), 0);
  const double sign = random.uniform() < 0.5 ? -1 : 1;
  world.offset[static_cast<std::size_t>(other_than_first(world, random))] =
      sign * (random.uniform() < 0.5 ? random.uniform(0.05, 1) : std::ceil(random.uniform(0, 3)));
}

void set_moved_camera(RigWorldOptions& world, Random& random) {
  world.moved_camera = other_than_first(world, random);
  world.moved_m = std::exp(random.uniform(std::log(0.001), std::log(0.05)));
}

void set_turned_boards(RigWorldOptions& world, Random& random) {
  world.turned_share = random.uniform(0, 0.5);
}

// Cameras that are given, with the pictures of two of them exchanged; half of the rigs have cameras
// of two sizes.
RigProblem exchanged_folders(std::uint64_t seed, Random& random) {
  RigWorldOptions world = usual_rig(random);
  RigProblem problem{make_rig_world(seed, world), {}, false, {}};
  problem.options.lenses = RigLenses::fixed;
  std::vector<RigCamera>& cameras = problem.rig.cameras;
  const auto other = static_cast<std::size_t>(other_than_first(world, random));
  if (random.uniform() < 0.5) {
    Dataset& data = cameras[other].data;
    data.image_size = data.truth->camera.image_size = {1280, 960};
  }
  for (const RigCamera& camera : cameras)
    problem.options.known.push_back({{nullptr, camera.data.truth->camera, {}}, 0});
  std::swap(problem.options.known[0], problem.options.known[other]);
  return problem;
}

// A camera that sees the board only at instants at which no other camera does.
RigProblem missing_overlap(std::uint64_t seed, Random& random) {
  RigWorldOptions world = usual_rig(random);
  world.num_instants *= 2;
  RigProblem problem{make_rig_world(seed, world), {}, false, {}};
  const auto alone = static_cast<std::size_t>(random.uniform(0, world.num_cameras - 0.001));
  for (std::size_t t = 0; t < problem.rig.instants.size(); ++t)
    for (std::size_t c = 0; c < problem.rig.cameras.size(); ++c)
      if ((c == alone) != (t % 2 == 0)) problem.rig.instants[t].view[c].reset();
  return problem;
}

// Two cameras without a common view, on a body that turns about one axis or about all.
DrawRig turning(int num_axes) {
  return [=](std::uint64_t seed, Random& random) {
    const int num_instants = 15 + static_cast<int>(random.uniform(0, 35));
    const double sigma_px = std::exp(random.uniform(std::log(0.03), std::log(0.5)));
    RigProblem problem{back_to_back(num_axes, seed, num_instants, sigma_px), {}, num_axes > 1, {}};
    problem.options.find_boards = true;
    return problem;
  };
}

// The numbers that an answer states with a standard deviation: the places of the cameras, the
// baselines and the offsets of clocks.
struct StatedNumbers {
  int count = 0, wrong = 0;

  void add(double error, double sigma) {
    ++count;
    wrong += !(std::abs(error) <= kWrongSd * sigma);
  }
};

StatedNumbers numbers_of(const RigProblem& problem, const RigCalibration& answer) {
  StatedNumbers numbers;
  const std::vector<Pose>& truth = problem.rig.truth->camera_from_rig;
  for (const ClockOffset& clock : answer.clocks)
    if (!problem.offset.empty())
      numbers.add(clock.offset - problem.offset[clock.camera] + problem.offset[0], clock.sigma);
  if (!is_answer(answer.status)) return numbers;
  for (std::size_t c = 1; c < answer.cameras.size(); ++c) {
    const RigCameraEstimate& camera = answer.cameras[c];
    const Vector6d error = minus(truth[c], camera.camera_from_rig);
    for (int i = 0; i < 6; ++i) numbers.add(error[i], std::sqrt(camera.covariance(i, i)));
  }
  for (const RigPair& pair : answer.pairs)
    numbers.add(pair.baseline_m - (truth[pair.b] * truth[pair.a].inverse()).translation().norm(),
                pair.sigma_baseline_m);
  return numbers;
}

bool warns(const RigCalibration& answer) {
  return std::ranges::any_of(answer.findings, [](const Finding& f) {
    return f.severity == Severity::warning && f.code != "corner_order_differs";
  });
}

// Points that the first two cameras see, through their rectification by the answer: the squared
// differences of their rows over what the rig claims, 0.3 to 30 m away.
double nees_of_rows(const RigProblem& problem, const RigCalibration& answer, Random& random) {
  constexpr int kPoints = 20, kTries = 2000;
  const KnownRig known = known_rig(answer);
  RectifiedPair pair;
  try {
    pair = rectify(known, 0, 1);
  } catch (const Error&) {
    return std::nan("");  // the cameras look in other directions
  }
  double sum = 0;
  int count = 0;
  for (int i = 0; i < kTries && count < kPoints; ++i) {
    const double z = std::exp(random.uniform(std::log(0.3), std::log(30)));
    const Eigen::Vector3d x(z * random.uniform(-0.8, 0.8), z * random.uniform(-0.5, 0.5), z);
    std::array<UncertainPixel, 2> seen;
    bool is_seen = true;
    for (std::size_t c = 0; c < 2 && is_seen; ++c) {
      const Camera& camera = problem.rig.cameras[c].data.truth->camera;
      const auto pixel = project(camera.lens, problem.rig.truth->camera_from_rig[c] * x);
      is_seen = pixel && contains(camera.image_size, *pixel);
      if (is_seen) seen[c].pixel = *pixel;
    }
    const auto rows = is_seen ? vertical_disparity(known, pair, seen) : std::nullopt;
    if (!rows) continue;
    sum += std::pow(rows->difference_px / rows->sigma_of_rig_px, 2);
    ++count;
  }
  return count > 0 ? sum / count : std::nan("");
}

std::vector<Values> measure_rig(const DrawRig& draw, std::uint64_t seed) {
  Random random(seed, 5);
  const RigProblem problem = draw(seed, random);
  RigCalibration answer;
  const double us = processor_us([&] { answer = calibrate_rig(problem.rig, problem.options); });
  const StatedNumbers numbers = numbers_of(problem, answer);
  const bool answered = is_answer(answer.status), warned = warns(answer);
  std::string what(status_name(answer.status));
  if (answered && numbers.wrong > 0) what = warned ? "warned" : "wrong";
  const double nees = answered && !warned ? nees_of_extrinsics(problem.rig, answer) : std::nan("");
  return {{what, static_cast<double>(numbers.count),
           static_cast<double>(answered && warned ? 0 : numbers.wrong),
           problem.is_right ? static_cast<double>(!answered) : std::nan(""), nees,
           answered && !warned ? nees_of_rows(problem, answer, random) : std::nan(""), 1e-3 * us}};
}

// "3 of 120", of the rigs that should have an answer.
Figure refused_right_rigs() {
  return {"right data refused", [](const Sample& sample) {
            const std::vector<double> refused = sample.numbers("refused");
            return refused.empty()
                       ? std::string("none is right")
                       : fmt::format("{} of {}", std::ranges::count(refused, 1.0), refused.size());
          }};
}

Task rigs_task(const std::string& name, const DrawRig& draw) {
  return {name, [draw](std::uint64_t seed) { return measure_rig(draw, seed); }};
}

}  // namespace

Study rigs_study() {
  return {.name = "rigs",
          .summary = "random rigs with defects: answers, and whether their claims hold",
          .count = 1000,
          .columns = {"answer", "numbers", "wrong", "refused", "nees", "nees_rows", "ms"},
          .tasks =
              [](const StudyOptions&) {
                const auto as_it_is = [](RigWorldOptions&, Random&) {};
                const Board checkers = make_board(Checkerboard{8, 6, 0.06, 0.06});
                return std::vector<Task>{
                    rigs_task("no defect", changed(true, as_it_is)),
                    rigs_task("few instants", changed(true, set_few_instants)),
                    rigs_task("no common view", turning(3)),
                    rigs_task("wheel", turning(1)),
                    rigs_task("out of time", changed(false, set_out_of_time)),
                    rigs_task("camera moved", changed(true, set_moved_camera)),
                    rigs_task("boards turned", changed(true, set_turned_boards, checkers)),
                    rigs_task("wrong pairs",
                              changed(false, [](auto& world, auto&) { world.shuffled = true; })),
                    rigs_task("folders exchanged", exchanged_folders),
                    rigs_task("no overlap", missing_overlap)};
              },
          .tables = {
              {{"task"},
               {rows_in("rigs"), counts_of("answers", "answer"), sum_of("numbers", "numbers"),
                sum_of("silently wrong", "wrong"), refused_right_rigs(), mean_of("NEES", "nees", 2),
                mean_of("NEES of rows", "nees_rows", 2), mean_of("CPU ms", "ms", 0)}}}};
}

}  // namespace tagcal
