#include "report/calibration_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "job/terminal.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kMostLines = 20;
constexpr std::size_t kMostTags = 6;     // named in a line
constexpr std::size_t kMostCorners = 3;  // of a tag, with a residual each
constexpr std::size_t kCornersOfATag = 4;

using DroppedTag = std::vector<const Outlier*>;

struct DroppedView {
  std::string_view image;
  std::map<int, DroppedTag> tags;
  std::size_t count = 0;
  bool whole = false;
};

// A corner without a residual counts as the worst.
double badness(const Outlier& o) {
  return std::isnan(o.residual_px) ? std::numeric_limits<double>::infinity() : o.residual_px;
}

double badness(const DroppedTag& tag) {
  double worst = 0;
  for (const Outlier* o : tag) worst = std::max(worst, badness(*o));
  return worst;
}

double badness(const DroppedView& view) {
  double worst = 0;
  for (const auto& [id, tag] : view.tags) worst = std::max(worst, badness(tag));
  return worst;
}

std::vector<DroppedView> by_view(const Calibration& calibration) {
  std::set<std::size_t> taken;
  for (const CalibratedView& view : calibration.views) taken.insert(view.view);
  std::map<std::size_t, DroppedView> views;
  for (const Outlier& o : calibration.outliers) {
    DroppedView& view = views[o.view];
    view.image = o.image;
    view.tags[o.id.tag_id].push_back(&o);
    ++view.count;
    view.whole = !taken.contains(o.view);
  }
  std::vector<DroppedView> sorted;
  for (auto& [index, view] : views) sorted.push_back(std::move(view));
  std::stable_sort(sorted.begin(), sorted.end(), [](const DroppedView& a, const DroppedView& b) {
    return std::pair(a.whole, badness(a)) > std::pair(b.whole, badness(b));
  });
  return sorted;
}

std::string pixels(double residual) {
  return std::isfinite(residual) ? fmt::format("{:.2f} px", residual) : "does not project";
}

std::string up_to(double residual) {
  return std::isfinite(residual) ? fmt::format("up to {:.2f} px", residual) : "some do not project";
}

// "tag 3 (up to 31.20 px)", "tag 5 corner 1 (8.40 px), 2 (7.10 px)"
std::string tag_text(int id, const DroppedTag& tag) {
  if (tag.size() >= kCornersOfATag) return fmt::format("tag {} ({})", id, up_to(badness(tag)));
  std::string text = fmt::format("tag {} corner", id);
  for (std::size_t i = 0; i < std::min(tag.size(), kMostCorners); ++i)
    text += fmt::format("{} {} ({})", i == 0 ? "" : ",", tag[i]->id.corner,
                        pixels(tag[i]->residual_px));
  return text;
}

std::string view_text(const DroppedView& view) {
  if (view.whole) {
    const double worst = badness(view);
    return fmt::format("  {}: the whole view, {} corners{}\n", view.image, view.count,
                       std::isfinite(worst) ? ", " + up_to(worst) : "");
  }
  std::vector<std::pair<int, DroppedTag>> tags(view.tags.begin(), view.tags.end());
  std::stable_sort(tags.begin(), tags.end(), [](const auto& a, const auto& b) {
    return badness(a.second) > badness(b.second);
  });
  std::string text;
  for (std::size_t i = 0; i < std::min(tags.size(), kMostTags); ++i)
    text += (i == 0 ? "" : "; ") + tag_text(tags[i].first, tags[i].second);
  if (tags.size() > kMostTags) text += fmt::format("; and {} tags more", tags.size() - kMostTags);
  const std::string many = view.count > 1 ? fmt::format("{} corners, ", view.count) : "";
  return fmt::format("  {}: {}{}\n", view.image, many, text);
}

// Reports the tags that are wrong in most views (a wrong target, not a wrong view) in one line
// each, and removes them from `views`.
std::string take_wrong_tags(std::vector<DroppedView>& views, std::size_t num_taken) {
  std::map<int, std::vector<DroppedTag>> tags;
  for (const DroppedView& view : views)
    if (!view.whole)
      for (const auto& [id, tag] : view.tags)
        if (tag.size() >= kCornersOfATag) tags[id].push_back(tag);
  std::string text;
  for (const auto& [id, dropped] : tags) {
    if (dropped.size() < 3 || 2 * dropped.size() < num_taken) continue;
    double worst = 0;
    for (const DroppedTag& tag : dropped) worst = std::max(worst, badness(tag));
    text += fmt::format("  tag {} in {} of {} views, {}: check it against the target file\n", id,
                        dropped.size(), num_taken, up_to(worst));
    for (DroppedView& view : views)
      if (!view.whole && view.tags.contains(id)) view.count -= view.tags[id].size();
    for (DroppedView& view : views)
      if (!view.whole) view.tags.erase(id);
  }
  std::erase_if(views, [](const DroppedView& view) { return view.tags.empty(); });
  return text;
}

// The worst tag or corner, and the pictures of which nothing is used.
std::string summary_of(const std::vector<DroppedView>& views) {
  std::string whole;
  for (const DroppedView& view : views)
    if (view.whole) whole += fmt::format("{}{}", whole.empty() ? "" : ", ", view.image);
  std::string text = fmt::format(", {}", up_to(badness(views.front())));
  if (!whole.empty()) text += "; not used: " + whole;
  return text + " (--verbose lists them)\n";
}

}  // namespace

std::string dropped_corners_text(const Calibration& calibration, bool verbose) {
  if (calibration.outliers.empty()) return verbose ? "rejected   none\n" : "";
  std::vector<DroppedView> views = by_view(calibration);
  std::string text = "rejected   " + counted(calibration.outliers.size(), "corner") + " in " +
                     counted(views.size(), "picture");
  if (!verbose) return text + summary_of(views);
  text += "\n";
  text += take_wrong_tags(views, calibration.views.size());
  for (std::size_t i = 0; i < std::min(views.size(), kMostLines); ++i) text += view_text(views[i]);
  if (views.size() > kMostLines) {
    text += fmt::format("  and {} pictures more (--json lists all)\n", views.size() - kMostLines);
  }
  return text;
}

}  // namespace tagcal::tools
