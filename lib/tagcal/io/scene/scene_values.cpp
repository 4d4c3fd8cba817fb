#include "tagcal/io/scene/scene_parts.hpp"

#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {

NumberOverViews numbers_over_views(const YamlValue& value) {
  return NumberOverViews(value.is_list() ? value.numbers(1, limits::kMaxValuesOfPath)
                                         : std::vector<double>{value.number()});
}

NumberOverViews degrees_over_views(const std::optional<YamlValue>& value) {
  std::vector<double> angles = {0};
  if (value)
    angles = value->is_list() ? value->numbers(1, limits::kMaxValuesOfPath)
                              : std::vector{value->number()};
  for (double& angle : angles) angle = radians(angle);
  return NumberOverViews(std::move(angles));
}

VectorOverViews vectors_over_views(const YamlValue& value) {
  const std::vector<YamlValue> items = value.items(1, limits::kMaxValuesOfPath);
  if (!items[0].is_list()) return VectorOverViews({read_vector(value)});
  std::vector<Eigen::Vector3d> vectors;
  for (const YamlValue& item : items) vectors.push_back(read_vector(item));
  return VectorOverViews(std::move(vectors));
}

}  // namespace tagcal::internal
