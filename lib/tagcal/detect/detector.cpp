#include "tagcal/detect/detector.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "tagcal/detect/board_search/board_finder.hpp"
#include "tagcal/detect/board_search/board_symmetry.hpp"
#include "tagcal/detect/board_search/wrong_border.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/circle_search/circle_finder.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The state of one thread.
class Worker {
 public:
  Worker(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
      : camera_(options.camera),
        finders_(board_finders(boards, options)),
        checkers_(boards, options),
        circles_(boards, options) {}

  DetectedPicture detect(const ImageView8& image, const std::string& name) {
    check_size(camera_, image.size(), name);
    DetectedPicture found;
    found.view.image = name;
    if (std::min(image.width(), image.height()) < kMinPictureSidePx) {
      found.warnings.push_back(fmt::format("{}: smaller than {}x{} pixels, was not searched", name,
                                           kMinPictureSidePx, kMinPictureSidePx));
      return found;
    }
    if (!finders_.empty() && std::max(image.width(), image.height()) > kMaxPictureSidePx)
      found.warnings.push_back(
          fmt::format("{}: wider or higher than {} pixels, is not searched "
                      "for tags at its full size",
                      name, kMaxPictureSidePx));
    TagCount count;
    for (const auto& finder : finders_) {
      const SeenBoards seen = finder->find(image);
      warn_of(seen, finder->wanted().family, name, found.warnings);
      for (const Completion& completion : seen.completions) {
        for (const FoundTag& tag : completion.tags) add_corners(tag, found.view);
        count.add(image, completion, finder->family());
        for (const MissingTag& tag : completion.missing)
          if (tag.why == WhyNot::no_fit && tag.expected)
            found.unfitted.push_back({tag.id, *tag.expected});
      }
    }
    found.num_sure = static_cast<int>(count.sure);
    found.num_unread = static_cast<int>(count.unread);
    add_checkers(image, name, found);
    add_circles(image, name, found);
    std::sort(found.view.observations.begin(), found.view.observations.end(),
              [](const Observation& a, const Observation& b) { return a.id < b.id; });
    if (found.view.observations.empty() && !finders_.empty())
      found.warnings.push_back(name + ": no tag of the boards found");
    return found;
  }

 private:
  static void warn_of(const SeenBoards& seen, const std::string& family, const std::string& name,
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
  std::vector<std::unique_ptr<BoardFinder>> finders_;
  CheckerFinder checkers_;
  CircleFinder circles_;
};

}  // namespace

std::vector<View> DetectResult::views() const {
  std::vector<View> all;
  for (const DetectedPicture& picture : pictures) all.push_back(picture.view);
  return all;
}

DetectedPicture detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
                       const DetectOptions& options, const std::string& name) {
  return Worker(boards, options).detect(image, name);
}

namespace {

DetectedPicture search(Worker& worker, const ImageSource& source, const DetectOptions& options) {
  Image8 image;
  try {
    image = source.load();
  } catch (const Error& error) {
    if (!options.skip_unreadable) throw;
    DetectedPicture none;
    none.view.image = source.name;
    none.unreadable = error.what();
    return none;
  }
  return worker.detect(image, source.name);
}

DetectedPicture find_or_search(Worker& worker, std::size_t i, const ImageSource& source,
                               const DetectOptions& options) {
  if (!options.earlier) return search(worker, source, options);
  if (auto found = options.earlier->find(i)) return std::move(*found);
  DetectedPicture found = search(worker, source, options);
  if (found.unreadable.empty()) options.earlier->keep(i, found);
  return found;
}

}  // namespace

DetectResult detect_all(const std::vector<ImageSource>& images,
                        const std::vector<PlacedBoard>& boards, const DetectOptions& options,
                        const std::function<void(int, int)>& progress) {
  // Workers are created before any thread starts: an unknown family throws here, and AprilTag's
  // families must be created by one thread.
  std::vector<Worker> workers;
  const int num_workers =
      std::clamp(static_cast<int>(images.size()), 1, threads_of(options.threads));
  for (int i = 0; i < num_workers; ++i) workers.emplace_back(boards, options);
  DetectResult result;
  std::vector<DetectedPicture>& pictures = result.pictures;
  pictures.resize(images.size());
  parallel_for(
      images.size(), workers,
      [&](Worker& worker, std::size_t i) {
        pictures[i] = find_or_search(worker, i, images[i], options);
      },
      progress);
  std::vector<TagCount> counts;
  for (const DetectedPicture& p : pictures)
    counts.push_back(
        {static_cast<std::size_t>(p.num_sure), static_cast<std::size_t>(p.num_unread)});
  result.warnings = symmetry_warnings(boards);
  for (std::string& warning : wrong_border_warnings(images, counts, boards, options))
    result.warnings.push_back(std::move(warning));
  return result;
}

}  // namespace tagcal
