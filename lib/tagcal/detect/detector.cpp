#include "tagcal/detect/detector.hpp"

#include <algorithm>
#include <mutex>
#include <tuple>
#include <utility>

#include "tagcal/detect/board_search/corner_error.hpp"
#include "tagcal/detect/picture_search/loads_in_order.hpp"
#include "tagcal/detect/picture_search/picture_search.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

// The search for all tags of a family of one thread.
class TagWorker {
 public:
  TagWorker(const TagKind& kind, const DetectOptions& options)
      : camera_(options.camera), search_(kind, options) {}

  PictureTags find(const ImageView8& image, const std::string& name) {
    check_size(camera_, image.size(), name);
    std::vector<FoundTag> found = search_.find(PictureToSearch(image).pixels).tags;
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

// One thread finds so many frames of a sequence, one after the other. It searches the first of
// them, so a new tag is found after so many frames at most, and several threads can share a
// sequence. numeric: a whole search each 20 frames costs 1 / 20 of the time that following saves.
constexpr std::size_t kFollowedFrames = 20;

// Pictures [first, end). Several are loaded at once, in the order of their turns.
struct PictureRange {
  std::size_t first, end;
  std::size_t turn = 0;

  bool is_one() const { return end == first + 1; }
};

std::vector<PictureRange> followed_ranges(const std::vector<ImageSource>& images) {
  std::vector<PictureRange> ranges;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].follows && i > 0 && i - ranges.back().first < kFollowedFrames)
      ranges.back().end = i + 1;
    else
      ranges.push_back({i, i + 1});
  }
  std::size_t turn = 0;
  for (PictureRange& range : ranges)
    if (!range.is_one()) range.turn = turn++;
  return ranges;
}

// Finds the boards in the pictures, range after range.
class BatchSearch {
 public:
  BatchSearch(const std::vector<ImageSource>& images, const DetectOptions& options,
              const std::function<void(int, int)>& progress)
      : images_(images), options_(options), progress_(progress), pictures_(images.size()) {}

  // For each range, in their order.
  void find(PictureSearch& search, const PictureRange& range) {
    std::optional<LoadsInOrder::Turn> turn;
    if (!range.is_one()) turn.emplace(loads_, range.turn);
    if (reuse(range)) return;
    const auto load = [&] {
      std::vector<LoadedPicture> loaded;
      for (std::size_t i = range.first; i < range.end; ++i)
        loaded.push_back(load_picture(images_[i], options_.skip_unreadable));
      return loaded;
    };
    find(search, range, turn ? turn->load(load) : load());
  }

  std::vector<DetectedPicture> take() { return std::move(pictures_); }

 private:
  void find(PictureSearch& search, const PictureRange& range,
            const std::vector<LoadedPicture>& loaded) {
    bool has_before = false;
    for (std::size_t k = 0; k < loaded.size(); ++k) {
      const std::size_t i = range.first + k;
      const std::string& name = images_[i].name;
      const LoadedPicture& picture = loaded[k];
      pictures_[i] = DetectedPicture();
      pictures_[i].unreadable = picture.unreadable;
      if (picture.unreadable.empty())
        pictures_[i] = has_before       ? search.find_next(picture.image, name)
                       : range.is_one() ? search.find(picture.image, name)
                                        : search.find_first(picture.image, name);
      has_before = picture.unreadable.empty();
      pictures_[i].view.image = name;
      if (options_.earlier && has_before) options_.earlier->keep(i, pictures_[i]);
      count_one();
    }
  }

  // Takes all pictures of a range from an earlier run: one that is found anew is the start of the
  // next.
  bool reuse(const PictureRange& range) {
    if (!options_.earlier) return false;
    bool is_known = true;
    for (std::size_t i = range.first; i < range.end; ++i) {
      auto found = options_.earlier->find(i, range.first);
      is_known = is_known && found;
      if (!found) continue;
      pictures_[i] = std::move(*found);
      pictures_[i].view.image = images_[i].name;
    }
    for (std::size_t i = range.first; i < range.end && is_known; ++i) count_one();
    return is_known;
  }

  void count_one() {
    const std::lock_guard lock(mutex_);
    ++num_done_;
    if (progress_) progress_(num_done_, static_cast<int>(images_.size()));
  }

  const std::vector<ImageSource>& images_;
  const DetectOptions& options_;
  const std::function<void(int, int)>& progress_;
  std::vector<DetectedPicture> pictures_;
  LoadsInOrder loads_;
  std::mutex mutex_;
  int num_done_ = 0;
};

}  // namespace

DetectedPicture detect(const ImageView8& image, const std::vector<PlacedBoard>& boards,
                       const DetectOptions& options, const std::string& name) {
  DetectedPicture found = PictureSearch(boards, options).find(image, name);
  found.corner_error_px = add_corner_error({{&found.view, found.size}}, boards);
  return found;
}

std::vector<DetectedPicture> detect_all(const std::vector<ImageSource>& images,
                                        const std::vector<PlacedBoard>& boards,
                                        const DetectOptions& options,
                                        const std::function<void(int, int)>& progress) {
  BatchSearch batch(images, options, progress);
  const std::vector<PictureRange> ranges = followed_ranges(images);
  const auto work = [&](PictureSearch& search, std::size_t i) { batch.find(search, ranges[i]); };
  for_each_picture<PictureSearch>(ranges.size(), boards, options, work, {});
  std::vector<DetectedPicture> pictures = batch.take();
  std::vector<ViewOfSize> views;
  for (DetectedPicture& picture : pictures) views.push_back({&picture.view, picture.size});
  const double error = add_corner_error(views, boards);
  for (DetectedPicture& picture : pictures) picture.corner_error_px = error;
  return pictures;
}

struct BoardTracker::State {
  std::vector<PlacedBoard> boards;
  PictureSearch search;
  double corner_error_px = 0;  // of the last picture that was searched

  State(std::vector<PlacedBoard> some, const DetectOptions& options)
      : boards(std::move(some)), search(boards, options) {}
};

BoardTracker::BoardTracker(std::vector<PlacedBoard> boards, const DetectOptions& options)
    : state_(std::make_unique<State>(std::move(boards), options)) {}
BoardTracker::~BoardTracker() = default;
BoardTracker::BoardTracker(BoardTracker&&) noexcept = default;
BoardTracker& BoardTracker::operator=(BoardTracker&&) noexcept = default;

DetectedPicture BoardTracker::next(const ImageView8& image, const std::string& name) {
  DetectedPicture found = state_->search.find_next(image, name);
  if (has_followed())
    widen_covariances(found.view, state_->corner_error_px);
  else
    state_->corner_error_px = add_corner_error({{&found.view, found.size}}, state_->boards);
  found.corner_error_px = state_->corner_error_px;
  return found;
}

bool BoardTracker::has_followed() const { return state_->search.has_followed(); }

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
    const LoadedPicture picture = load_picture(images[i], options.skip_unreadable);
    if (picture.unreadable.empty()) tags[i] = worker.find(picture.image, images[i].name);
    tags[i].unreadable = picture.unreadable;
  };
  for_each_picture<TagWorker>(images.size(), kind, options, work, progress);
  return tags;
}

}  // namespace tagcal
