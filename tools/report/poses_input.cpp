#include "report/pose_report.hpp"

#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

SeenPose read_seen_pose(const YamlValue& pose) {
  // Files without it have the covariance of the noise as the only one.
  const auto of_noise = pose.find("noise_covariance");
  const YamlValue covariance = of_noise ? *of_noise : pose.at("covariance");
  if (!covariance.is_list())
    covariance.fail_plainly("is missing, the weight of the pose is unknown");
  SeenPose seen{read_pose(pose.at("camera_from_board"))};
  const std::vector<YamlValue> rows = covariance.items(6, 6);
  for (Eigen::Index i = 0; i < 6; ++i) {
    const std::vector<double> row = rows[static_cast<std::size_t>(i)].numbers(6);
    seen.covariance.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 6>>(row.data());
  }
  return seen;
}

}  // namespace

std::vector<HandeyeView> read_pose_file(const std::string& file) {
  constexpr std::size_t kMost = 100'000;  // a limit of work
  std::vector<HandeyeView> views;
  for (const YamlValue& view : YamlValue::read(file).at("views").items(1, kMost)) {
    views.push_back({view.at("image").text(), {}, {}, {}});
    if (const auto time = view.find("time_s"); time && time->is_number())
      views.back().time_s = time->number();
    const std::string status = view.at("status").text();
    if (status != status_name(Status::ok) && status != status_name(Status::ambiguous)) continue;
    views.back().poses.push_back(read_seen_pose(view));
    if (const auto other = view.find("alternative"); other && other->is_map())
      views.back().poses.push_back(read_seen_pose(*other));
  }
  return views;
}

}  // namespace tagcal::tools
