#include "job/view_report.hpp"

#include <fmt/format.h>

#include "job/view_values.hpp"
#include "tagcal/viewing/clip.hpp"
#include "tagcal/viewing/projection.hpp"
#include "tagcal/viewing/viewport.hpp"

namespace tagcal::tools {

std::string planes_beyond(const ViewReport& report) {
  const auto planes = clip_planes(report.pipeline.clip_from_eye);
  std::string text;
  for (std::size_t i = 0; i < planes.size() && !report.followed.in_volume; ++i)
    if (planes[i].height(report.followed.in_eye) < 0)
      text += (text.empty() ? "" : " and ") + std::string(kPlaneNames[i]);
  return text;
}

std::string pinhole_note(const ViewReport& report) {
  const Camera& camera = report.pipeline.camera;
  const auto pinhole = field_of_view(undistorted(camera)), lens = field_of_view(camera);
  if (!kind_of(camera.lens).reaches_behind || !pinhole) return "";
  return fmt::format(
             "rows clip, ndc, raster: of the pinhole with the same focal length on the axis, "
             "{:.0f} "
             "deg across",
             degrees(pinhole->horizontal_rad)) +
         (lens ? fmt::format("; the lens sees {:.0f} deg", degrees(lens->horizontal_rad)) : "");
}

std::string sight_line(const FollowedPoint& f) {
  return f.hidden_by.empty() ? std::string(sight_text(f.sight))
                             : "not seen: hidden by " + f.hidden_by;
}

}  // namespace tagcal::tools
