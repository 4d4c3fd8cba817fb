#include "report/json_parts.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace tagcal::tools {

using Json = nlohmann::ordered_json;

Json matrix_json(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise())
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

Json pose_json(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation();
  const Eigen::Vector3d& t = pose.translation();
  return {{"rotation", {q.w(), q.x(), q.y(), q.z()}}, {"translation_m", {t.x(), t.y(), t.z()}}};
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json distance_json(double distance_m) {
  return std::isfinite(distance_m) ? Json(distance_m) : Json("infinity");
}

Json readout_json(const std::optional<Readout>& readout) {
  if (!readout) return nullptr;
  return {{"ms", 1e3 * readout->seconds},
          {"sigma_ms", 1e3 * readout->sigma_s},
          {"num_views", readout->num_views}};
}

}  // namespace tagcal::tools
