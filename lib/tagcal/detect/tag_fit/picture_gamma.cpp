#include "tagcal/detect/tag_fit/picture_gamma.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"

namespace tagcal::internal {
namespace {

using namespace policy;

constexpr double kLargeSidePx = 45;  // of a tag that is large enough, as a limit of work
constexpr double kStep = 0.35;       // numeric: of the search, of the logarithm

// Fits a tag at a given gamma; no value if that fails.
std::optional<TagFit> fit_with(const ImageView8& image, const TagInPicture& tag, double log_gamma) {
  return fit_known_tag(image, *tag.pattern, tag.corners,
                       {.camera = tag.camera,
                        .is_rough = tag.is_rough,
                        .is_whole = true,
                        .gamma = std::exp(log_gamma)});
}

// Minus twice the log-likelihood of the tags' pixels.
class GammaCost {
 public:
  explicit GammaCost(const ImageView8& image) : image_(image) {}

  std::size_t num_tags() const { return tags_.size(); }

  // Tags that cannot be fitted at gamma 1 are not used.
  void add(const TagInPicture& tag) {
    const auto fit = fit_with(image_, tag, 0);
    if (!fit) return;
    tags_.push_back({tag, fit->num_pixels});
    linear_ += cost_of(tags_.back(), *fit);
  }

  // At gamma 1.
  double linear() const { return linear_; }

  // No value if a tag cannot be fitted.
  std::optional<double> at(double log_gamma) const {
    double sum = 0;
    for (const UsedTag& used : tags_) {
      const auto fit = fit_with(image_, used.tag, log_gamma);
      if (!fit) return std::nullopt;
      sum += cost_of(used, *fit);
    }
    return sum;
  }

 private:
  struct UsedTag {
    TagInPicture tag;
    int num_pixels = 0;  // of the fit at gamma 1
  };
  static double cost_of(const UsedTag& used, const TagFit& fit) {
    return 2 * used.num_pixels * std::log(fit.noise_levels);
  }

  ImageView8 image_;
  std::vector<UsedTag> tags_;
  double linear_ = 0;
};

// Minimum of the parabola through the values at x - step, x and x + step.
std::optional<double> minimum_of_parabola(double x, double step, double before, double here,
                                          double after) {
  const double curvature = before - 2 * here + after;
  if (!(curvature > 0)) return std::nullopt;
  constexpr double kMost = 1.5;  // numeric: steps of extrapolation, at most
  return x + std::clamp((before - after) / 2 / curvature, -kMost, kMost) * step;
}

}  // namespace

double gamma_of_picture(const ImageView8& image, std::vector<TagInPicture> tags) {
  // First the smallest of the large tags, which cost least, then the largest of the others.
  std::ranges::stable_sort(tags, {}, [](const TagInPicture& tag) {
    const double side = shortest_side(tag.corners);
    return side >= kLargeSidePx ? side : 1e9 - side;
  });
  GammaCost cost(image);
  for (const TagInPicture& tag : tags)
    if (cost.num_tags() < kTagGammaTags) cost.add(tag);
  if (cost.num_tags() == 0) return 1;
  const std::optional<double> linear = cost.linear();
  const auto below = cost.at(-kStep);
  if (!below) return 1;
  // Descends from gamma 1 in equal steps, then fits a parabola around the lowest.
  double at = 0, step = kStep;
  std::optional<double> here = linear, before = below, after;
  while (*before < *here && at - step > kTagMinLogGamma) {
    after = here;
    here = before;
    at -= step;
    before = cost.at(at - step);
    if (!before) return 1;
  }
  if (!after) after = cost.at(at + step);
  if (!after) return 1;
  const auto rough = minimum_of_parabola(at, step, *before, *here, *after);
  if (!rough) return 1;
  // Stops early if the parabola already shows that gamma 1 is not clearly worse.
  const double offset = (*rough - at) / step, half = (*before - 2 * *here + *after) / 2;
  if (at == 0 && half * offset * offset < kTagGammaSure / 2) return 1;
  at = std::clamp(*rough, kTagMinLogGamma, kTagMaxLogGamma);
  if (*linear - cost.at(at).value_or(*linear) < kTagGammaSure) return 1;
  step = 0.3 * kStep;  // numeric: a narrower parabola around its minimum
  before = cost.at(at - step);
  here = cost.at(at);
  after = cost.at(at + step);
  if (!before || !here || !after) return 1;
  const double log_gamma = minimum_of_parabola(at, step, *before, *here, *after).value_or(at);
  return std::exp(std::clamp(log_gamma, kTagMinLogGamma, kTagMaxLogGamma));
}

}  // namespace tagcal::internal
