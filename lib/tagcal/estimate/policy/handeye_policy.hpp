#pragma once

// The numbers that decide a hand-eye calibration (estimate/handeye/), as policy.hpp has those of
// the other estimators.

namespace tagcal::internal::policy {

// What is known of a robot's poses before any picture: medians of the standard deviations per axis,
// and the standard deviation of their logarithms, a factor of 7.4. Makers state a repeatability
// (ISO 9283) of 0.02 to 0.1 mm; the error of a pose, which nobody states, is some ten times larger
// (Nubiola & Bonev, Robotics and Computer-Integrated Manufacturing 2013: 1 mm before and 0.3 mm
// after calibration of an ABB IRB 1600). Chosen by hand; from ten poses on it hardly counts.
inline constexpr double kPriorRobotM = 1e-3;
inline constexpr double kPriorRobotRad = 2e-3;
inline constexpr double kPriorLogRobot = 2;
// The places of camera and board, before any picture: standard deviation over the distance of the
// board. Wide: it only keeps what nothing determines finite. Chosen by hand.
inline constexpr double kPriorReach = 5;
// The logarithm of the board's scale if the robot alone is to tell it: standard deviation. Wide: a
// tag size that is measured with the border, or in another unit, differs by less. Chosen by hand.
inline constexpr double kFreeScale = 0.3;

// Views from which on robot poses that contradict the others are rejected: of fewer, half and two
// are no majority. Chosen by hand.
inline constexpr int kFewestConsensus = 6;

// Standard deviation of a translation, over the distance of the board, from which it is refused;
// and of a rotation (rad). Chosen by hand: five of them are a wrong answer.
inline constexpr double kHandeyeRefused = 0.03;
inline constexpr double kHandeyeRefusedRad = 0.03;

// What the sentence of a refusal blames: no rotation, below this RMS (rad, 3 degrees); one axis, if
// the second principal RMS rotation is below this part of the first (rad, 12 degrees); else few or
// imprecise poses. The refusal itself is by the standard deviations. Chosen by hand.
inline constexpr double kLeastHandeyeTurn = 0.05;
inline constexpr double kLeastAxisSpread = 0.2;

// Another reading of the robot's poses is proposed if it lowers their RMS disagreement by this
// factor, beyond chance (policy::kSignificant), and to kHandeyeRefused at most. Right poses are not
// proposed otherwise by study `handeye`. Chosen by hand.
inline constexpr double kReadingBetter = 3;

// Degrees of freedom below which a finding says that the robot's noise is hardly known: its
// standard deviation is 1 / sqrt(2 * 10) = 22 %.
inline constexpr double kFewRobotFreedoms = 10;

}  // namespace tagcal::internal::policy
