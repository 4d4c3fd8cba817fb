#include "draw/view_panels.hpp"

#include <fmt/format.h>

#include <string_view>

#include "draw/svg_panel.hpp"
#include "job/plain_text.hpp"
#include "job/view_values.hpp"

namespace tagcal::tools {
namespace {

constexpr PanelSize kScene{760, 600};
constexpr PanelSize kImage{480, 350};
constexpr PanelSize kNdc{480, 315};
constexpr double kGap = 20;       // around and between the panels
constexpr double kTitle = 20;     // height of a panel's title
constexpr double kCaptions = 95;  // height below the scene

std::string text(double x, double y, std::string_view words) {
  return fmt::format("<text x=\"{}\" y=\"{}\">{}</text>\n", x, y, xml_text(words));
}

template <typename Vector>
std::string caption(int row, std::string_view frame, const Vector& v, std::string_view unit) {
  std::string numbers;
  for (const double x : v)
    numbers += fmt::format("{}{:.4f}", numbers.empty() ? "" : ", ", std::abs(x) < 0.5e-4 ? 0 : x);
  return text(kGap + row / 4 * 380, kGap + kTitle + kScene.height + 25 + row % 4 * 18,
              fmt::format("{}: ({}){}", frame, numbers, unit));
}

std::string captions(const FollowedPoint& f) {
  std::string svg;
  int row = 0;
  if (f.in_board) svg += caption(row++, "board", *f.in_board, " m");
  svg += caption(row++, "world", f.in_world, " m");
  svg += caption(row++, "camera", f.in_camera, " m");
  svg += caption(row++, "eye", f.in_eye, " m");
  svg += caption(row++, "clip", f.in_clip, "");
  if (f.in_ndc) svg += caption(row++, "ndc", *f.in_ndc, "");
  if (f.in_raster_px) svg += caption(row++, "raster (open circle)", *f.in_raster_px, " px");
  if (f.pixel) svg += caption(row++, "pixel (dot)", *f.pixel, " px");
  return svg;
}

std::string panel(std::string_view id, double x, double y, const PanelSize& size,
                  std::string_view title, const std::string& content) {
  return text(x, y - 6, title) +
         fmt::format(
             "<g id=\"{}\" transform=\"translate({},{})\" data-size=\"{} {}\">\n"
             "<rect width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#ddd\"/>\n{}</g>\n",
             id, x, y, size.width, size.height, size.width, size.height, content);
}

}  // namespace

std::string view_svg(const ViewReport& report) {
  const double width = 3 * kGap + kScene.width + kImage.width;
  const double height = kGap + kTitle + kScene.height + kCaptions + kGap;
  const double right = 2 * kGap + kScene.width, top = kGap + kTitle;
  const std::string note = pinhole_note(report);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"13\">\n"
      "<title>{2}</title>\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
      width, height, xml_text(report.image));
  svg += panel("scene", kGap, top, kScene, "the scene with the camera's view volume",
               scene_panel(report, kScene));
  svg += panel("image", right, top, kImage,
               fmt::format("the image {}; {}: {}", report.image, report.point.name,
                           sight_line(report.followed)),
               image_panel(report, kImage));
  svg += panel("ndc", right, top + kImage.height + kTitle + 5, kNdc,
               "NDC: the view volume, divided by w (cabinet projection)", ndc_panel(report, kNdc));
  svg += captions(report.followed);
  if (!note.empty()) svg += text(kGap, height - 8, note);
  return svg + "</svg>\n";
}

}  // namespace tagcal::tools
