// Maps of lenses (extrapolation, fold, wrong model) and of boards that are not flat.

#include <cmath>

#include "study/atlas/map_calibration.hpp"

namespace tagcal::study {
namespace {

using Eigen::Vector2d;

const double kHalfDiagonalPx = std::hypot(640, 400);

// The views of a board that is bent by `bow_m` in its middle; the visible corners are those of the
// flat board.
CalibrationQuestion bent(CalibrationTask task, double bow_m, Random& random) {
  CalibrationQuestion question = ask_all(task);
  question.knowable = bow_m == 0;
  const double half = 0.5 * (kSmallGrid - 1) * kSmallSpacingM;
  const auto points = target_points(task.dataset.boards[0].board);
  for (std::size_t v = 0; v < task.dataset.views.size(); ++v)
    for (Observation& o : question.dataset.views[v].observations) {
      Eigen::Vector3d x = points[static_cast<std::size_t>(o.id.tag_id)].position;
      x.z() += bow_m * (1 - std::pow(x.x() / half, 2));
      const auto pixel = project(task.lens, task.camera_from_board[v] * x);
      if (pixel) o.pixel = *pixel + task.sigma_px * Vector2d(random.normal(), random.normal());
    }
  return question;
}

}  // namespace

StabilityMap extrapolation_map() {
  StabilityMap map;
  map.name = "calibrate-extrapolation";
  map.title = "Calibration: corners in the middle of the image only, judged at its corners";
  map.axes = {{"distortion k1", "", {0, -0.03, -0.1, -0.28}, {}},
              {"reach", "half diagonals", {0.2, 0.35, 0.5, 0.7, 1}, {}}};
  map.what = "Where there were no corners, distortion is anything that a polynomial makes of noise";
  map.why =
      "Powers of the radius are correlated, and the difference grows with the highest "
      "power outside of the data (mrcal's tour; limits of extrapolation of any polynomial)";
  map.answer =
      "tagcal gives the standard deviation of the projection over the whole image, names the parts "
      "without corners as extrapolated, and takes no more coefficients than the corners show; an "
      "answer that is wrong there with that warning counts as said";
  map.exempt = {
      "distortion that the corners do not reach: a smaller lens explains them as well, and says "
      "that the image's corners are extrapolated"};
  ask_calibration(
      map,
      {our_calibration(), our_calibration_by_name("opencv5"), opencv_calibration(),
       opencv_calibration_of("radial2")},
      [](std::span<const double> at, Random& random) {
        const double k1 = at[0];
        // This k2 removes the fold.
        CalibrationTask task =
            empty_task(Perspective({900, 900, 651, 392, k1, 0.9 * k1 * k1}), "radial2", 0.3);
        const Vector2d centre(639.5, 399.5);
        const double reach = at[1] * kHalfDiagonalPx;
        for (int i = 0; i < 10; ++i)
          add_view(task, draw_view(random.uniform(0, 45), random, at[1] < 0.4 ? 1.5 : 0.8), random,
                   [&](const Vector2d& pixel) { return (pixel - centre).norm() < reach; });
        return ask_all(std::move(task), JudgedLens::image_corners);
      });
  return map;
}

StabilityMap fold_map() {
  StabilityMap map;
  map.name = "calibrate-fold";
  map.title = "Calibration: corners up to the fold of the distortion, 0.3 px of noise";
  map.axes = {{"fold at", "half diagonals", {0.6, 0.8, 1, 1.3, 2}, {}},
              {"reach", "fold radii", {0.5, 0.8, 0.95, 1}, {}}};
  map.what = "Beyond its fold a polynomial lens puts points back into the image";
  map.why =
      "1 + 3 k1 r^2 + 5 k2 r^4 + 7 k3 r^6 = 0 has a root within the picture (Leotta et al., WACV "
      "2022: in 30 % of the lenses of Lensfun)";
  map.answer =
      "tagcal knows the fold of every lens, projects nothing beyond it, and corners there are not "
      "of its domain";
  ask_calibration(map,
                  {our_calibration(), our_calibration_by_name(), opencv_calibration(),
                   opencv_calibration_of("radial2")},
                  [](std::span<const double> at, Random& random) {
                    // With k1 alone the fold is at r^2 = -1 / (3 k1), seen at 2/3 r.
                    const double fold = 1.5 * at[0] * kHalfDiagonalPx / 900;
                    CalibrationTask task = empty_task(
                        Perspective({900, 900, 651, 392, -1 / (3 * fold * fold)}), "radial1", 0.3);
                    const double radius = at[1] * fold;
                    const double share = radius * (1 - radius * radius / (3 * fold * fold));
                    for (int i = 0; i < 10; ++i)
                      add_view(task, draw_view(random.uniform(0, 45), random, 0.6), random,
                               [&](const Vector2d& pixel) {
                                 return (pixel - Vector2d(651, 392)).norm() < 900 * share;
                               });
                    return ask_all(std::move(task), JudgedLens::projection);
                  });
  return map;
}

StabilityMap bent_board_map() {
  StabilityMap map;
  map.name = "calibrate-bent";
  map.title = "Calibration: a board of 0.6 m that is bent, eight views";
  map.axes = {{"noise", "px", {0.1, 0.3}, {}},
              {"bow in the middle", "mm", {0, 0.1, 0.2, 0.5, 1, 2}, {}}};
  map.what = "A board that is not flat makes the focal length wrong by many standard deviations";
  map.why =
      "Its bend is explained by focal length and distortion where it is not asked for, and the "
      "residuals hardly grow (Kogan, mrcal: calobject_warp)";
  map.answer =
      "tagcal estimates the bend of every flat board, tests halves of the views and residuals that "
      "go together, and warns; wrong with such a warning counts as said";
  map.exempt = {"a bend of which the residuals hold no trace beyond their noise"};
  ask_calibration(map,
                  {our_calibration(), our_calibration_by_name(), opencv_calibration(),
                   opencv_calibration_of("pinhole")},
                  [](std::span<const double> at, Random& random) {
                    CalibrationTask task = pinhole_task();
                    task.sigma_px = at[0];
                    for (int i = 0; i < 8; ++i)
                      add_view(task, draw_view(random.uniform(0, 45), random), random);
                    return bent(std::move(task), at[1] * 1e-3, random);
                  });
  return map;
}

StabilityMap wrong_lens_map() {
  enum Kind { brown, fisheye };
  StabilityMap map;
  map.name = "calibrate-wrong-lens";
  map.title = "Calibration: the lens of the data and the lens that is asked for, 0.3 px of noise";
  map.axes = {{"data of", "", {brown, fisheye}, {"Brown lens", "fisheye"}},
              {"focal length", "px", {400, 550, 900, 1500}, {}}};
  map.what = "A lens that is not the camera's fits with a bias that its residuals spread out";
  map.why =
      "Two polynomials, of tan(angle) and of the angle, agree in the middle and part towards the "
      "border (Kannala & Brandt, PAMI 2006)";
  map.answer =
      "tagcal fits both kinds and takes the one that explains the corners; asked for the other it "
      "warns that residuals go together, or refuses; wrong with such a warning counts as said";
  ask_calibration(map,
                  {our_calibration(), our_calibration_by_name("opencv5"),
                   our_calibration_by_name("fisheye4"), opencv_calibration(), opencv_fisheye()},
                  [](std::span<const double> at, Random& random) {
                    const double f = at[1];
                    const bool wide = static_cast<int>(at[0]) == fisheye;
                    const Lens lens =
                        wide ? Lens(Fisheye({f, f, 633, 405, 0.02, -0.01, 0.003, -0.0005}))
                             : Lens(Perspective({f, f, 651, 392, -0.1, 0.02, 5e-4, -3e-4}));
                    CalibrationTask task = empty_task(lens, wide ? "fisheye4" : "opencv5", 0.3);
                    for (int i = 0; i < 10; ++i)
                      add_view(task, draw_view(random.uniform(0, 45), random, f / 1100), random);
                    return ask_all(std::move(task), JudgedLens::projection);
                  });
  return map;
}

}  // namespace tagcal::study
