#pragma once

#include <cstddef>

// The numbers that decide which frames of a video or bag a calibration uses (frame_choice.hpp), as
// policy.hpp has those of the estimates.

namespace tagcal::internal::policy {

// Up to this many frames with a board are all used: a choice saves nothing that is felt.
inline constexpr std::size_t kFewFrames = 60;

// Frames, evenly, of the calibration under whose lens the others are judged: what a set of single
// pictures has.
inline constexpr std::size_t kSeedFrames = 40;

// 1/s. A frame is fast if the corners move by more than this share of the image's diagonal in a
// second (120 px of 640 x 480), and faster than in half of the frames: rows that are read in a
// thirtieth of a second then displace corners of half the image's height by 2 px.
inline constexpr double kFastShare = 0.15;

// Frames are added until one reduces the variance of the projection by less than this share.
inline constexpr double kLeastGain = 0.01;

// Without a calibration of the first frames, as many frames are used, evenly.
inline constexpr std::size_t kFramesWithoutLens = 300;

}  // namespace tagcal::internal::policy
