#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands/rig_input.hpp"
#include "report/pose_report.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// True for a file with several cameras, of which none is named.
bool is_rig_file(const std::string& file_and_name);

// Boards as poses take them: a single one has its own frame, several that of their world.
std::vector<PlacedBoard> in_frame_of_poses(std::vector<PlacedBoard> boards);

// Throws Error for the folder of one camera where the file of a rig, by its name, needs those of
// several.
void check_folders_of_rig(const RigInputArguments& arguments, const CameraFile& file,
                          const std::string& name);

// The data of the rig of a file, with its boards in the frame of poses.
RigInput read_rig_for_poses(const RigInputArguments& arguments, const CameraFile& file,
                            const std::string& name);

// The corners that each camera of a rig saw at an instant.
std::vector<ViewCorrespondences> seen_at(const Instant& instant, const RigDataset& data,
                                         const KnownRig& rig);

// By the clock of its first camera that has times; no value if none has.
std::optional<double> time_of(const Instant& instant, const RigDataset& data);

// The cameras of a rig's file in the order of a data set, matched by name. Throws Error for a
// camera that the file lacks, or of another image size.
KnownRig rig_of(const RigDataset& data, const CameraFile& file, const std::string& name);

// The pose of a known rig at each instant of what it saw.
std::vector<PoseReport> poses_of_rig(const RigInputArguments& arguments, const std::string& file,
                                     double sigma_px);

}  // namespace tagcal::tools
