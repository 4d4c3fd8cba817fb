#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "page_data/json_values.hpp"
#include "tagcal/estimate/rig_types.hpp"

namespace tagcal::tools {

// One instant of the pair of cameras with the most instants, rectified, with lines across both
// pictures: the instant whose pictures show the most corners. `pictures`: files by camera and
// View::image. Null if no instant has both files, a file cannot be read, or the pair has no
// rectification (rectify.hpp). Precondition: the rig has an answer.
PageJson rectified_json(const RigDataset& data, const RigCalibration& answer,
                        const std::vector<std::map<std::string, std::filesystem::path>>& pictures);

}  // namespace tagcal::tools
