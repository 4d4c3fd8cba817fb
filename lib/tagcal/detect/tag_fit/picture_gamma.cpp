#include "tagcal/detect/tag_fit/picture_gamma.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "tagcal/detect/tag_fit/known_tag.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kTags = 2;     // the largest, that are looked at
constexpr double kLargeEnough = 45;  // px, of a tag's side
constexpr double kStep = 0.35;       // of the logarithm of gamma; cameras have 0.45 to 1
constexpr double kLowest = -1.2;     // of the same
constexpr double kHighest = 0.35;    // likewise: a gamma of 1.4
constexpr double kSurely = 30;       // log-likelihood twice, by which 1 must be worse

// Fits a tag at a given gamma; no value where that fails.
std::optional<TagFit> fit_with(const Image8& image, const TagInPicture& tag, double log_gamma) {
  return fit_known_tag(image, *tag.pattern, tag.corners,
                       {tag.camera, tag.is_rough, std::exp(log_gamma), true});
}

// Minus twice the log-likelihood of the tags' pixels; no value where a tag is not fitted.
class GammaCost {
 public:
  explicit GammaCost(const Image8& image) : image_(image) {}

  std::size_t num_tags() const { return tags_.size(); }

  // Tags that cannot be fitted as they are say nothing.
  void add(const TagInPicture& tag) {
    const auto fit = fit_with(image_, tag, 0);
    if (!fit) return;
    tags_.push_back({tag, fit->num_pixels});
    linear_ += cost_of(tags_.back(), *fit);
  }

  // At gamma 1.
  double linear() const { return linear_; }

  std::optional<double> at(double log_gamma) const {
    double sum = 0;
    for (const Seen& seen : tags_) {
      const auto fit = fit_with(image_, seen.tag, log_gamma);
      if (!fit) return std::nullopt;
      sum += cost_of(seen, *fit);
    }
    return sum;
  }

 private:
  struct Seen {
    TagInPicture tag;
    int num_pixels = 0;
  };
  static double cost_of(const Seen& seen, const TagFit& fit) {
    return 2 * seen.num_pixels * std::log(fit.noise_levels);
  }

  const Image8& image_;
  std::vector<Seen> tags_;
  double linear_ = 0;
};

// Where the parabola through three places has its least value.
std::optional<double> least(double x, double step, double before, double here, double after) {
  const double curvature = before - 2 * here + after;
  if (!(curvature > 0)) return std::nullopt;
  return x + std::clamp(0.5 * (before - after) / curvature, -1.5, 1.5) * step;
}

}  // namespace

double gamma_of_picture(const Image8& image, std::vector<TagInPicture> tags) {
  // The smallest that are large enough, which cost least, then the largest of the others.
  std::ranges::stable_sort(tags, {}, [](const TagInPicture& tag) {
    const double side = shortest_side(tag.corners);
    return side >= kLargeEnough ? side : 1e9 - side;
  });
  GammaCost cost(image);
  for (const TagInPicture& tag : tags)
    if (cost.num_tags() < kTags) cost.add(tag);
  if (cost.num_tags() == 0) return 1;
  const std::optional<double> linear = cost.linear();
  const auto below = cost.at(-kStep);
  if (!below) return 1;
  // Down while it goes down, then the parabola about the lowest.
  double at = 0, step = kStep;
  std::optional<double> here = linear, before = below, after;
  while (*before < *here && at - step > kLowest) {
    after = here;
    here = before;
    at -= step;
    before = cost.at(at - step);
    if (!before) return 1;
  }
  if (!after) after = cost.at(at + step);
  if (!after) return 1;
  const auto rough = least(at, step, *before, *here, *after);
  if (!rough) return 1;
  // What the parabola says of gamma 1 already.
  const double offset = (*rough - at) / step, half = 0.5 * (*before - 2 * *here + *after);
  if (at == 0 && half * offset * offset < 0.5 * kSurely) return 1;
  at = std::clamp(*rough, kLowest, kHighest);
  if (*linear - cost.at(at).value_or(*linear) < kSurely) return 1;
  step = 0.3 * kStep;
  before = cost.at(at - step);
  here = cost.at(at);
  after = cost.at(at + step);
  if (!before || !here || !after) return 1;
  return std::exp(
      std::clamp(least(at, step, *before, *here, *after).value_or(at), kLowest, kHighest));
}

}  // namespace tagcal::internal
