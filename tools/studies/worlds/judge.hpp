#pragma once

#include <vector>

#include "draw.hpp"
#include "record.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {

// What a calibration is given, and what the study knows about it.
struct Measured {
  Dataset dataset;                       // with the board of the target file
  std::vector<std::vector<char>> gross;  // by view and corner: 1 if the corner is grossly wrong
};

// The exact corners of the real board, and noise: no picture is rendered. Covariances are right.
Measured project_corners(const World& world, Record& record);

// The corners that the detector finds in rendered pictures. Those that are 2 px off or more, or
// are not visible, are grossly wrong. Fills the record's comparison of corners with the truth.
Measured render_and_detect(const World& world, Record& record);

// Takes the world's corners from pictures or by projection, calibrates with `auto` and with the
// model that made the data, and compares the results with the truth, on one thread.
Record judge(const World& world);

}  // namespace tagcal
