#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "page_data/page_parts.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kMostNamed = 3;

struct Residuals {
  int num_corners = 0;  // used
  int num_rejected = 0;
  double square_px2 = 0;
  double max_px = 0;
  int num_known = 0;
};

std::vector<Residuals> by_view(const std::vector<PageCorner>& corners, std::size_t num_views) {
  std::vector<Residuals> all(num_views);
  for (const PageCorner& c : corners) {
    Residuals& view = all[c.view];
    ++(c.rejected ? view.num_rejected : view.num_corners);
    const double size = c.residual_px.norm();
    if (c.rejected || !std::isfinite(size)) continue;
    view.square_px2 += size * size;
    view.max_px = std::max(view.max_px, size);
    ++view.num_known;
  }
  return all;
}

std::string status_of(const PageContent& content, std::size_t view) {
  if (content.estimate_of(view)) return "ok";
  return content.dataset.views[view].observations.empty() ? "no corners" : "rejected";
}

}  // namespace

const CalibratedView* PageContent::estimate_of(std::size_t view) const {
  const auto found = std::ranges::find(calibration.views, view, &CalibratedView::view);
  return found == calibration.views.end() ? nullptr : &*found;
}

std::vector<std::filesystem::path> picture_files_of(const PageContent& content) {
  std::vector<std::filesystem::path> files;
  for (const View& view : content.dataset.views) {
    const auto found = content.pictures.find(view.image);
    files.push_back(found == content.pictures.end() ? "" : found->second);
  }
  return files;
}

void add_thumbnail(PageJson& view, const Thumbnail& thumbnail) {
  const bool has = !thumbnail.data_uri.empty();
  view["thumbnail"] = has ? PageJson(thumbnail.data_uri) : PageJson();
  view["thumbnail_size"] =
      has ? PageJson({thumbnail.size.width, thumbnail.size.height}) : PageJson();
  view["sentence"] = has ? PageJson() : PageJson(thumbnail.problem);
}

void note_missing(const std::vector<std::string>& names, const std::vector<Thumbnail>& thumbnails,
                  std::vector<std::string>& notes) {
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < thumbnails.size(); ++i)
    if (thumbnails[i].data_uri.empty()) missing.push_back(i);
  if (missing.empty()) return;
  std::string text;
  for (std::size_t k = 0; k < std::min(kMostNamed, missing.size()); ++k)
    text += (k == 0 ? "" : ", ") + names[missing[k]];
  if (missing.size() > kMostNamed) text += ", ..";
  notes.push_back(fmt::format("Pictures that are not shown: {} of {} ({}). {}", missing.size(),
                              names.size(), text, thumbnails[missing.front()].problem));
}

PageJson views_json(const PageContent& content, const std::vector<PageCorner>& corners,
                    const std::vector<Thumbnail>& thumbnails, std::vector<std::string>& notes) {
  const std::vector<Residuals> residuals = by_view(corners, content.dataset.views.size());
  const bool answered = is_answer(content.calibration.status);
  PageJson list = PageJson::array();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < content.dataset.views.size(); ++i) {
    const Residuals& r = residuals[i];
    const CalibratedView* const estimate = answered ? content.estimate_of(i) : nullptr;
    const bool has_depth = estimate && !estimate->scale_px_per_m;
    names.push_back(content.dataset.views[i].image);
    const auto time = content.times_s.find(names.back());
    PageJson view = {
        {"image", names.back()},
        {"time_s", time == content.times_s.end() ? PageJson() : decimals(time->second, 6)},
        {"status", answered ? status_of(content, i) : "no pose"},
        {"num_corners", r.num_corners},
        {"num_rejected", r.num_rejected},
        {"rms_px",
         r.num_known > 0 ? significant(std::sqrt(r.square_px2 / r.num_known)) : PageJson()},
        {"max_px", r.num_known > 0 ? significant(r.max_px) : PageJson()},
        {"camera_from_world", has_depth ? matrix_json(estimate->camera_from_world) : PageJson()}};
    add_thumbnail(view, thumbnails[i]);
    list.push_back(std::move(view));
  }
  note_missing(names, thumbnails, notes);
  return list;
}

}  // namespace tagcal::tools
