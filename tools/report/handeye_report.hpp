#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/handeye.hpp"
#include "tagcal/scene/dataset.hpp"

namespace tagcal::tools {

// What was read for a hand-eye calibration.
struct HandeyeInput {
  std::string name;                       // in messages
  std::vector<std::string> pictures;      // all, also those without corners
  bool has_all_pictures = true;           // false: corners alone, which do not say what there was
  std::vector<HandeyeView> views;         // without the robot's poses
  std::optional<UncertainCamera> camera;  // none: the views are poses
  MatrixX shared;                         // calibrate_handeye_from_poses
  std::optional<std::string> reference;   // of a rig: the camera that has its frame; "": none
  ImageSize image_size;                   // of that camera; 0 x 0: not known
  std::vector<PlacedBoard> boards;        // in the frame of the board; empty: not known
  std::optional<Finding> contradiction;   // of the pictures with the camera's file
  std::optional<Finding> wrong_target;    // of the pictures with the target file: no answer
};

// Returns the report for a person: the verdict, findings, the places of camera and board, the
// robot's noise, the spread of the axes, the worst views, and the next pose.
std::string handeye_summary(const HandeyeEstimate& handeye, const HandeyeInput& input);

// Parts of it, as the page has them too: "OK: camera on the hand, .." or "NO ANSWER: .."; the
// titles of the two places; the robot's noise; turns and axes; the offset of the clocks ("" without
// one).
std::string handeye_verdict(const HandeyeEstimate& handeye);
std::string camera_title(const HandeyeEstimate& handeye, const HandeyeInput& input);
std::string board_title(const HandeyeEstimate& handeye);
std::string robot_text(const HandeyeEstimate& handeye);
std::string axes_text(const HandeyeEstimate& handeye);
std::string clocks_text(const HandeyeEstimate& handeye);

// True for an answer, and for refusals whose places and noise hold in part.
bool has_places(const HandeyeEstimate& handeye);

// Returns one JSON object (docs/reference/formats.md).
std::string handeye_json(const HandeyeEstimate& handeye, const HandeyeInput& input);

}  // namespace tagcal::tools
