#include "tagcal/detect/detector.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>

#include "tagcal/detect/board_search/corner_error.hpp"
#include "tagcal/detect/board_search/tag_count.hpp"
#include "tagcal/detect/board_search/tag_search.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/circle_search/circle_finder.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The searches for boards of one thread.
class BoardWorker {
 public:
  BoardWorker(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
      : camera_(options.camera),
        searches_(tag_searches(boards, options)),
        checkers_(boards, options),
        circles_(boards, options) {}

  DetectedPicture find(const ImageView8& image, const std::string& name) {
    check_size(camera_, image.size(), name);
    DetectedPicture found;
    found.view.image = name;
    found.size = image.size();
    if (std::min(image.width(), image.height()) < kMinPictureSidePx) {
      found.warnings.push_back(fmt::format("{}: smaller than {}x{} pixels, was not searched", name,
                                           kMinPictureSidePx, kMinPictureSidePx));
      return found;
    }
    const PictureWithoutMosaic picture(image);
    if (picture.gain > 1)
      found.warnings.push_back(fmt::format(
          "{}: is a raw mosaic (levels of even and odd pixels differ by a factor of {:.1f}): their "
          "levels were made equal",
          name, picture.gain));
    search(picture.pixels, name, found);
    return found;
  }

 private:
  void search(const ImageView8& image, const std::string& name, DetectedPicture& found) {
    if (!searches_.empty() && std::max(image.width(), image.height()) > kMaxPictureSidePx)
      found.warnings.push_back(
          fmt::format("{}: wider or higher than {} pixels, is not searched "
                      "for tags at its full size",
                      name, kMaxPictureSidePx));
    TagCount count;
    for (TagSearch& search : searches_) {
      const SeenTags seen = search.find(image);
      warn_of(seen, search.wanted().family, name, found.warnings);
      for (const Completion& completion : seen.completions) {
        for (const FoundTag& tag : completion.tags) add_corners(tag, found.view);
        count.add(image, completion, search.family());
        for (const MissingTag& tag : completion.missing)
          if (tag.why == WhyNot::no_fit && tag.expected)
            found.unfitted.push_back({tag.id, *tag.expected});
      }
    }
    found.num_sure = count.sure;
    found.num_unread = count.unread;
    add_checkers(image, name, found);
    add_circles(image, name, found);
    std::sort(found.view.observations.begin(), found.view.observations.end(),
              [](const Observation& a, const Observation& b) { return a.id < b.id; });
    if (found.view.observations.empty() && !searches_.empty())
      found.warnings.push_back(name + ": no tag of the boards found");
  }

  static void warn_of(const SeenTags& seen, const std::string& family, const std::string& name,
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

  void add_checkers(const ImageView8& image, const std::string& name, DetectedPicture& found) {
    std::vector<Observation>& corners = found.view.observations;
    const std::vector<SeenChecker> seen = checkers_.find(image);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      corners.insert(corners.end(), seen[i].corners.begin(), seen[i].corners.end());
      if (seen[i].answer == CheckerAnswer::found) continue;
      found.warnings.push_back(name + ": " + why_not_text(seen[i], *checkers_.boards()[i]));
    }
  }

  void add_circles(const ImageView8& image, const std::string& name, DetectedPicture& found) const {
    std::vector<Observation>& corners = found.view.observations;
    for (const SeenCircles& seen : circles_.find(image)) {
      corners.insert(corners.end(), seen.centres.begin(), seen.centres.end());
      if (!seen.why_not.empty()) found.warnings.push_back(name + ": " + seen.why_not);
    }
  }

  static void add_corners(const FoundTag& tag, View& view) {
    for (int i = 0; i < 4; ++i) {
      Observation seen{{tag.id, i}, tag.corners[static_cast<std::size_t>(i)], {}};
      if (tag.fitted) seen.covariance_px2 = tag.covariance_px2.block<2, 2>(2 * i, 2 * i);
      view.observations.push_back(seen);
    }
  }

  const Camera* camera_;
  std::vector<TagSearch> searches_;
  CheckerFinder checkers_;
  CircleFinder circles_;
};

// The search for all tags of a family of one thread.
class TagWorker {
 public:
  TagWorker(const TagKind& kind, const DetectOptions& options)
      : camera_(options.camera), search_(kind, options) {}

  PictureTags find(const ImageView8& image, const std::string& name) {
    check_size(camera_, image.size(), name);
    std::vector<FoundTag> found = search_.find(PictureWithoutMosaic(image).pixels).tags;
    std::ranges::sort(found, {}, [](const FoundTag& tag) {
      const Eigen::Vector2d centre = centre_of(tag.corners);
      return std::tuple(tag.id, centre.x(), centre.y());
    });
    PictureTags result;
    for (const FoundTag& tag : found) {
      result.tags.push_back({tag.id, tag.corners, {}});
      if (tag.fitted) result.tags.back().covariance_px2 = tag.covariance_px2;
    }
    return result;
  }

 private:
  const Camera* camera_;
  TagSearch search_;
};

// The answer of a worker, or the reason why the picture cannot be loaded.
template <typename Worker>
auto find_in(Worker& worker, const ImageSource& source, const DetectOptions& options) {
  Image8 image;
  try {
    image = source.load();
  } catch (const Error& error) {
    if (!options.skip_unreadable) throw;
    decltype(worker.find(image, source.name)) none;
    none.unreadable = error.what();
    return none;
  }
  return worker.find(image, source.name);
}

// Calls work(worker, i) for each of n pictures. Workers are created before any thread starts: an
// unknown family throws here, and AprilTag's families must be created by one thread.
template <typename Worker, typename Target, typename Work>
void for_each_picture(std::size_t n, const Target& target, const DetectOptions& options,
                      const Work& work, const std::function<void(int, int)>& progress) {
  std::vector<Worker> workers;
  const int num_workers = std::clamp(static_cast<int>(n), 1, threads_of(options.threads));
  for (int i = 0; i < num_workers; ++i) workers.emplace_back(target, options);
  parallel_for(n, workers, work, progress);
}

DetectedPicture find_or_reuse(BoardWorker& worker, std::size_t i, const ImageSource& source,
                              const DetectOptions& options) {
  if (options.earlier)
    if (auto found = options.earlier->find(i)) return std::move(*found);
  DetectedPicture found = find_in(worker, source, options);
  found.view.image = source.name;
  if (options.earlier && found.unreadable.empty()) options.earlier->keep(i, found);
  return found;
}

}  // namespace

DetectedPicture detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
                       const DetectOptions& options, const std::string& name) {
  DetectedPicture found = BoardWorker(boards, options).find(image, name);
  found.corner_error_px = add_corner_error({{&found.view, found.size}}, boards);
  return found;
}

std::vector<DetectedPicture> detect_all(const std::vector<ImageSource>& images,
                                        const std::vector<PlacedBoard>& boards,
                                        const DetectOptions& options,
                                        const std::function<void(int, int)>& progress) {
  std::vector<DetectedPicture> pictures(images.size());
  const auto work = [&](BoardWorker& worker, std::size_t i) {
    pictures[i] = find_or_reuse(worker, i, images[i], options);
  };
  for_each_picture<BoardWorker>(images.size(), boards, options, work, progress);
  std::vector<ViewOfSize> views;
  for (DetectedPicture& picture : pictures) views.push_back({&picture.view, picture.size});
  const double error = add_corner_error(views, boards);
  for (DetectedPicture& picture : pictures) picture.corner_error_px = error;
  return pictures;
}

std::vector<View> views_of(const std::vector<DetectedPicture>& pictures) {
  std::vector<View> views;
  for (const DetectedPicture& picture : pictures) views.push_back(picture.view);
  return views;
}

std::vector<DetectedTag> detect_tags(const ImageView8& image, const TagKind& kind,
                                     const DetectOptions& options) {
  return TagWorker(kind, options).find(image, "picture").tags;
}

std::vector<PictureTags> detect_all_tags(const std::vector<ImageSource>& images,
                                         const TagKind& kind, const DetectOptions& options,
                                         const std::function<void(int, int)>& progress) {
  std::vector<PictureTags> tags(images.size());
  const auto work = [&](TagWorker& worker, std::size_t i) {
    tags[i] = find_in(worker, images[i], options);
  };
  for_each_picture<TagWorker>(images.size(), kind, options, work, progress);
  return tags;
}

}  // namespace tagcal
