#include "tagcal/detect/detector.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include "tagcal/detect/complete_board.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/family_detector.hpp"

namespace tagcal {
namespace {

constexpr int kMinImageSide = 8;  // AprilTag 3.3 crashes on some of the smallest pictures

std::vector<Wanted> wanted_tags(const std::vector<PlacedBoard>& boards) {
  std::map<std::pair<std::string, int>, Wanted> by_family;
  for (const PlacedBoard& placed : boards) {
    const Board& board = placed.board;
    if (board.tags.empty()) continue;
    Wanted& wanted = by_family[{board.family, board.border_bits}];
    wanted.family = board.family;
    wanted.border_bits = board.border_bits;
    wanted.corner_squares |= board.corner_squares;
    // Without squares, what is beside the outer tags is not known.
    TagSurroundings around;
    around.corner_squares = board.corner_squares;
    if (board.grid && board.corner_squares) around.gap = board.grid->tag_spacing;
    for (const Tag& tag : board.tags) {
      wanted.ids.insert(tag.id);
      wanted.surroundings[tag.id] = around;
    }
  }
  std::vector<Wanted> all;
  for (auto& [key, wanted] : by_family) all.push_back(std::move(wanted));
  return all;
}

// All that one thread needs.
class Worker {
 public:
  Worker(const std::vector<PlacedBoard>& boards, const DetectOptions& options)
      : boards_(boards), max_hamming_(options.max_hamming) {
    for (const Wanted& wanted : wanted_tags(boards)) {
      detectors_.push_back(std::make_unique<FamilyDetector>(wanted, options));
      families_.push_back(tag_family(wanted.family, wanted.border_bits));
    }
  }

  View detect(const Image8& image, const std::string& name, std::vector<std::string>& warnings) {
    View view{name, {}};
    if (image.width() < kMinImageSide || image.height() < kMinImageSide) {
      warnings.push_back(
          fmt::format("{}: smaller than {}x{}, holds no tag", name, kMinImageSide, kMinImageSide));
      return view;
    }
    for (std::size_t i = 0; i < detectors_.size(); ++i) {
      const SeenTags seen = sorted(*detectors_[i], image);
      warn_of(seen, detectors_[i]->wanted().family, name, warnings);
      complete(i, image, seen, view);
    }
    std::sort(view.observations.begin(), view.observations.end(),
              [](const Observation& a, const Observation& b) { return a.id < b.id; });
    if (view.observations.empty()) warnings.push_back(name + ": no tag of the boards found");
    return view;
  }

 private:
  struct SeenTags {
    std::vector<FoundTag> found;
    std::set<int> strange;   // on no board
    std::set<int> repeated;  // seen more than once
  };

  static SeenTags sorted(FamilyDetector& detector, const Image8& image) {
    std::map<int, std::vector<FoundTag>> by_id;
    for (const FoundTag& tag : detector.find(image)) by_id[tag.id].push_back(tag);
    SeenTags seen;
    for (const auto& [id, tags] : by_id) {
      if (!detector.wanted().ids.contains(id)) {
        seen.strange.insert(id);
      } else if (tags.size() > 1) {
        seen.repeated.insert(id);
      } else {
        seen.found.push_back(tags[0]);
      }
    }
    return seen;
  }

  static void warn_of(const SeenTags& seen, const std::string& family, const std::string& name,
                      std::vector<std::string>& warnings) {
    if (!seen.strange.empty()) {
      warnings.push_back(fmt::format("{}: left out {} tags that are on no board: {}", name, family,
                                     fmt::join(seen.strange, ", ")));
    }
    if (!seen.repeated.empty()) {
      warnings.push_back(fmt::format("{}: left out {} tags seen more than once: {}", name, family,
                                     fmt::join(seen.repeated, ", ")));
    }
  }

  static void add_corners(const FoundTag& tag, View& view) {
    for (int i = 0; i < 4; ++i) {
      Observation seen{{tag.id, i}, tag.corners[static_cast<std::size_t>(i)], {}};
      if (tag.covariance_px2) seen.covariance_px2 = tag.covariance_px2->block<2, 2>(2 * i, 2 * i);
      view.observations.push_back(seen);
    }
  }

  // Adds the tags of the i-th detector's boards, with those that it missed.
  void complete(std::size_t i, const Image8& image, const SeenTags& seen, View& view) {
    FamilyDetector& detector = *detectors_[i];
    const CompletionRules rules{max_hamming_, seen.repeated, [&](int id, const Quad& start) {
                                  return detector.refined(image, id, start);
                                }};
    for (const PlacedBoard& placed : boards_) {
      const Board& board = placed.board;
      if (board.family != detector.wanted().family) continue;
      if (board.border_bits != detector.wanted().border_bits) continue;
      const Completion completion = complete_board(image, board, families_[i], seen.found, rules);
      for (const FoundTag& tag : completion.tags) add_corners(tag, view);
    }
  }

  const std::vector<PlacedBoard>& boards_;
  int max_hamming_;
  std::vector<TagFamily> families_;  // of the detectors
  std::vector<std::unique_ptr<FamilyDetector>> detectors_;
};

// The pictures of detect_all, shared by its workers. Results stand by index, so that they do not
// depend on who did what.
class Batch {
 public:
  Batch(const std::vector<ImageSource>& images, const std::function<void(int, int)>& progress)
      : images_(images),
        progress_(progress),
        views_(images.size()),
        warnings_(images.size()),
        errors_(images.size()) {}

  void work(Worker& worker) {
    for (std::size_t i = next_++; i < images_.size() && !failed_; i = next_++) {
      try {
        views_[i] = worker.detect(images_[i].load(), images_[i].name, warnings_[i]);
        const std::scoped_lock lock(mutex_);
        if (progress_) progress_(++done_, static_cast<int>(images_.size()));
      } catch (...) {
        errors_[i] = std::current_exception();
        failed_ = true;
      }
    }
  }

  // Throws the error of the first picture that failed; every one before it has been tried.
  DetectResult result() {
    for (const std::exception_ptr& error : errors_) {
      if (error) std::rethrow_exception(error);
    }
    DetectResult result{std::move(views_), {}};
    for (const auto& lines : warnings_) {
      result.warnings.insert(result.warnings.end(), lines.begin(), lines.end());
    }
    return result;
  }

 private:
  const std::vector<ImageSource>& images_;
  const std::function<void(int, int)>& progress_;
  std::vector<View> views_;
  std::vector<std::vector<std::string>> warnings_;
  std::vector<std::exception_ptr> errors_;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> failed_ = false;
  std::mutex mutex_;
  int done_ = 0;
};

std::size_t num_threads(const DetectOptions& options, std::size_t images) {
  const std::size_t asked = options.threads > 0
                                ? static_cast<std::size_t>(options.threads)
                                : std::max<std::size_t>(1, std::thread::hardware_concurrency());
  return std::min(asked, std::max<std::size_t>(1, images));
}

}  // namespace

View detect(const Image8& image, const std::string& name, const std::vector<PlacedBoard>& boards,
            const DetectOptions& options, std::vector<std::string>* warnings) {
  std::vector<std::string> lines;
  View view = Worker(boards, options).detect(image, name, lines);
  if (warnings) warnings->insert(warnings->end(), lines.begin(), lines.end());
  return view;
}

DetectResult detect_all(const std::vector<ImageSource>& images,
                        const std::vector<PlacedBoard>& boards, const DetectOptions& options,
                        const std::function<void(int, int)>& progress) {
  // Made here, before any thread starts: an unknown family is an error of the boards, and
  // AprilTag's families are created by one thread.
  std::vector<std::unique_ptr<Worker>> workers;
  for (std::size_t i = 0; i < num_threads(options, images.size()); ++i) {
    workers.push_back(std::make_unique<Worker>(boards, options));
  }
  Batch batch(images, progress);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; i < workers.size(); ++i) {
      threads.emplace_back([&batch, &worker = *workers[i]] { batch.work(worker); });
    }
    batch.work(*workers[0]);
  }
  return batch.result();
}

}  // namespace tagcal
