#include "tagcal/detect/detector.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "tagcal/detect/apriltag_handles.hpp"
#include "tagcal/detect/refine_edges.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

constexpr int kMinImageSide = 8;       // AprilTag 3.3 crashes on some of the smallest pictures
constexpr double kBorderMargin = 1.5;  // px: a tag nearer to the edge of the picture may be cut

// The tags looked for with one family and border.
struct Wanted {
  std::string family;
  int border_bits = 1;
  std::set<int> ids;
};

std::vector<Wanted> wanted_tags(const std::vector<PlacedBoard>& boards) {
  std::map<std::pair<std::string, int>, std::set<int>> by_family;
  for (const PlacedBoard& placed : boards) {
    const Board& board = placed.board;
    if (board.tags.empty()) continue;
    std::set<int>& ids = by_family[{board.family, board.border_bits}];
    for (const Tag& tag : board.tags) ids.insert(tag.id);
  }
  std::vector<Wanted> wanted;
  for (auto& [key, ids] : by_family) wanted.push_back({key.first, key.second, std::move(ids)});
  return wanted;
}

struct FoundTag {
  int id = 0;
  Quad corners;
};

bool is_inside(const Quad& quad, const ImageSize& size) {
  return std::all_of(quad.begin(), quad.end(), [&](const Eigen::Vector2d& corner) {
    return corner.minCoeff() >= -0.5 + kBorderMargin &&
           corner.x() <= size.width - 0.5 - kBorderMargin &&
           corner.y() <= size.height - 0.5 - kBorderMargin;
  });
}

// Convex, and not mirrored: seen, the corners run counter-clockwise (the image's y points down).
bool is_face(const Quad& quad) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = quad[(i + 1) % 4] - quad[i];
    const Eigen::Vector2d b = quad[(i + 2) % 4] - quad[(i + 1) % 4];
    if (!(a.x() * b.y() - a.y() * b.x() < 0)) return false;
  }
  return true;
}

// AprilTag's detector for one family and border, for one thread.
class FamilyDetector {
 public:
  FamilyDetector(const Wanted& wanted, int max_hamming)
      : wanted_(wanted),
        family_(create_family(wanted.family, wanted.border_bits)),
        detector_(apriltag_detector_create()) {
    max_hamming_ = std::clamp(max_hamming, 0, 2);
    apriltag_detector_add_family_bits(detector_.get(), family_.get(), max_hamming_);
    detector_->nthreads = 1;
    detector_->quad_decimate = 1;
    detector_->refine_edges = true;
  }

  const Wanted& wanted() const { return wanted_; }

  std::vector<FoundTag> find(const Image8& image) {
    // AprilTag does not write into the picture that it is given.
    image_u8_t view = {image.width(), image.height(), image.width(),
                       const_cast<std::uint8_t*>(image.row(0))};
    const DetectionsHandle detections(apriltag_detector_detect(detector_.get(), &view));
    std::vector<FoundTag> found;
    for (int i = 0; i < zarray_size(detections.get()); ++i) {
      apriltag_detection_t* detection = nullptr;
      zarray_get(detections.get(), i, &detection);
      if (detection->hamming > max_hamming_) continue;
      if (const auto tag = refined(*detection, image)) found.push_back(*tag);
    }
    return found;
  }

 private:
  std::optional<FoundTag> refined(const apriltag_detection_t& detection,
                                  const Image8& image) const {
    Quad start;
    for (std::size_t i = 0; i < 4; ++i) {
      // AprilTag's pixel centres are at 0.5.
      start[i] = {detection.p[i][0] - 0.5, detection.p[i][1] - 0.5};
    }
    if (!is_face(start) || !is_inside(start, image.size())) return std::nullopt;
    const QuadShape shape{family_->width_at_border, !family_->reversed_border};
    const Quad corners = refine_edges(image, start, shape).value_or(start);
    if (!is_face(corners) || !is_inside(corners, image.size())) return std::nullopt;
    return FoundTag{detection.id, corners};
  }

  Wanted wanted_;
  FamilyHandle family_;
  DetectorHandle detector_;
  int max_hamming_ = 0;
};

// All that one thread needs.
class Worker {
 public:
  Worker(const std::vector<PlacedBoard>& boards, const DetectOptions& options) {
    for (const Wanted& wanted : wanted_tags(boards)) {
      detectors_.push_back(std::make_unique<FamilyDetector>(wanted, options.max_hamming));
    }
  }

  View detect(const Image8& image, const std::string& name, std::vector<std::string>& warnings) {
    View view{name, {}};
    if (image.width() < kMinImageSide || image.height() < kMinImageSide) {
      warnings.push_back(
          fmt::format("{}: smaller than {}x{}, holds no tag", name, kMinImageSide, kMinImageSide));
      return view;
    }
    for (const auto& detector : detectors_) add_tags(*detector, image, view, warnings);
    std::sort(view.observations.begin(), view.observations.end(),
              [](const Observation& a, const Observation& b) { return a.id < b.id; });
    if (view.observations.empty()) warnings.push_back(name + ": no tag of the boards found");
    return view;
  }

 private:
  static void add_tags(FamilyDetector& detector, const Image8& image, View& view,
                       std::vector<std::string>& warnings) {
    std::map<int, std::vector<Quad>> by_id;
    for (const FoundTag& tag : detector.find(image)) by_id[tag.id].push_back(tag.corners);
    std::vector<int> strange;
    std::vector<int> repeated;
    for (const auto& [id, quads] : by_id) {
      if (!detector.wanted().ids.contains(id)) {
        strange.push_back(id);
      } else if (quads.size() > 1) {
        repeated.push_back(id);
      } else {
        for (int i = 0; i < 4; ++i) {
          view.observations.push_back({{id, i}, quads[0][static_cast<std::size_t>(i)], {}});
        }
      }
    }
    const std::string& family = detector.wanted().family;
    if (!strange.empty()) {
      warnings.push_back(fmt::format("{}: left out {} tags that are on no board: {}", view.image,
                                     family, fmt::join(strange, ", ")));
    }
    if (!repeated.empty()) {
      warnings.push_back(fmt::format("{}: left out {} tags seen more than once: {}", view.image,
                                     family, fmt::join(repeated, ", ")));
    }
  }

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
