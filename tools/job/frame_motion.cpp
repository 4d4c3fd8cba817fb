#include "job/frame_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/sequence_file.hpp"

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

namespace fs = std::filesystem;

// Follows the motion from frame to frame.
class Walk {
 public:
  void take(std::size_t frame, const Image8& image) {
    const FrameMotion::Step step = motion_.take(image);
    if (step.sharpness > sharpest_) {
      sharpest_ = step.sharpness;
      best_ = frame;
    }
    moved_px_ += step.moved_px;
    if (moved_px_ >= kStepShare * std::hypot(image.width(), image.height())) end_step();
  }

  void end_step() {
    if (sharpest_ >= 0) frames_.push_back(best_);
    sharpest_ = -1;
    moved_px_ = 0;
  }

  std::vector<std::size_t> frames() { return std::move(frames_); }

 private:
  FrameMotion motion_;
  double moved_px_ = 0;   // since the last step
  double sharpest_ = -1;  // sharpness of the best frame since then; -1 before the first
  std::size_t best_ = 0;
  std::vector<std::size_t> frames_;
};

}  // namespace

FrameMotion::Step FrameMotion::take(const Image8& frame) {
  Reduced now = reduced(frame);
  const bool is_like = now.image.size() == before_.size();
  const Change change = change_of(now.image, is_like ? &before_ : nullptr);
  before_ = std::move(now.image);
  if (change.gradient == 0) return {};
  return {now.factor * change.difference / change.gradient, change.gradient};
}

std::vector<std::size_t> walked_frames(const fs::path& sequence, std::size_t num_frames) {
  if (num_frames <= kFewestWalked) return internal::spread_indices(num_frames, num_frames);
  Walk walk;
  Progress progress("looking for motion", static_cast<int>(num_frames));
  for (std::size_t i = 0; i < num_frames; ++i) {
    try {
      walk.take(i, read_image(frame_path(sequence, i)));
    } catch (const Error&) {  // named where it is read to be used
    }
    progress.update(static_cast<int>(i + 1));
  }
  walk.end_step();
  const std::vector<std::size_t> all = walk.frames();
  std::vector<std::size_t> some;
  for (const std::size_t i : internal::spread_indices(all.size(), kMostWalked))
    some.push_back(all[i]);
  return some;
}

}  // namespace tagcal::tools
