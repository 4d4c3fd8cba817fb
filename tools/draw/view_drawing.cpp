#include <fmt/format.h>

#include <string_view>

#include "draw/scene_drawing.hpp"
#include "draw/view_panels.hpp"
#include "job/view_values.hpp"

namespace tagcal::tools {
namespace {

using Eigen::Vector2d;
using study::Drawing;

constexpr PanelSize kScene{760, 600};
constexpr PanelSize kImage{480, 350};
constexpr PanelSize kNdc{480, 315};
constexpr double kGap = 20;         // around and between the panels
constexpr double kTitle = 20;       // height of a panel's title
constexpr double kCaptions = 95;    // height below the scene
constexpr double kTextSize = 10.4;  // of letters, points

void add_text(double x, double y, std::string_view words, Drawing& drawing) {
  drawing.text(x, y, words, kTextSize);
}

template <typename Vector>
std::string caption(std::string_view frame, const Vector& v, std::string_view unit) {
  std::string numbers;
  for (const double x : v)
    numbers += fmt::format("{}{:.4f}", numbers.empty() ? "" : ", ", std::abs(x) < 0.5e-4 ? 0 : x);
  return fmt::format("{}: ({}){}", frame, numbers, unit);
}

void add_captions(const FollowedPoint& f, Drawing& drawing) {
  std::vector<std::string> captions;
  if (f.in_board) captions.push_back(caption("board", *f.in_board, " m"));
  captions.push_back(caption("world", f.in_world, " m"));
  captions.push_back(caption("camera", f.in_camera, " m"));
  captions.push_back(caption("eye", f.in_eye, " m"));
  captions.push_back(caption("clip", f.in_clip, ""));
  if (f.in_ndc) captions.push_back(caption("ndc", *f.in_ndc, ""));
  if (f.in_raster_px) captions.push_back(caption("raster (open circle)", *f.in_raster_px, " px"));
  if (f.pixel) captions.push_back(caption("pixel (dot)", *f.pixel, " px"));
  constexpr std::size_t kRows = 4;
  for (std::size_t i = 0; i < captions.size(); ++i)
    add_text(kGap + 380 * static_cast<double>(i / kRows),
             kGap + kTitle + kScene.height + 20 + 18 * static_cast<double>(i % kRows), captions[i],
             drawing);
}

void add_panel(const Vector2d& place, const PanelSize& size, std::string_view title,
               const Drawing& panel, Drawing& drawing) {
  add_text(place.x(), place.y() - 11, title, drawing);
  const double right = place.x() + size.width, bottom = place.y() + size.height;
  add_outline({place, {right, place.y()}, {right, bottom}, {place.x(), bottom}}, "#dddddd", 1,
              drawing);
  drawing.add(panel, place);
}

}  // namespace

Drawing view_drawing(const ViewReport& report) {
  Drawing drawing{3 * kGap + kScene.width + kImage.width,
                  kGap + kTitle + kScene.height + kCaptions + kGap};
  const double right = 2 * kGap + kScene.width, top = kGap + kTitle;
  add_panel({kGap, top}, kScene, "the scene with the camera's view volume",
            scene_panel(report, kScene), drawing);
  add_panel({right, top}, kImage,
            fmt::format("the image {}; {}: {}", report.image, report.point.name,
                        sight_line(report.followed)),
            image_panel(report, kImage), drawing);
  add_panel({right, top + kImage.height + kTitle + 5}, kNdc,
            "NDC: the view volume, divided by w (cabinet projection)", ndc_panel(report, kNdc),
            drawing);
  add_captions(report.followed, drawing);
  add_text(kGap, drawing.height - 13, pinhole_note(report), drawing);
  return drawing;
}

}  // namespace tagcal::tools
