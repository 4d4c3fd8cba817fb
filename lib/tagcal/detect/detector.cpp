#include "tagcal/detect/detector.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "tagcal/detect/board_finder.hpp"

namespace tagcal {
namespace {

constexpr int kMinImageSide = 8;  // AprilTag 3.3 crashes on some of the smallest pictures

// All that one thread needs, which may have others do some of its work.
class Worker {
 public:
  Worker(const std::vector<PlacedBoard>& boards, const DetectOptions& options, int threads)
      : finders_(board_finders(boards, options, threads)) {}

  View detect(const Image8& image, const std::string& name, std::vector<std::string>& warnings) {
    View view{name, {}};
    if (image.width() < kMinImageSide || image.height() < kMinImageSide) {
      warnings.push_back(
          fmt::format("{}: smaller than {}x{}, holds no tag", name, kMinImageSide, kMinImageSide));
      return view;
    }
    for (const auto& finder : finders_) {
      const SeenBoards seen = finder->find(image);
      warn_of(seen, finder->wanted().family, name, warnings);
      for (const Completion& completion : seen.completions)
        for (const FoundTag& tag : completion.tags) add_corners(tag, view);
    }
    std::sort(view.observations.begin(), view.observations.end(),
              [](const Observation& a, const Observation& b) { return a.id < b.id; });
    if (view.observations.empty()) warnings.push_back(name + ": no tag of the boards found");
    return view;
  }

 private:
  static void warn_of(const SeenBoards& seen, const std::string& family, const std::string& name,
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

  std::vector<std::unique_ptr<BoardFinder>> finders_;
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

int num_threads(const DetectOptions& options) {
  if (options.threads > 0) return options.threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace

View detect(const Image8& image, const std::string& name, const std::vector<PlacedBoard>& boards,
            const DetectOptions& options, std::vector<std::string>* warnings) {
  std::vector<std::string> lines;
  View view = Worker(boards, options, num_threads(options)).detect(image, name, lines);
  if (warnings) warnings->insert(warnings->end(), lines.begin(), lines.end());
  return view;
}

DetectResult detect_all(const std::vector<ImageSource>& images,
                        const std::vector<PlacedBoard>& boards, const DetectOptions& options,
                        const std::function<void(int, int)>& progress) {
  // Made here, before any thread starts: an unknown family is an error of the boards, and
  // AprilTag's families are created by one thread.
  std::vector<std::unique_ptr<Worker>> workers;
  const int threads = num_threads(options);
  const int num_workers = std::clamp(static_cast<int>(images.size()), 1, threads);
  for (int i = 0; i < num_workers; ++i) {
    workers.push_back(std::make_unique<Worker>(boards, options, threads / num_workers));
  }
  Batch batch(images, progress);
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < workers.size(); ++i) {
      others.emplace_back([&batch, &worker = *workers[i]] { batch.work(worker); });
    }
    batch.work(*workers[0]);
  }
  return batch.result();
}

}  // namespace tagcal
