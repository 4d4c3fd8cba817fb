#pragma once

#include <string>
#include <vector>

#include "job/command.hpp"
#include "study/harness/study.hpp"

// The studies of tagcal-study, each declared in the file of its name.

namespace tagcal {

study::Study big_data_study();
study::Study calibration_nees_study();
study::Study check_study();
study::Study checkers_study();
study::Study detect_answers_study();
study::Study end_to_end_study();
study::Study focal_refusal_study();
study::Study frames_study();
study::Study halves_study();
study::Study handeye_study();
study::Study model_confusion_study();
study::Study near_grids_study();
study::Study real_claims_study();
study::Study real_corners_study();
study::Study reproject_speed_study();
study::Study rig_shutter_study();
study::Study rigs_study();
study::Study shutter_study();
study::Study single_views_study();
study::Study tracking_study();
study::Study visibility_study();

namespace tools {

// How a chart or a map was made: the command, the versions, the processor and the day.
std::vector<std::string> origin_of(const std::string& command);

Command add_chart(CLI::App& app);
Command add_stability(CLI::App& app);
Command add_study(CLI::App& app, study::Study study);
Command add_worlds(CLI::App& app);

}  // namespace tools
}  // namespace tagcal
