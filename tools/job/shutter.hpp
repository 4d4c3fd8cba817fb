#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "job/input.hpp"
#include "tagcal/estimate/types.hpp"

namespace tagcal::tools {

// How a command treats the shutter of frames with times. `automatic` takes it for a rolling one if
// the corners show its readout.
enum class Shutter { automatic, rolling, global };

// --shutter
Option add_shutter(CLI::App& command, std::string& shutter);
// Its value. A frame's velocity is seen in its neighbours: `default_frames` becomes "all" for a
// rolling one.
Shutter shutter_of(const std::string& text, std::string& default_frames);

// True for frames of videos and bags alone, and for observations with times.
bool has_times(const Input& input);
// Throws Error if a readout is asked for, of pictures without times.
void check_times(Shutter shutter, bool has_times);

// The times of views, by `times_s` (Input::times_s), which has all. Those of each video or bag,
// which the names of its frames begin with (picture_name), have their own day: its frames are no
// neighbours of another one's.
std::vector<double> film_times(const std::vector<View>& views,
                               const std::map<std::string, double>& times_s);

// The same input with the neighbours of its frames, which show the motion; no value if it has them,
// or pictures that are no frames.
std::optional<Input> with_neighbours(const Input& input, int threads, bool shows_progress);

// Takes back a readout that nobody asked for and that is not seen.
void forget_readout(Calibration& calibration);
void forget_readout(std::vector<Finding>& findings);

}  // namespace tagcal::tools
