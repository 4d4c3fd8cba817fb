#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "page_data/json_values.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// A rig that was just calibrated, with or without an answer. `options`: of that calibration;
// `pictures`: the files by camera and View::image.
PageJson rig_page(const RigDataset& data, const RigCalibration& answer, const RigOptions& options,
                  const std::vector<std::map<std::string, std::filesystem::path>>& pictures);

// The rig of a file, which knows nothing of instants.
PageJson rig_page(const CameraFile& file, const std::string& name);

// The cameras of a file ("rig.yaml"), if it has several with their places. None for others, and for
// files that cannot be read.
std::optional<CameraFile> rig_in_file(const std::string& name);

}  // namespace tagcal::tools
