#include "tagcal/estimate/handeye.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/handeye/handeye_consensus.hpp"
#include "tagcal/estimate/handeye/handeye_report.hpp"
#include "tagcal/estimate/handeye/robot_advice.hpp"
#include "tagcal/estimate/handeye/robot_readings.hpp"
#include "tagcal/estimate/policy/handeye_policy.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/internal/stopwatch.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal {
using namespace internal;
namespace {

void check_handeye_input(std::span<const HandeyeView> views, const UncertainCamera& camera,
                         const HandeyeOptions& options) {
  camera.check_covariance();
  if (!(options.sigma_px >= 0) || std::isinf(options.sigma_px))
    throw Error("sigma_px: must be 0 (not known) or more, and finite");
  if (options.find_time_offset && !options.path)
    throw Error("find_time_offset: needs a path of the robot");
  if (options.path) check_path(*options.path);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].base_from_hand.matrix().allFinite())
      throw Error(fmt::format("views[{}]: the robot's pose has a number that is not finite", i));
    if (options.path && !(views[i].time_s && std::isfinite(*views[i].time_s)))
      throw Error(fmt::format("views[{}]: has no time, which a path needs", i));
  }
}

void check_poses(std::span<const HandeyeView> views, const MatrixX& shared) {
  const std::string defect = shared.size() > 0 ? covariance_defect(shared) : "";
  if (!defect.empty()) throw Error("the covariance of what the poses share " + defect);
  for (std::size_t i = 0; i < views.size(); ++i)
    for (const SeenPose& pose : views[i].poses)
      check_seen_pose(pose, shared.cols(), fmt::format("views[{}]", i));
}

// Views of poses alone, which take part if they have one.
std::vector<SeenView> posed_views(std::span<const HandeyeView> views) {
  std::vector<SeenView> seen;
  for (const HandeyeView& v : views) {
    PoseEstimate own;
    for (const SeenPose& pose : v.poses)
      own.hypotheses.push_back({pose.camera_from_target, pose.covariance});
    if (!v.poses.empty()) own.status = Status::ok;
    own.findings = v.findings;
    seen.push_back({v.image, {}, {}, own, v.poses, v.base_from_hand, v.time_s, v.rotation_numbers});
  }
  return seen;
}

std::vector<SeenView> seen_views(std::span<const HandeyeView> views, const Camera& camera,
                                 const HandeyeOptions& options) {
  std::vector<SeenView> seen(views.size());
  PoseOptions pose;
  pose.sigma_px = options.sigma_px;
  parallel_for(views.size(), threads_for_short_calls(views.size(), options.num_threads),
               [&](std::size_t i) {
                 const HandeyeView& v = views[i];
                 seen[i] = {v.image,
                            v.seen.correspondences,
                            v.seen.covariance_px2,
                            estimate_pose(v.seen, camera, pose),
                            {},
                            v.base_from_hand,
                            v.time_s,
                            v.rotation_numbers};
               });
  return seen;
}

// Takes of two poses of a view the one that agrees with the robot.
void choose_hypotheses(HandeyeProblem& problem, const HandeyePlaces& places) {
  for (HandeyeSight& sight : problem.sights)
    std::ranges::sort(sight.own, {}, [&](const SeenPose& own) {
      return disagreement_m(places, problem.mount, problem.scale, own.camera_from_target,
                            sight.base_from_hand);
    });
}

// The number of different robot poses, up to three.
std::size_t num_different(std::span<const HandeyeSight> sights) {
  constexpr double kSame = 1e-6;  // numeric: m and rad, below what any robot reports
  std::vector<Pose> different;
  for (const HandeyeSight& s : sights) {
    const bool known = std::ranges::any_of(
        different, [&](const Pose& p) { return minus(p, s.base_from_hand).norm() < kSame; });
    if (!known && different.size() < 3) different.push_back(s.base_from_hand);
  }
  return different.size();
}

// Robust start, twice: the second time with the poses of ambiguous views that agree with the first.
std::optional<RobustHandeyeStart> start_of(HandeyeSights& sights) {
  std::optional<RobustHandeyeStart> start;
  HandeyeProblem& problem = sights.problem();
  for (int i = 0; i < 2; ++i) {
    start = robust_places(sights.pairs(), problem.mount, problem.scale);
    if (!start) return std::nullopt;
    choose_hypotheses(problem, start->places);
    if (std::ranges::none_of(problem.sights, [](const auto& s) { return s.own.size() > 1; })) break;
  }
  return start;
}

// The offset of time among steps at which the poses of the path agree best with the views.
double coarse_offset(HandeyeSights& sights) {
  constexpr double kLargest = 1, kStep = 0.05;  // numeric: s, a start that the bundle refines
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (double offset = -kLargest; offset < kLargest + kStep / 2; offset += kStep) {
    sights.gather(offset);
    const auto start =
        closed_form_places(sights.pairs(), sights.problem().mount, sights.problem().scale);
    if (!start || !(median(start->disagreements_m) < least)) continue;
    least = median(start->disagreements_m);
    best = offset;
  }
  return best;
}

class HandeyeRun {
 public:
  HandeyeRun(std::vector<SeenView> views, const UncertainCamera& camera,
             const HandeyeOptions& options)
      : options_(options), sights_(std::move(views), camera, options, answer_) {
    answer_.mount = options.mount;
  }

  HandeyeEstimate answer() {
    solve();
    answer_.rejected = sights_.rejected();
    answer_.unusable = sights_.unusable();
    answer_.status = judge(answer_.findings);
    return std::move(answer_);
  }

 private:
  void solve() {
    offset_s_ = options_.find_time_offset ? coarse_offset(sights_) : 0;
    sights_.gather(offset_s_);
    if (is_too_few() || is_read_wrongly()) return;
    auto minimum = minimum_at_offset();
    if (!minimum) return;
    if (options_.path && !options_.find_time_offset && is_off_in_time(minimum->state)) return;
    answer_.rejected = sights_.rejected();
    report_minimum(sights_, *minimum, answer_);
    if (is_scale_free_) add_board_scale(answer_);
    if (is_answer(judge(answer_.findings)) && is_likelier_otherwise(*minimum)) return;
    if (options_.find_time_offset) report_offset(*minimum);
    answer_.next =
        advise_robot_pose(sights_.problem(), minimum->state, minimum->noise.noise, answer_);
  }

  bool is_too_few() {
    if (num_different(sights_.problem().sights) >= 3) return false;
    const std::string why = sights_.why_unusable();
    if (sights_.problem().sights.size() < 3 && !why.empty()) {
      add(answer_.findings, code::degenerate,
          fmt::format("{} of {} views have no pose that can be used, mostly because {}",
                      sights_.unusable().size(),
                      sights_.unusable().size() + sights_.problem().sights.size(), why));
      return true;
    }
    add(answer_.findings, code::degenerate,
        fmt::format("the {} views that can be used have fewer than three different robot poses: "
                    "take ten or more, turned about different axes",
                    sights_.problem().sights.size()));
    return true;
  }

  bool is_read_wrongly() {
    const HandeyeProblem& problem = sights_.problem();
    better_ = better_reading(sights_.pairs(), problem.mount, problem.scale, options_.robot_form);
    if (!better_ || !better_->is_certain) return false;
    refuse_reading(better_->reading);
    return true;
  }

  // A reading that fits better in closed form, but not by as much as is certain: the likelihood of
  // its bundle decides.
  bool is_likelier_otherwise(const HandeyeMinimum& given) {
    if (!better_) return false;
    HandeyeProblem problem = sights_.problem();
    std::vector<HandeyePair> pairs = sights_.pairs();
    for (HandeyePair& pair : pairs) pair.base_from_hand = better_->read(pair);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      problem.sights[i].base_from_hand = pairs[i].base_from_hand;
    const auto start = closed_form_places(pairs, problem.mount, problem.scale);
    const auto other = start ? bundle_of(problem, start->places) : std::nullopt;
    const double likelier = other ? given.objective - other->objective : 0;
    if (!(likelier > policy::kSignificant * policy::kSignificant)) return false;
    const auto freedoms = 6 * static_cast<double>(problem.sights.size()) - 12;
    refuse_reading({better_->reading.change, std::exp(likelier / (2 * std::max(1.0, freedoms)))});
    return true;
  }

  void refuse_reading(const RobotReading& reading) {
    answer_.reading = reading;
    add(answer_.findings, better_->is_shift ? code::not_synchronous : code::wrong_direction,
        fmt::format("the robot's poses fit the pictures {:.{}f} times better if {}: check the file "
                    "and the options, nothing was changed",
                    reading.times_better, reading.times_better < 10 ? 1 : 0, reading.change));
  }

  // The minimum of the views that agree, with the robot's poses at the offset, which is estimated
  // if asked for.
  std::optional<HandeyeMinimum> minimum_at_offset() {
    constexpr int kRounds = 4;       // a limit of work: the offset converges in two
    constexpr double kSmall = 1e-5;  // numeric: s
    std::optional<HandeyeMinimum> minimum;
    for (int i = 0; i < kRounds; ++i) {
      sights_.gather(offset_s_);
      const auto start = start_of(sights_);
      if (!start) return std::nullopt;
      sights_.problem().with_time = options_.find_time_offset;
      minimum = minimum_of_agreeing(*start);
      if (!minimum) return std::nullopt;
      offset_s_ += minimum->state.time_offset_s;
      if (!(std::abs(minimum->state.time_offset_s) > kSmall)) break;
    }
    return minimum;
  }

  // The minimum of the views that agree: with the board's scale free, so that an error of it does
  // not count as noise of the robot, then with its prior, unless they contradict each other.
  std::optional<HandeyeMinimum> minimum_of_agreeing(const RobustHandeyeStart& start) {
    HandeyeProblem& problem = sights_.problem();
    problem.board_scale_sigma = policy::kFreeScale;
    auto found = find_consensus(problem, start, options_.reject_outliers);
    if (found && !keep_agreeing(found->takes_part)) return std::nullopt;
    const double prior = sigma_of_scale(sigma_of_print(options_.print));
    is_scale_free_ = found && is_beyond_prior(found->minimum, prior);
    if (found && is_scale_free_) return std::move(found->minimum);
    problem.board_scale_sigma = prior;
    auto minimum = bundle_of(problem, start.places);
    if (!minimum)
      add(answer_.findings, code::not_converged,
          "the bundle left the lens' domain, or its equations are singular: check that pictures "
          "and poses belong together, and the columns, units and frames of the robot's file");
    return minimum;
  }

  bool keep_agreeing(std::span<const std::uint8_t> takes_part) {
    sights_.keep(takes_part);
    if (!policy::is_above(sights_.rejected().size(), policy::kMinority, takes_part.size()) &&
        sights_.problem().sights.size() >= 3)
      return true;
    add(answer_.findings, code::no_consensus,
        fmt::format("the robot's poses of {} of {} views contradict the others: check that "
                    "pictures and poses belong together, and that the board stood still",
                    sights_.rejected().size(), takes_part.size()));
    return false;
  }

  // With the offset free, it is not zero.
  bool is_off_in_time(const HandeyeState& state) {
    HandeyeProblem problem = sights_.problem();
    problem.with_time = true;
    const auto free = bundle_of(problem, state.places);
    if (!free) return false;
    set_offset(free->state.time_offset_s, *free);
    if (!(std::abs(*answer_.time_offset_s) > policy::kSignificant * answer_.sigma_time_offset_s))
      return false;
    add(answer_.findings, code::not_synchronous,
        fmt::format("the robot's poses fit better {:.3g} +- {:.2g} ms after the times of the "
                    "pictures: the clocks differ. Find the offset (--time-offset find)",
                    1e3 * *answer_.time_offset_s, 1e3 * answer_.sigma_time_offset_s));
    return true;
  }

  void set_offset(double offset_s, const HandeyeMinimum& minimum) {
    answer_.time_offset_s = offset_s;
    answer_.sigma_time_offset_s =
        std::sqrt(widening(minimum.degrees_of_freedom) *
                  minimum.covariance(HandeyeEquations::kTime, HandeyeEquations::kTime));
  }

  void report_offset(const HandeyeMinimum& minimum) {
    set_offset(offset_s_, minimum);
    add(answer_.findings, code::clock_corrected,
        fmt::format("the robot's poses are those {:.3g} +- {:.2g} ms after the times of the "
                    "pictures",
                    1e3 * offset_s_, 1e3 * answer_.sigma_time_offset_s));
  }

  const HandeyeOptions& options_;
  HandeyeEstimate answer_;
  HandeyeSights sights_;
  std::optional<BetterReading> better_;
  double offset_s_ = 0;
  bool is_scale_free_ = false;  // the robot contradicts the prior of the board's scale
};

}  // namespace

std::optional<Pose> hand_at(const RobotPath& path, double time_s) {
  const auto after = std::ranges::lower_bound(path.times_s, time_s);
  if (after == path.times_s.end()) return std::nullopt;
  const auto k = static_cast<std::size_t>(after - path.times_s.begin());
  if (*after == time_s) return path.base_from_hand[k];
  if (k == 0) return std::nullopt;
  const Pose& a = path.base_from_hand[k - 1];
  const Pose& b = path.base_from_hand[k];
  const double share = (time_s - path.times_s[k - 1]) / (path.times_s[k] - path.times_s[k - 1]);
  return retract(a, share * minus(b, a));
}

HandeyeEstimate calibrate_handeye(std::span<const HandeyeView> views, const UncertainCamera& camera,
                                  const HandeyeOptions& options) {
  const Stopwatch watch;
  check_handeye_input(views, camera, options);
  HandeyeEstimate answer =
      HandeyeRun(seen_views(views, camera.camera, options), camera, options).answer();
  answer.seconds = watch.seconds();
  return answer;
}

HandeyeEstimate calibrate_handeye_from_poses(std::span<const HandeyeView> views,
                                             const MatrixX& shared, const HandeyeOptions& options) {
  const Stopwatch watch;
  check_handeye_input(views, {}, options);
  check_poses(views, shared);
  HandeyeEstimate answer = HandeyeRun(posed_views(views), {nullptr, {}, shared}, options).answer();
  answer.seconds = watch.seconds();
  return answer;
}

}  // namespace tagcal
