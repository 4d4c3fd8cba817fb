#include "tagcal/detect/tag_fit/picture_processing.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/sharpening.hpp"
#include "tagcal/detect/tag_fit/tag_model.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Vector2d;
using namespace policy;

constexpr double kStep = 0.35;         // numeric: of the search, of the logarithm
constexpr double kNarrow = 0.3;        // numeric: a narrower parabola around its minimum
constexpr int kEnoughPixels = 5000;    // for an estimate of sharpening, as a limit of work
constexpr int kFewPixels = 2000;       // to see whether there is any, as a limit of work
constexpr int kMostRowStep = 6;        // of a large tag's rows, as a limit of work
constexpr std::size_t kMostParts = 8;  // for an estimate of sharpening, as a limit of work
constexpr double kLargeSidePx = 45;    // of a pattern that is large enough, as a limit of work

constexpr Sharpen kNoSharpen = {0, 1};

// Minus twice the log-likelihood of the pixels of patterns.
class ProcessingCost {
 public:
  std::size_t num_parts() const { return parts_.size(); }
  int num_pixels() const {
    int sum = 0;
    for (const UsedPart& used : parts_) sum += used.num_pixels;
    return sum;
  }
  // Residuals are as large as those of strong overshoot.
  bool is_noisy() const {
    const PatternFit& fit = parts_.front().fit;
    return fit.noise_levels > kSharpenNoisyShare * (fit.white - fit.black);
  }

  // Patterns that cannot be fitted without processing are not used. They must outlive it.
  void add(const PatternPart& part) {
    UsedPart used{&part};
    used.fit = part({}, 1);
    if (used.fit.status != TagFitStatus::converged) return;
    used.num_pixels = used.fit.num_pixels;
    used.without = cost_of(used, used.fit);
    parts_.push_back(used);
  }

  bool has_enough() const { return num_pixels() >= kEnoughPixels || num_parts() >= kMostParts; }

  // The first patterns that have enough pixels, with every few rows of large ones.
  ProcessingCost sample() const {
    ProcessingCost result;
    for (UsedPart used : parts_) {
      if (result.has_enough()) break;
      result.add(used, kEnoughPixels);
    }
    return result;
  }
  // Few rows of the first pattern.
  ProcessingCost small_sample() const {
    ProcessingCost result;
    result.add(parts_.front(), kFewPixels);
    return result;
  }

  // No value if a pattern cannot be fitted.
  std::optional<double> at(const CameraProcessing& processing) const {
    const double gain = mean_log_gain(processing.sharpen);
    double sum = 0;
    for (const UsedPart& used : parts_) {
      if (processing.is_none() && used.row_step == 1) {
        sum += used.without;
        continue;
      }
      const PatternFit fit = (*used.part)(processing, used.row_step);
      if (fit.status != TagFitStatus::converged) return std::nullopt;
      // The fit's parameters take residuals of low frequencies, which sharpening does not change.
      const double n = used.num_pixels, free = n - tag_parameter::kCount;
      sum += cost_of(used, fit) + 2 * n * gain * n / free;
    }
    return sum;
  }

 private:
  struct UsedPart {
    const PatternPart* part;
    int row_step = 1;
    // The fit without processing:
    PatternFit fit;
    int num_pixels = 0;  // of it, or of the rows that are used
    double without = 0;  // cost
  };

  void add(UsedPart used, int enough_pixels) {
    used.row_step = std::clamp(used.num_pixels / enough_pixels, 1, kMostRowStep);
    used.num_pixels /= used.row_step;
    parts_.push_back(used);
  }

  static double cost_of(const UsedPart& used, const PatternFit& fit) {
    return 2 * used.num_pixels * std::log(fit.noise_levels);
  }

  std::vector<UsedPart> parts_;
};

// Minimum of the parabola through the values at x - step, x and x + step.
std::optional<double> minimum_of_parabola(double x, double step, double before, double here,
                                          double after) {
  const double curvature = before - 2 * here + after;
  if (!(curvature > 0)) return std::nullopt;
  constexpr double kMost = 1.5;  // numeric: steps of extrapolation, at most
  return x + std::clamp((before - after) / 2 / curvature, -kMost, kMost) * step;
}

double gamma_of_picture(const ProcessingCost& costs, const Sharpen& sharpen) {
  const auto cost = [&](double log_gamma) {
    return costs.at({log_gamma == 0 ? 1 : std::exp(log_gamma), sharpen});
  };
  const std::optional<double> linear = cost(0);
  const auto below = cost(-kStep);
  if (!linear || !below) return 1;
  // Descends from gamma 1 in equal steps, then fits a parabola around the lowest.
  double at = 0, step = kStep;
  std::optional<double> here = linear, before = below, after;
  while (*before < *here && at - step > kTagMinLogGamma) {
    after = here;
    here = before;
    at -= step;
    before = cost(at - step);
    if (!before) return 1;
  }
  if (!after) after = cost(at + step);
  if (!after) return 1;
  const auto rough = minimum_of_parabola(at, step, *before, *here, *after);
  if (!rough) return 1;
  // Stops early if the parabola already shows that gamma 1 is not clearly worse.
  const double offset = (*rough - at) / step, half = (*before - 2 * *here + *after) / 2;
  if (at == 0 && half * offset * offset < kTagGammaSure / 2) return 1;
  at = std::clamp(*rough, kTagMinLogGamma, kTagMaxLogGamma);
  if (*linear - cost(at).value_or(*linear) < kTagGammaSure) return 1;
  step = kNarrow * kStep;
  before = cost(at - step);
  here = cost(at);
  after = cost(at + step);
  if (!before || !here || !after) return 1;
  const double log_gamma = minimum_of_parabola(at, step, *before, *here, *after).value_or(at);
  return std::exp(std::clamp(log_gamma, kTagMinLogGamma, kTagMaxLogGamma));
}

// A search for sharpening. First it tries a weak and, where residuals are as large as those of
// strong overshoot (as a share of the contrast), a strong one: one of them must lower the cost.
// Then it takes the best of some starts, and Newton's steps.
constexpr Sharpen kWeakly = {0.08, 1.3}, kStrongly = {0.4, 2};  // numeric: start of the search
constexpr double kPromising = 8;                        // numeric: few plain tags have so much
constexpr std::array kStartAmounts = {0.25, 0.7, 1.6};  // numeric: start of the search
constexpr std::array kStartRadii_px = {0.8, 1.3, 2.1};  // numeric: start of the search
constexpr double kLargeStep = 0.4, kSmallStep = 0.1;    // numeric: of logarithms
constexpr double kSettled = 2;                          // numeric: of the cost
constexpr int kMaxRounds = 10;                          // numeric: as a limit of work

// Changes logarithms: of amount * radius^2, which is what sharpening does to a wide border, and of
// the radius. The cost hardly correlates these two.
Sharpen changed(const Sharpen& sharpen, double strength, double radius) {
  return {sharpen.amount * std::exp(strength - 2 * radius), sharpen.radius_px * std::exp(radius)};
}

bool is_allowed(const Sharpen& sharpen) {
  return sharpen.amount <= kSharpenMaxAmount && sharpen.radius_px >= kSharpenMinRadiusPx &&
         sharpen.radius_px <= kSharpenMaxRadiusPx;
}

class SharpenSearch {
 public:
  // Infinite for sharpening that is not allowed, or with which a tag cannot be fitted.
  double cost(const CameraProcessing& processing) const {
    return is_allowed(processing.sharpen) ? costs.at(processing).value_or(HUGE_VAL) : HUGE_VAL;
  }

  bool is_promising(double gamma) const {
    const double least = cost({gamma, kNoSharpen}) - kPromising;
    return cost({gamma, kWeakly}) < least || (costs.is_noisy() && cost({gamma, kStrongly}) < least);
  }

  void start(double gamma) {
    for (const double radius_px : kStartRadii_px)
      for (const double amount : kStartAmounts) take_if_lower({gamma, {amount, radius_px}});
  }

  // Ends when places a small step away are hardly lower.
  void descend(double step) {
    for (int i = 0; i < kMaxRounds; ++i) {
      const double before = lowest;
      take_step(step);
      if (step <= kSmallStep && before - lowest < kSettled) break;
      step = std::max(step / 2, kSmallStep / 2);
    }
  }

  // Takes a step of Newton's, by the squares of residuals at places a step away from the lowest.
  void take_step(double step) {
    const CameraProcessing from = best;
    const double here = lowest;
    const auto moved = [&](const Vector2d& by) {
      return CameraProcessing{from.gamma, changed(from.sharpen, by.x(), by.y())};
    };
    const auto squares = [&](double x, double y) {
      return std::exp((take_if_lower(moved({x, y})) - here) / costs.num_pixels());
    };
    const double left = squares(-step, 0), right = squares(step, 0);
    const double below = squares(0, -step), above = squares(0, step);
    const double mixed = squares(step, step) - right - above + 1;
    const Vector2d slope((right - left) / 2, (above - below) / 2);
    Eigen::Matrix2d curvature;
    curvature << left + right - 2, mixed, mixed, below + above - 2;
    const Eigen::LLT<Eigen::Matrix2d> factor(curvature);
    if (!curvature.allFinite() || factor.info() != Eigen::Success) return;
    constexpr double kMost = 1.5;  // numeric: steps of extrapolation, at most
    take_if_lower(moved(-step * factor.solve(slope).cwiseMax(-kMost).cwiseMin(kMost)));
  }

  double take_if_lower(const CameraProcessing& processing) {
    const double there = cost(processing);
    if (there < lowest) best = processing;
    lowest = std::min(there, lowest);
    return there;
  }

  ProcessingCost costs;
  CameraProcessing best = {};
  double lowest = HUGE_VAL;
};

// Overshoot looks like a gamma, and a gamma like overshoot: both are estimated with the other.
CameraProcessing with_sharpening(const ProcessingCost& costs, double gamma) {
  const CameraProcessing without{gamma, kNoSharpen};
  SharpenSearch search{costs};
  if (!search.is_promising(gamma)) return without;
  search.start(gamma);
  if (gamma != 1) search.start(1);
  search.descend(kLargeStep);
  CameraProcessing best = search.best;
  best.gamma = gamma_of_picture(costs, best.sharpen);
  SharpenSearch again{costs};
  again.take_if_lower(best);
  again.descend(kSmallStep);
  return again.cost(without) - again.lowest > kSharpenSure ? again.best : without;
}

}  // namespace

CameraProcessing processing_of_parts(const std::vector<PatternPart>& parts) {
  ProcessingCost costs;
  auto next = parts.begin();
  for (; next != parts.end() && costs.num_parts() < kTagGammaTags; ++next) costs.add(*next);
  if (costs.num_parts() == 0) return {};
  const double gamma = gamma_of_picture(costs, kNoSharpen);
  if (!SharpenSearch{costs.small_sample()}.is_promising(gamma)) return {gamma, kNoSharpen};
  for (; next != parts.end() && !costs.has_enough(); ++next) costs.add(*next);
  return with_sharpening(costs.sample(), gamma);
}

CameraProcessing processing_of_picture(const ImageView8& image,
                                       const std::vector<TagInPicture>& tags) {
  std::vector<PatternPart> parts;
  for (const TagInPicture& tag : tags)
    parts.push_back([&](const CameraProcessing& processing, int row_step) {
      const auto fit = fit_known_tag(image, *tag.pattern, tag.corners,
                                     {.camera = tag.camera,
                                      .is_rough = tag.is_rough,
                                      .is_whole = true,
                                      .row_step = row_step,
                                      .processing = processing});
      return fit ? PatternFit(*fit) : PatternFit();
    });
  return processing_of_parts(parts);
}

double order_of_part(double side_px) {
  return side_px >= kLargeSidePx ? side_px : 1e9 - side_px;  // numeric: after all large ones
}

}  // namespace tagcal::internal
