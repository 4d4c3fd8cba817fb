// Maps of the information of the views about the intrinsics, for any lens.

#include <algorithm>
#include <cmath>

#include "study/atlas/map_calibration.hpp"
#include "tagcal/geometry/transform.hpp"

namespace tagcal::study {
namespace {

std::vector<CalibrationSolver> all_solvers() {
  return with_mrcal({our_calibration(), our_calibration_by_name(), opencv_calibration(),
                     opencv_calibration_of("pinhole")});
}

// A pose whose board normal is fixed up to a small spread, with random position and roll.
Pose draw_parallel(double spread_deg, Random& random) {
  constexpr double kTilt = 30 * kDegree;  // of all boards, to the optical axis
  const Eigen::Quaterniond facing(0, 1, 0, 0);
  const double azimuth = random.uniform(0, 2 * std::numbers::pi);
  const double off = spread_deg * kDegree * random.uniform();
  const Eigen::Quaterniond turn =
      exp_rotation(off * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0)) *
      exp_rotation({kTilt, 0, 0}) * facing *
      exp_rotation({0, 0, random.uniform(0, 2 * std::numbers::pi)});
  return Pose(turn,
              {random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1), random.uniform(0.9, 1.3)});
}

}  // namespace

StabilityMap views_tilt_map() {
  StabilityMap map;
  map.name = "calibrate-views-tilt";
  map.title =
      "Calibration: number of views and their largest tilt, 36 corners each, 0.3 px of noise";
  map.axes = {{"views", "", {1, 2, 3, 4, 6, 10}, {}},
              {"largest tilt", "deg", {0, 1, 2, 5, 10, 20, 40}, {}}};
  map.what = "Views that all face the camera, or too few, leave focal length and distance open";
  map.why =
      "Each plane gives two equations for the intrinsics, and none for the focal length where it "
      "is parallel to the image (Zhang, PAMI 2000; Sturm & Maybank, CVPR 1999)";
  map.answer =
      "tagcal inverts the information exactly and says `not_observable` or "
      "`focal_not_observable`, with the direction that is open, where the projection is not held";
  ask_calibration(map, all_solvers(), [](std::span<const double> at, Random& random) {
    CalibrationTask task = pinhole_task();
    for (int i = 0; i < static_cast<int>(at[0]); ++i)
      add_view(task, draw_view(i == 0 ? at[1] : random.uniform(0, at[1]), random), random);
    return ask_all(std::move(task));
  });
  return map;
}

StabilityMap parallel_planes_map() {
  StabilityMap map;
  map.name = "calibrate-parallel";
  map.title = "Calibration: planes that are nearly parallel, tilted by 30°, 0.3 px of noise";
  map.axes = {{"views", "", {3, 8}, {}},
              {"spread of attitudes", "deg", {0, 0.01, 0.1, 0.5, 1, 2, 5, 10}, {}}};
  map.what = "Planes parallel to one another are as one plane: focal length and centre trade";
  map.why =
      "Parallel planes share their vanishing line, and with it the two equations for the "
      "intrinsics (Sturm & Maybank, CVPR 1999)";
  map.answer = "tagcal says `not_observable`, and what trades with what";
  ask_calibration(map, all_solvers(), [](std::span<const double> at, Random& random) {
    CalibrationTask task = pinhole_task();
    for (int i = 0; i < static_cast<int>(at[0]); ++i)
      add_view(task, draw_parallel(at[1], random), random);
    return ask_all(std::move(task));
  });
  return map;
}

StabilityMap roll_map() {
  StabilityMap map;
  map.name = "calibrate-roll";
  map.title = "Calibration: eight views that differ by a turn about the optical axis only";
  map.axes = {{"tilt", "deg", {0, 1, 5, 10, 30, 50}, {}},
              {"turned by up to", "deg", {0, 5, 20, 90, 360}, {}}};
  map.what =
      "Of a plane that faces the camera, turns about the optical axis show nothing; of a tilted "
      "one "
      "they show all";
  map.why = "The vanishing line of a tilted plane turns with it (Sturm & Maybank, CVPR 1999)";
  map.answer =
      "tagcal has no rule of thumb for it: it accepts what the information holds, and refuses the "
      "rest";
  ask_calibration(map, all_solvers(), [](std::span<const double> at, Random& random) {
    CalibrationTask task = pinhole_task();
    const Pose first = draw_view(at[0], random);
    for (int i = 0; i < 8; ++i)
      add_view(task, rotation_about_z(kDegree * at[1] * i / 8) * first, random);
    return ask_all(std::move(task));
  });
  return map;
}

StabilityMap repeated_views_map() {
  enum Kind { identical, fresh };
  StabilityMap map;
  map.name = "calibrate-repeated";
  map.title = "Calibration: twelve views, of which few differ, 0.3 px of noise";
  map.axes = {{"copies", "", {identical, fresh}, {"the same corners", "fresh noise"}},
              {"different views", "", {1, 2, 3, 4, 6}, {}}};
  map.what =
      "A view that is repeated adds nothing, and standard deviations that count it shrink all the "
      "same";
  map.why =
      "Noise that is repeated is not independent, and poses that are repeated add no equation";
  map.answer = "tagcal counts copies once, and judges what is left by its information";
  ask_calibration(map, all_solvers(), [](std::span<const double> at, Random& random) {
    CalibrationTask task = pinhole_task();
    for (int i = 0; i < static_cast<int>(at[1]); ++i)
      add_view(task, draw_view(random.uniform(0, 45), random), random);
    const auto different = task.camera_from_board.size();
    CalibrationQuestion question;
    if (static_cast<int>(at[0]) == identical) question = ask_all(task);
    for (std::size_t i = different; i < 12; ++i) {
      const Pose pose = task.camera_from_board[i % different];
      if (static_cast<int>(at[0]) == fresh) {
        add_view(task, pose, random);
        continue;
      }
      question.dataset.views.push_back(question.dataset.views[i % different]);
      question.dataset.views.back().image = std::to_string(i);
    }
    return static_cast<int>(at[0]) == fresh ? ask_all(std::move(task)) : question;
  });
  return map;
}

StabilityMap board_unit_map() {
  StabilityMap map;
  map.name = "calibrate-unit";
  map.title = "Calibration: the unit of length of the board, eight views, 0.3 px of noise";
  map.axes = {{"unit", "m", {1e-6, 1e-4, 1e-3, 1e-2, 1, 1e2, 1e4, 1e5, 1e6}, {}}};
  map.what = "The same views of a board in another unit are another problem to a solver with units";
  map.why =
      "Steps and thresholds that mix radians and metres stop a solver early or make it blind "
      "(Hartley, PAMI 1997)";
  map.answer = "tagcal scales the board to its own size first: the answer is the same in any unit";
  map.exempt = {
      "a board stated in a wrong unit: the picture is the same, only distances are scaled"};
  ask_calibration(map, all_solvers(), [](std::span<const double> at, Random& random) {
    CalibrationTask task = pinhole_task();
    for (int i = 0; i < 8; ++i) add_view(task, draw_view(random.uniform(0, 45), random), random);
    CalibrationQuestion question = ask_all(std::move(task));
    auto& points = std::get<Points>(question.dataset.boards[0].board.pattern).points;
    for (TargetPoint& p : points) p.position *= at[0];
    return question;
  });
  return map;
}

}  // namespace tagcal::study
