#include "report/lens_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "draw/heat_map.hpp"
#include "job/camera_input.hpp"
#include "job/terminal.hpp"
#include "tagcal/error.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

// The difference, and what the covariances of both explain of it. The test takes each pattern of
// the difference by itself, so that it may find one that is small beside all that they explain.
std::string difference_text(const Comparison& worst, CheckVerdict verdict) {
  const double found_px = worst.difference.rms_px, explained_px = worst.test->expected_px;
  const std::string apart = fmt::format("{} px apart at {}", two_digits(found_px),
                                        distance_text(worst.difference.distance_m));
  if (verdict == CheckVerdict::changed && found_px <= explained_px)
    return fmt::format(
        "{}: less than the {} px that the covariances of both explain, but in a pattern over the "
        "image of which they explain less",
        apart, two_digits(explained_px));
  return fmt::format("{}, where the covariances of both explain {} px", apart,
                     two_digits(explained_px));
}

}  // namespace

std::vector<Vector2d> common_region(const CalibrationFile& a, const CalibrationFile& b) {
  return common_samples(a.camera.image_size, a.seen, b.seen);
}

const Comparison* worst_of(std::span<const Comparison> comparisons) {
  const Comparison* worst = nullptr;
  for (const Comparison& c : comparisons)
    if (c.test && (!worst || c.test->in_sigmas > worst->test->in_sigmas)) worst = &c;
  return worst;
}

ComparisonVerdict verdict_of(std::span<const Comparison> comparisons, double limit_px) {
  const Comparison* const worst = worst_of(comparisons);
  if (!worst)
    return {std::nullopt, "",
            "not known if they are one camera: neither file has a covariance of the lens", 0};
  double smallest = 0;
  for (const Comparison& c : comparisons)
    if (c.test) smallest = std::max(smallest, c.test->smallest_px);
  const CheckVerdict verdict = change_verdict(worst->test->in_sigmas, smallest, limit_px);
  const bool is_same = std::ranges::all_of(
      comparisons, [](const Comparison& c) { return c.difference.max_px < kLeastPx; });
  std::string sentence = is_same ? "both have the same lens" : difference_text(*worst, verdict);
  const std::string hidden =
      std::isfinite(smallest) ? two_digits(smallest) + " px" : std::string("any size");
  if (verdict == CheckVerdict::changed)
    sentence += fmt::format(" (score {:.1f})", worst->test->in_sigmas);
  else if (verdict == CheckVerdict::valid)
    sentence += fmt::format("; a change of {} in the image would have been seen", hidden);
  else
    sentence += fmt::format("; a change of {} in the image could be hidden, and {} px matter",
                            hidden, two_digits(limit_px));
  static constexpr const char* kWords[] = {"VALID", "CHANGED", "CANNOT TELL"};
  return {verdict, kWords[static_cast<std::size_t>(verdict)], sentence, smallest};
}

std::string verdict_text(const ComparisonVerdict& verdict) {
  if (!verdict.verdict) return verdict.sentence + "\n";
  static constexpr Tone kTones[] = {Tone::good, Tone::bad, Tone::caution};
  return wrapped(toned(kTones[static_cast<std::size_t>(*verdict.verdict)], verdict.word) + ": ",
                 verdict.sentence, 2);
}

std::vector<Comparison> compare(const std::string& name_a, const UncertainCamera& a,
                                const std::string& name_b, const UncertainCamera& b,
                                std::span<const Vector2d> samples,
                                std::span<const double> distances_m) {
  const ImageSize &of_a = a.camera.image_size, &of_b = b.camera.image_size;
  if (of_a != of_b)
    throw Error(
        fmt::format("{}: image size must be {}x{} as in {}, got {}x{}; if it is of pictures that "
                    "were scaled or cut, "
                    "convert one of the two with --resize or --crop",
                    name_b, of_a.width, of_a.height, name_a, of_b.width, of_b.height));
  std::vector<Comparison> comparisons;
  for (const double distance : distances_m) {
    const auto d = lens_difference(a.camera, b.camera, samples, distance);
    if (!d)
      throw Error(fmt::format("{}, {}: have too little of the image in common to be compared",
                              name_a, name_b));
    comparisons.push_back({*d, difference_test(a, b, samples, *d)});
  }
  return comparisons;
}

std::vector<Comparison> compare(const std::string& file_a, const std::string& file_b,
                                std::span<const Vector2d> samples,
                                std::span<const double> distances_m) {
  return compare(file_a, read_lens(file_a, "").camera, file_b, read_lens(file_b, "").camera,
                 samples, distances_m);
}

}  // namespace tagcal::tools
