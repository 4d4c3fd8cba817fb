#include "study/peers/mrcal_peer.hpp"

#ifdef TAGCAL_HAS_MRCAL
extern "C" {
#include <mrcal/mrcal.h>
}
#endif

namespace tagcal::study {

#ifdef TAGCAL_HAS_MRCAL

namespace {

mrcal_point3_t point(const double* xyz) {
  mrcal_point3_t p;
  for (int i = 0; i < 3; ++i) p.xyz[i] = xyz[i];
  return p;
}

}  // namespace

bool has_mrcal() { return true; }

std::array<double, 9> mrcal_intrinsics(const MrcalProblem& problem) {
  const int num_views = static_cast<int>(problem.poses.size() / 6);
  std::array<double, 9> intrinsics = {problem.focal_px, problem.focal_px, 0.5 * (problem.width - 1),
                                      0.5 * (problem.height - 1)};
  std::vector<mrcal_pose_t> poses(static_cast<std::size_t>(num_views));
  std::vector<mrcal_observation_board_t> views(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].r = point(&problem.poses[6 * i]);
    poses[i].t = point(&problem.poses[6 * i + 3]);
    views[i].icam = {0, -1};
    views[i].iframe = static_cast<int>(i);
  }
  std::vector<mrcal_point3_t> pixels;
  for (std::size_t i = 0; i < problem.pixels.size(); i += 3)
    pixels.push_back(point(&problem.pixels[i]));
  const int size[] = {problem.width, problem.height};
  const mrcal_problem_constants_t constants{};
  const auto optimize = [&](mrcal_lensmodel_type_t type, bool core, bool distortions) {
    mrcal_lensmodel_t lens{};
    lens.type = type;
    mrcal_problem_selections_t selections{};
    selections.do_optimize_intrinsics_core = core;
    selections.do_optimize_intrinsics_distortions = distortions;
    selections.do_optimize_frames = true;
    mrcal_optimize(nullptr, 0, nullptr, 0, intrinsics.data(), nullptr, poses.data(), nullptr,
                   nullptr, 1, 0, num_views, 0, 0, views.data(), nullptr, num_views, 0,
                   pixels.data(), &lens, size, selections, &constants, problem.spacing_m,
                   problem.grid_columns, problem.grid_rows, false, false);
  };
  optimize(MRCAL_LENSMODEL_PINHOLE, false, false);
  optimize(MRCAL_LENSMODEL_PINHOLE, true, false);
  optimize(MRCAL_LENSMODEL_OPENCV5, true, true);
  return intrinsics;
}

#else

bool has_mrcal() { return false; }
std::array<double, 9> mrcal_intrinsics(const MrcalProblem&) { return {}; }

#endif

}  // namespace tagcal::study
