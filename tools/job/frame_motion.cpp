#include "job/frame_motion.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace tagcal::tools {
namespace {

constexpr int kReducedSide = 160;  // px, of pictures whose motion is measured

// A picture at a fraction of its size: means over squares of pixels.
struct Reduced {
  int factor = 1;
  Image8 image;
};

Reduced reduced(const Image8& image) {
  Reduced small;
  small.factor = std::max(1, std::max(image.width(), image.height()) / kReducedSide);
  const int f = small.factor;
  small.image = Image8({image.width() / f, image.height() / f});
  for (int y = 0; y < small.image.height(); ++y)
    for (int x = 0; x < small.image.width(); ++x) {
      int sum = 0;
      for (int v = 0; v < f; ++v)
        for (int u = 0; u < f; ++u) sum += image(f * x + u, f * y + v);
      small.image(x, y) = static_cast<std::uint8_t>(sum / (f * f));
    }
  return small;
}

// The sums over a picture of the absolute differences along x and y, and from an earlier picture.
// Their ratio is the mean normal flow: the motion in pixels (of |dI/dt| = |gradient . motion|).
struct Change {
  double gradient = 0;
  double difference = 0;
};

Change change_of(const Image8& now, const Image8* before) {
  Change sums;
  for (int y = 0; y + 1 < now.height(); ++y)
    for (int x = 0; x + 1 < now.width(); ++x) {
      const int value = now(x, y);
      sums.gradient += std::abs(now(x + 1, y) - value) + std::abs(now(x, y + 1) - value);
      if (before) sums.difference += std::abs((*before)(x, y) - value);
    }
  return sums;
}

}  // namespace

FrameMotion::Step FrameMotion::take(const Image8& frame) {
  Reduced now = reduced(frame);
  const bool is_like = now.image.size() == before_.size();
  const Change change = change_of(now.image, is_like ? &before_ : nullptr);
  before_ = std::move(now.image);
  if (change.gradient == 0) return {};
  return {now.factor * change.difference / change.gradient, change.gradient};
}

}  // namespace tagcal::tools
