#include "tagcal/detect/detector.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "tagcal/detect/board_search/board_finder.hpp"
#include "tagcal/detect/board_search/wrong_border.hpp"
#include "tagcal/detect/checker_search/checker_finder.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Messages about a picture, besides its corners.
struct PictureReport {
  std::vector<std::string> warnings;
  std::vector<UnfittedTag> unfitted;
  TagCount count;
};

// The state of one thread.
class Worker {
 public:
  Worker(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
      : camera_(options.camera),
        finders_(board_finders(boards, options)),
        checkers_(boards, options) {}

  View detect(const ImageView8& image, const std::string& name, PictureReport& report) {
    check_size(camera_, image.size(), name);
    View view{name, {}};
    constexpr int kMinSide = policy::kTagMinPictureSidePx;
    if (image.width() < kMinSide || image.height() < kMinSide) {
      report.warnings.push_back(
          fmt::format("{}: smaller than {}x{} pixels, was not searched", name, kMinSide, kMinSide));
      return view;
    }
    if (!finders_.empty() && std::max(image.width(), image.height()) > policy::kTagMaxPictureSidePx)
      report.warnings.push_back(
          fmt::format("{}: wider or higher than {} pixels, is not searched "
                      "for tags at its full size",
                      name, policy::kTagMaxPictureSidePx));
    for (const auto& finder : finders_) {
      const SeenBoards seen = finder->find(image);
      warn_of(seen, finder->wanted().family, name, report.warnings);
      for (const Completion& completion : seen.completions) {
        for (const FoundTag& tag : completion.tags) add_corners(tag, view);
        report.count.add(image, completion, finder->family());
        for (const MissingTag& tag : completion.missing)
          if (tag.why == WhyNot::no_fit && tag.expected)
            report.unfitted.push_back({tag.id, *tag.expected});
      }
    }
    add_checkers(image, name, view, report);
    std::sort(view.observations.begin(), view.observations.end(),
              [](const Observation& a, const Observation& b) { return a.id < b.id; });
    if (view.observations.empty() && !finders_.empty())
      report.warnings.push_back(name + ": no tag of the boards found");
    return view;
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

  void add_checkers(const ImageView8& image, const std::string& name, View& view,
                    PictureReport& report) {
    const std::vector<SeenChecker> seen = checkers_.find(image);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      view.observations.insert(view.observations.end(), seen[i].corners.begin(),
                               seen[i].corners.end());
      if (seen[i].answer == CheckerAnswer::found) continue;
      report.warnings.push_back(name + ": " + why_not_text(seen[i], *checkers_.boards()[i]));
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
};

}  // namespace

View detect(const ImageView8& image, const std::string& name,
            const std::vector<PlacedBoard>& boards, const DetectOptions& options,
            std::vector<std::string>* warnings) {
  return detect(image, boards, options, name, warnings);
}

View detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
            const DetectOptions& options, const std::string& name,
            std::vector<std::string>* warnings) {
  PictureReport report;
  View view = Worker(boards, options).detect(image, name, report);
  if (warnings) warnings->insert(warnings->end(), report.warnings.begin(), report.warnings.end());
  return view;
}

namespace {

DetectedPicture search(Worker& worker, const ImageSource& source, const DetectOptions& options) {
  DetectedPicture found;
  Image8 image;
  try {
    image = source.load();
  } catch (const Error& error) {
    if (!options.skip_unreadable) throw;
    found.view.image = source.name;
    found.unreadable = error.what();
    return found;
  }
  PictureReport report;
  found.view = worker.detect(image, source.name, report);
  found.unfitted = std::move(report.unfitted);
  found.warnings = std::move(report.warnings);
  found.num_sure = static_cast<int>(report.count.sure);
  found.num_unread = static_cast<int>(report.count.unread);
  return found;
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
  std::vector<DetectedPicture> pictures(images.size());
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
  DetectResult result;
  result.warnings = symmetry_warnings(boards);
  for (std::string& warning : wrong_border_warnings(images, counts, boards, options))
    result.warnings.push_back(std::move(warning));
  for (DetectedPicture& p : pictures) {
    result.warnings.insert(result.warnings.end(), p.warnings.begin(), p.warnings.end());
    result.views.push_back(std::move(p.view));
    result.unfitted.push_back(std::move(p.unfitted));
    result.unreadable.push_back(std::move(p.unreadable));
  }
  return result;
}

}  // namespace tagcal
