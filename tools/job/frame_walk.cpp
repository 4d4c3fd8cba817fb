#include "job/frame_motion.hpp"

#include <cmath>
#include <utility>

#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/sequence_file.hpp"

namespace tagcal::tools {
namespace {

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
  double sharpest_ = -1;  // sharpness of the best frame since then; -1: there is none
  std::size_t best_ = 0;
  std::vector<std::size_t> frames_;
};

}  // namespace

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
