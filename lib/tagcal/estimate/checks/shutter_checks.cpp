#include "tagcal/estimate/checks/shutter_checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/rolling_shutter.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/policy/shutter_policy.hpp"
#include "tagcal/internal/text.hpp"

namespace tagcal::internal {
namespace {

// The shortest time from one picture to another.
double shortest_step(std::vector<double> times_s) {
  std::ranges::sort(times_s);
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < times_s.size(); ++i)
    if (times_s[i] > times_s[i - 1]) shortest = std::min(shortest, times_s[i] - times_s[i - 1]);
  return shortest;
}

}  // namespace

std::optional<Finding> check_rows(const Bundle& bundle) {
  if (bundle.is_rolling() || !(bundle.row_sigma > 0) ||
      std::ssize(bundle.views) < policy::kFewestTellingViews)
    return std::nullopt;
  double square = 0;
  for (const Vector6d& rows : bundle.row_terms) square += rows.squaredNorm();
  const double half = bundle.image_size.height / 2.0;
  const double rms_px = half * std::sqrt(square / static_cast<double>(bundle.views.size()));
  if (!(rms_px > policy::kGoodCornerPx)) return std::nullopt;
  return finding(code::rows_displaced,
                 "the upper and lower rows of the pictures are displaced by " +
                     with_digits(rms_px, 2) +
                     " px (RMS) against their middle, each picture by its own: a rolling shutter, "
                     "a camera or board that moved, or another zoom, crop or focus (stabilised "
                     "pictures, too); hold both still, or use a global shutter");
}

std::optional<Finding> check_shutter(const Bundle& bundle, const CalibrateOptions& options) {
  if (!bundle.is_rolling() || !(bundle.row_sigma > 0)) return std::nullopt;
  const std::vector<double> moved_px = row_motions_px(bundle);
  if (!(std::ranges::max(moved_px) > policy::kGoodCornerPx)) return std::nullopt;
  const auto count =
      std::ranges::count_if(moved_px, [](double px) { return px > policy::kGoodCornerPx; });
  const std::string off = ": corners are off by up to " +
                          with_digits(std::ranges::max(moved_px), 2) + " px, by more than " +
                          with_digits(policy::kGoodCornerPx, 1) + " px in " +
                          std::to_string(count) + " of " + std::to_string(moved_px.size()) +
                          " views; the answer includes it, but hold camera and board still";
  return finding(
      code::rolling_shutter,
      options.times_s.empty()
          ? "rows are displaced, as by a rolling shutter or by another zoom, crop or focus" + off +
                ", or give a video and --shutter rolling"
          : "the poses of neighbours in time do not show all motion of the rows" + off);
}

std::optional<Finding> check_readout(const std::optional<Readout>& readout,
                                     const std::vector<double>& times_s) {
  if (times_s.empty()) return std::nullopt;
  if (!readout)
    return finding(
        code::readout_not_observable,
        "no picture has two neighbours in steps of " + with_digits(policy::kNeighbourSeconds, 2) +
            " s or less, which show the velocity of the camera: take all frames of a video");
  // A readout ends before the next picture begins: without data its standard deviation is that of
  // a uniform variable.
  const double period_s = shortest_step(times_s);
  if (readout->sigma_s < period_s / std::sqrt(12)) return std::nullopt;
  return finding(code::readout_not_observable,
                 "the readout has a standard deviation of " +
                     with_digits(1e3 * readout->sigma_s, 2) + " ms, with pictures every " +
                     with_digits(1e3 * period_s, 2) + " ms: the camera moves too little");
}

}  // namespace tagcal::internal
