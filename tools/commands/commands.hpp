#pragma once

#include "job/command.hpp"

// The table of commands (tagcal.cpp).

namespace tagcal::tools {

Command add_render(CLI::App& app);
Command add_detect(CLI::App& app);
Command add_calibrate(CLI::App& app);
Command add_rig(CLI::App& app);
Command add_watch(CLI::App& app);
Command add_validate(CLI::App& app);
Command add_report(CLI::App& app);
Command add_handeye(CLI::App& app);
Command add_pose(CLI::App& app);
Command add_board(CLI::App& app);
Command add_view(CLI::App& app);
Command add_diff(CLI::App& app);
Command add_fleet(CLI::App& app);
Command add_check(CLI::App& app);
Command add_history(CLI::App& app);
Command add_convert(CLI::App& app);
Command add_reproject(CLI::App& app);
Command add_project(CLI::App& app);
Command add_unproject(CLI::App& app);
Command add_triangulate(CLI::App& app);
Command add_completion(CLI::App& app);

}  // namespace tagcal::tools
