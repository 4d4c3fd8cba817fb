#include "page_data/pages.hpp"

#include <cmath>

#include "page_data/page_parts.hpp"
#include "report/calibration_report.hpp"
#include "report/json_parts.hpp"

namespace tagcal::tools {
namespace {

// The keys of the summary.
void add_summary(const PageContent& content, const std::vector<PageCorner>& corners,
                 PageJson& page) {
  const Calibration& c = content.calibration;
  const bool has_corners = !corners.empty();
  const bool answered = is_answer(c.status);
  page["rms_px"] = has_corners && answered ? significant(c.rms_px) : PageJson();
  page["noise_px"] =
      !c.sigma_of_corners && c.sigma_px > 0 && answered ? significant(c.sigma_px) : PageJson();
  page["noise_sentence"] = answered && c.sigma_px > 0 ? PageJson(noise_sentence(c)) : PageJson();
  page["num_corners"] = has_corners ? PageJson(c.num_corners) : PageJson();
  page["num_pictures"] = has_corners ? PageJson(c.views.size()) : PageJson();
  page["num_rejected"] = has_corners ? PageJson(c.outliers.size()) : PageJson();
  page["seconds"] = content.seconds ? significant(*content.seconds, 3) : PageJson();
}

}  // namespace

PageJson calibration_page(const PageContent& content) {
  const Calibration& c = content.calibration;
  const ImageSize size = c.camera ? c.camera->image_size : content.dataset.image_size;
  std::vector<std::string> notes = content.notes;
  const std::vector<PageCorner> corners = page_corners(content);
  const std::vector<Thumbnail> pictures =
      thumbnails(picture_files_of(content), size, content.threads);
  PageJson page = {{"format", 1},
                   {"kind", "calibration"},
                   {"title", content.title},
                   {"verdict", verdict_json(c.status, c.findings,
                                            verdict_sentence(c, content.chosen.value_or(false)))},
                   {"status", status_name(c.status)},
                   {"model", c.model.empty() ? PageJson() : PageJson(c.model)},
                   {"chosen", content.chosen ? PageJson(*content.chosen) : PageJson()},
                   {"made_by", made_by_json()}};
  page["findings"] = page_findings_json(c.findings);
  page["image_size"] = {size.width, size.height};
  page["parameters"] = parameters_json(c);
  add_summary(content, corners, page);
  page["seen"] = seen_json(c.seen);
  page["projection"] = projection_maps_json(content);
  page["corners"] = corners_json(corners);
  page["views"] = views_json(content, corners, pictures, notes);
  page["boards"] = boards_json(content.dataset.boards);
  if (c.readout) page["readout"] = readout_json(*c.readout);
  page["warp"] = warp_json(content.dataset.boards, c.board_warp);
  page["ladder"] = ladder_json(c);
  page["halves"] = halves_json(c.halves);
  page["advice"] = advice_json(content);
  page["formats"] = formats_json(c, notes);
  page["notes"] = notes;
  return page;
}

}  // namespace tagcal::tools
