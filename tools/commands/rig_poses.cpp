#include "commands/rig_poses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "job/camera_input.hpp"
#include "report/pose_report.hpp"
#include "report/rig_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/rig_file.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

PoseReport report_of(const RigPoseEstimate& estimate, const KnownRig& rig,
                     const std::vector<ViewCorrespondences>& seen) {
  PoseReport report = reported(estimate.rig);
  for (std::size_t c = 0; c < seen.size(); ++c) {
    if (estimate.takes_part[c] == 0) continue;
    report.cameras.push_back(rig.cameras[c].name);
    for (const std::size_t i : estimate.of_cameras[c].outliers)
      report.outliers.push_back(report.corners.size() + i);
    report.corners.insert(report.corners.end(), seen[c].ids.begin(), seen[c].ids.end());
  }
  return report;
}

}  // namespace

bool is_rig_file(const std::string& file_and_name) {
  std::error_code error;
  return std::filesystem::exists(file_and_name, error) &&
         read_camera_file(file_and_name).cameras.size() > 1;
}

std::vector<PlacedBoard> in_frame_of_poses(std::vector<PlacedBoard> boards) {
  if (boards.size() == 1) boards[0].world_from_board = Pose();
  return boards;
}

void check_folders_of_rig(const RigInputArguments& arguments, const CameraFile& file,
                          const std::string& name) {
  const std::vector<std::string>& inputs = arguments.input.inputs;
  if (file.cameras.size() < 2 || inputs.size() > 1 || is_rig_folder(inputs.front())) return;
  std::vector<std::string> names;
  for (const FileCamera& camera : file.cameras) names.push_back(camera.name);
  throw Error(
      fmt::format("{}: has the cameras {}: give a folder (or film) of each, with its name, or a "
                  "data set with the key rig; got only {}",
                  name, fmt::join(names, ", "), inputs.front()));
}

RigInput read_rig_for_poses(const RigInputArguments& arguments, const CameraFile& file,
                            const std::string& name) {
  check_folders_of_rig(arguments, file, name);
  RigInput read = read_rig(arguments);
  for (RigCamera& camera : read.rig.cameras)
    camera.data.boards = in_frame_of_poses(std::move(camera.data.boards));
  return read;
}

std::optional<double> time_of(const Instant& instant, const RigDataset& data) {
  for (std::size_t c = 0; c < data.cameras.size(); ++c)
    if (const auto& view = instant.view[c]; view && !data.cameras[c].times_s.empty())
      return data.cameras[c].times_s[*view];
  return std::nullopt;
}

std::vector<ViewCorrespondences> seen_at(const Instant& instant, const RigDataset& data,
                                         const KnownRig& rig) {
  std::vector<ViewCorrespondences> seen(data.cameras.size());
  for (std::size_t c = 0; c < seen.size(); ++c)
    if (const auto& view = instant.view[c])
      seen[c] = view_correspondences(data.cameras[c].data.views[*view], data.cameras[c].data.boards,
                                     rig.cameras[c].camera_error_px);
  return seen;
}

KnownRig rig_of(const RigDataset& data, const CameraFile& file, const std::string& name) {
  hold_notes(name, file.notes);
  const KnownRig all = known_rig(file, name);
  std::vector<std::size_t> cameras;
  const std::string names = internal::joined(all.cameras, ", ", &KnownRig::Member::name);
  for (const RigCamera& camera : data.cameras) {
    const auto found = std::ranges::find(all.cameras, camera.name, &KnownRig::Member::name);
    if (found == all.cameras.end())
      throw Error(fmt::format("{}: has no camera {}, only {}: folders must have the cameras' names",
                              name, camera.name, names));
    if (found->camera.camera.image_size != camera.data.image_size)
      throw Error(fmt::format(
          "{}: the image size of {} must be {}x{} as in its pictures, got {}x{}; if these were "
          "scaled or cut, convert the rig with --resize or --crop",
          name, camera.name, camera.data.image_size.width, camera.data.image_size.height,
          found->camera.camera.image_size.width, found->camera.camera.image_size.height));
    cameras.push_back(static_cast<std::size_t>(found - all.cameras.begin()));
  }
  return selected(all, cameras);
}

std::vector<PoseReport> poses_of_rig(const RigInputArguments& arguments, const std::string& file,
                                     double sigma_px) {
  const CameraFile cameras = read_camera_file(file);
  const RigInput read = read_rig_for_poses(arguments, cameras, file);
  const RigDataset& data = read.rig;
  const KnownRig rig = rig_of(data, cameras, file);
  PoseOptions options;
  options.sigma_px = sigma_px;
  std::vector<PoseReport> reports(data.instants.size());
  parallel_for(reports.size(), static_cast<std::size_t>(arguments.threads), [&](std::size_t t) {
    const std::vector<ViewCorrespondences> seen = seen_at(data.instants[t], data, rig);
    reports[t] = report_of(estimate_rig_pose(seen, rig, options), rig, seen);
    reports[t].image = name_of(data.instants[t], data);
    reports[t].time_s = time_of(data.instants[t], data);
    report_mistakes(read.mistakes, reports[t]);
  });
  return reports;
}

}  // namespace tagcal::tools
