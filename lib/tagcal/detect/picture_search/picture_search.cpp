#include "tagcal/detect/picture_search/picture_search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "tagcal/detect/board_search/tag_count.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"

namespace tagcal::internal {
namespace {

void warn_of(const SeenTags& seen, const std::string& family, const std::string& name,
             std::vector<std::string>& warnings) {
  if (!seen.strange.empty()) {
    warnings.push_back(fmt::format("{}: {} tags on no board are not reported: {}", name, family,
                                   fmt::join(seen.strange, ", ")));
  }
  if (!seen.repeated.empty()) {
    warnings.push_back(fmt::format("{}: {} tags seen more than once are not reported: {}", name,
                                   family, fmt::join(seen.repeated, ", ")));
  }
}

void add_corners(const FoundTag& tag, View& view) {
  for (int i = 0; i < 4; ++i) {
    Observation seen{{tag.id, i}, tag.corners[static_cast<std::size_t>(i)], {}};
    if (tag.fitted) seen.covariance_px2 = tag.covariance_px2.block<2, 2>(2 * i, 2 * i);
    view.observations.push_back(seen);
  }
}

}  // namespace

PictureSearch::PictureSearch(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
    : camera_(options.camera),
      searches_(tag_searches(boards, options)),
      checkers_(boards, options),
      circles_(boards, options) {}

DetectedPicture PictureSearch::find(const ImageView8& image, const std::string& name) {
  return find(image, name, false);
}

DetectedPicture PictureSearch::find_first(const ImageView8& image, const std::string& name) {
  return find(image, name, true);
}

DetectedPicture PictureSearch::find_next(const ImageView8& image, const std::string& name) {
  return find(image, name, true, std::exchange(last_, std::nullopt));
}

DetectedPicture PictureSearch::find(const ImageView8& image, const std::string& name,
                                    bool in_sequence, std::optional<Seen> before) {
  last_.reset();
  has_followed_ = false;
  check_size(camera_, image.size(), name);
  DetectedPicture found;
  found.view.image = name;
  found.size = image.size();
  if (std::min(image.width(), image.height()) < kMinPictureSidePx) {
    found.warnings.push_back(fmt::format("{}: smaller than {}x{} pixels, was not searched", name,
                                         kMinPictureSidePx, kMinPictureSidePx));
    return found;
  }
  const PictureToSearch picture(image);
  if (picture.gain > 1)
    found.warnings.push_back(fmt::format(
        "{}: is a raw mosaic (levels of even and odd pixels differ by a factor of {:.1f}): their "
        "levels were made equal",
        name, picture.gain));
  Seen seen;
  if (in_sequence) seen.reduced = ReducedPicture(picture.pixels);
  search(picture.pixels, name, std::move(before), std::move(seen), found);
  return found;
}

void PictureSearch::search(const ImageView8& image, Seen& seen) {
  for (TagSearch& search : searches_) seen.tags.push_back(search.find(image));
  seen.checkers = checkers_.find(image);
}

bool PictureSearch::follow(const ImageView8& image, const Seen& before, Seen& seen) {
  const PictureShift shift(before.reduced, seen.reduced);
  for (std::size_t i = 0; i < searches_.size(); ++i) {
    auto tags = searches_[i].follow(image, before.tags[i], shift);
    if (!tags) return false;
    seen.tags.push_back(std::move(*tags));
  }
  auto checkers = checkers_.follow(image, before.checkers, shift);
  if (checkers) seen.checkers = std::move(*checkers);
  return checkers.has_value();
}

void PictureSearch::search(const ImageView8& image, const std::string& name,
                           std::optional<Seen> before, Seen seen, DetectedPicture& found) {
  if (!searches_.empty() && std::max(image.width(), image.height()) > kMaxPictureSidePx)
    found.warnings.push_back(
        fmt::format("{}: wider or higher than {} pixels, is not searched "
                    "for tags at its full size",
                    name, kMaxPictureSidePx));
  has_followed_ = before && follow(image, *before, seen);
  if (!has_followed_) {
    seen.tags.clear();
    search(image, seen);
  }
  last_ = std::move(seen);
  add_tags(image, name, found);
  add_checkers(name, found);
  add_circles(image, name, found);
  std::sort(found.view.observations.begin(), found.view.observations.end(),
            [](const Observation& a, const Observation& b) { return a.id < b.id; });
  if (found.view.observations.empty() && !searches_.empty())
    found.warnings.push_back(name + ": no tag of the boards found");
}

void PictureSearch::add_tags(const ImageView8& image, const std::string& name,
                             DetectedPicture& found) const {
  TagCount count;
  for (std::size_t i = 0; i < searches_.size(); ++i) {
    const SeenTags& seen = last_->tags[i];
    warn_of(seen, searches_[i].wanted().family, name, found.warnings);
    found.has_strange_tags |= !seen.strange.empty();
    for (const Completion& completion : seen.completions) {
      for (const FoundTag& tag : completion.tags) add_corners(tag, found.view);
      count.add(image, completion, searches_[i].family());
      for (const MissingTag& tag : completion.missing)
        if (tag.why == WhyNot::no_fit && tag.expected)
          found.unfitted.push_back({tag.id, *tag.expected});
    }
  }
  found.num_sure = count.sure;
  found.num_unread = count.unread;
}

void PictureSearch::add_checkers(const std::string& name, DetectedPicture& found) const {
  std::vector<Observation>& corners = found.view.observations;
  const std::vector<SeenChecker>& seen = last_->checkers;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    corners.insert(corners.end(), seen[i].corners.begin(), seen[i].corners.end());
    if (seen[i].answer == CheckerAnswer::found) continue;
    found.warnings.push_back(name + ": " + why_not_text(seen[i], *checkers_.boards()[i]));
  }
}

void PictureSearch::add_circles(const ImageView8& image, const std::string& name,
                                DetectedPicture& found) const {
  std::vector<Observation>& corners = found.view.observations;
  for (const SeenCircles& seen : circles_.find(image)) {
    corners.insert(corners.end(), seen.centres.begin(), seen.centres.end());
    if (!seen.why_not.empty()) found.warnings.push_back(name + ": " + seen.why_not);
  }
}

}  // namespace tagcal::internal
