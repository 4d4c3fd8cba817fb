#include <algorithm>
#include <bitset>

#include "report/view_text.hpp"
#include "tagcal/viewing/clip.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;

std::string bits(unsigned code) { return std::bitset<4>(code).to_string(); }

// By region codes, and by the line's parameter: 0 at the point of --at, 1 at that of --to.
Json clipped_to_image(const Vector2d& from, const Vector2d& to) {
  const Window window;
  const Segment2 line{from, to};
  const unsigned a = outcode(window, from), b = outcode(window, to);
  Json result = {{"codes_top_bottom_right_left", bits(a) + " " + bits(b)},
                 {"codes_or", bits(a | b)},
                 {"codes_and", bits(a & b)},
                 {"codes_say", !(a | b)  ? "all inside"
                               : (a & b) ? "all outside, beyond one border"
                                         : "cut at a border, and test again"}};
  const auto part = clip_line_cohen_sutherland(window, line);
  result["by_codes_in_ndc"] = part ? Json({array(part->from), array(part->to)}) : Json();
  const auto range = clip_line_liang_barsky(window, line);
  const double squared = std::max((to - from).squaredNorm(), 1e-300);  // numeric: no line, t = 0
  const auto t = [&](const Vector2d& x) { return (x - from).dot(to - from) / squared; };
  result["by_parameter_t"] = range ? Json::array({t(range->from), t(range->to)}) : Json();
  return result;
}

}  // namespace

Json line_steps(const ViewReport& report) {
  const FollowedPoint &from = report.followed, &to = report.line_to->followed;
  Json result = {{"from", report.point.name}, {"to", report.line_to->point.name}};
  if (from.in_ndc && to.in_ndc) {
    result["from_in_ndc"] = array(*from.in_ndc);
    result["to_in_ndc"] = array(*to.in_ndc);
    result.update(clipped_to_image(from.in_ndc->head<2>(), to.in_ndc->head<2>()));
  } else {
    result["image"] = "an end is behind the eye: the line is cut in space first";
  }
  const auto inside =
      clip_segment(from.in_eye, to.in_eye, clip_planes(report.pipeline.clip_from_eye));
  result["in_space_by_six_planes_t"] = inside ? Json::array({inside->from, inside->to}) : Json();
  return result;
}

}  // namespace tagcal::tools
