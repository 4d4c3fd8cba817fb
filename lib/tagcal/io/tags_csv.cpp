#include "tagcal/io/corners_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "tagcal/io/text_file.hpp"

namespace tagcal {

std::string tags_csv(const std::vector<std::string>& images,
                     const std::vector<std::vector<DetectedTag>>& tags) {
  const bool has_covariances = std::ranges::any_of(tags, [](const auto& of_image) {
    return std::ranges::any_of(of_image,
                               [](const DetectedTag& t) { return t.covariance_px2.has_value(); });
  });
  fmt::memory_buffer out;
  const auto end = std::back_inserter(out);
  fmt::format_to(end, "image,tag_id,corner,x_px,y_px{},instance\n",
                 has_covariances ? ",sxx_px2,sxy_px2,syy_px2" : "");
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string image = image_field(images[i]);
    std::map<int, int> count;
    for (const DetectedTag& tag : tags[i]) {
      const int instance = count[tag.id]++;
      for (int c = 0; c < 4; ++c) {
        const Eigen::Vector2d& at = tag.corners[static_cast<std::size_t>(c)];
        fmt::format_to(end, "{},{},{},{},{}", image, tag.id, c, at.x(), at.y());
        if (tag.covariance_px2) {
          const Matrix2 s = tag.covariance_px2->block<2, 2>(2 * c, 2 * c);
          fmt::format_to(end, ",{},{},{}", s(0, 0), s(0, 1), s(1, 1));
        } else if (has_covariances) {
          fmt::format_to(end, ",,,");
        }
        fmt::format_to(end, ",{}\n", instance);
      }
    }
  }
  return fmt::to_string(out);
}

}  // namespace tagcal
