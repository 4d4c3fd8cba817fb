// tagcal-study: the charts and maps, which compare with other libraries, and the studies whose
// numbers stand in the documentation. `tagcal` starts it for the first two.

#include "job/command_line.hpp"
#include "job/messages.hpp"
#include "studies/studies.hpp"

namespace tagcal::tools {
namespace {

std::vector<Command> command_table(CLI::App& app) {
  std::vector<Command> commands = {add_chart(app), add_stability(app), add_worlds(app)};
  for (const auto declared :
       {big_data_study,       calibration_nees_study, check_study,           checkers_study,
        detect_answers_study, end_to_end_study,       focal_refusal_study,   frames_study,
        halves_study,         handeye_study,          model_confusion_study, near_grids_study,
        real_claims_study,    real_corners_study,     reproject_speed_study, rig_shutter_study,
        rigs_study,           shutter_study,          single_views_study,    tracking_study,
        visibility_study})
    commands.push_back(add_study(app, declared()));
  return commands;
}

}  // namespace
}  // namespace tagcal::tools

int main(int argc, char** argv) {
  tagcal::tools::reserve_standard_streams();
  return tagcal::tools::run_command_line(argc, argv, tagcal::tools::command_table,
                                         {"Studies of tagcal: its methods beside those of other "
                                          "libraries, and what its numbers claim.",
                                          "",
                                          "Example: tagcal-study chart pose --out chart\n"
                                          "         tagcal-study calibration_nees --count 20"});
}
