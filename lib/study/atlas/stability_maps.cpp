#include "study/atlas/map_calibration.hpp"
#include "study/atlas/map_picture.hpp"
#include "study/atlas/map_pose.hpp"
#include "study/atlas/stability.hpp"

namespace tagcal::study {

std::vector<StabilityMap> stability_maps() {
  std::vector<StabilityMap> maps = pose_maps();
  for (StabilityMap& map : calibration_maps()) maps.push_back(std::move(map));
  for (StabilityMap& map : rig_maps()) maps.push_back(std::move(map));
  for (StabilityMap& map : picture_maps()) maps.push_back(std::move(map));
  return maps;
}

}  // namespace tagcal::study
