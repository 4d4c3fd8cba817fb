#include "study/peers/mrcal_peer.hpp"

#include <algorithm>

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

std::vector<mrcal_pose_t> poses_of(const std::vector<double>& values) {
  std::vector<mrcal_pose_t> poses(values.size() / 6);
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i] = {point(&values[6 * i]), point(&values[6 * i + 3])};
  return poses;
}

std::vector<double> values_of(const std::vector<mrcal_pose_t>& poses) {
  std::vector<double> values;
  for (const mrcal_pose_t& pose : poses) {
    values.insert(values.end(), pose.r.xyz, pose.r.xyz + 3);
    values.insert(values.end(), pose.t.xyz, pose.t.xyz + 3);
  }
  return values;
}

std::vector<mrcal_observation_board_t> observations_of(const std::vector<MrcalView>& views) {
  std::vector<mrcal_observation_board_t> observations(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    observations[i].icam = {views[i].camera, views[i].camera - 1};
    observations[i].iframe = views[i].frame;
  }
  return observations;
}

}  // namespace

bool has_mrcal() { return true; }

MrcalAnswer calibrate_by_mrcal(const MrcalProblem& problem) {
  const int num_cameras = problem.num_cameras;
  const auto num_views = static_cast<int>(problem.views.size());
  const std::array<double, 9> start = {problem.focal_px, problem.focal_px,
                                       0.5 * (problem.width - 1), 0.5 * (problem.height - 1)};
  MrcalAnswer answer{{static_cast<std::size_t>(num_cameras), start}, {}};
  std::vector<mrcal_pose_t> frames = poses_of(problem.poses),
                            cameras = poses_of(problem.camera_from_first);
  const std::vector<mrcal_observation_board_t> views = observations_of(problem.views);
  std::vector<mrcal_point3_t> pixels;
  for (std::size_t i = 0; i < problem.pixels.size(); i += 3)
    pixels.push_back(point(&problem.pixels[i]));
  std::vector<int> sizes;
  for (int c = 0; c < num_cameras; ++c) sizes.insert(sizes.end(), {problem.width, problem.height});
  const mrcal_problem_constants_t constants{};
  std::vector<double> values;  // of all lenses, with as many numbers as the model has
  const auto optimize = [&](mrcal_lensmodel_type_t type, std::size_t size, bool core) {
    values.clear();
    for (const auto& lens : answer.intrinsics)
      values.insert(values.end(), lens.begin(), lens.begin() + static_cast<std::ptrdiff_t>(size));
    mrcal_lensmodel_t lens{};
    lens.type = type;
    mrcal_problem_selections_t selections{};
    selections.do_optimize_intrinsics_core = core;
    selections.do_optimize_intrinsics_distortions = size > 4;
    selections.do_optimize_extrinsics = num_cameras > 1;
    selections.do_optimize_frames = true;
    mrcal_optimize(nullptr, 0, nullptr, 0, values.data(), cameras.data(), frames.data(), nullptr,
                   nullptr, num_cameras, num_cameras - 1, static_cast<int>(frames.size()), 0, 0,
                   views.data(), nullptr, num_views, 0, pixels.data(), &lens, sizes.data(),
                   selections, &constants, problem.spacing_m, problem.grid_columns,
                   problem.grid_rows, false, false);
    for (std::size_t c = 0; c < answer.intrinsics.size(); ++c)
      std::copy_n(&values[c * size], size, answer.intrinsics[c].begin());
  };
  optimize(MRCAL_LENSMODEL_PINHOLE, 4, false);
  optimize(MRCAL_LENSMODEL_PINHOLE, 4, true);
  optimize(MRCAL_LENSMODEL_OPENCV5, 9, true);
  answer.camera_from_first = values_of(cameras);
  return answer;
}

#else

bool has_mrcal() { return false; }
MrcalAnswer calibrate_by_mrcal(const MrcalProblem&) { return {}; }

#endif

}  // namespace tagcal::study
