#include "tagcal/detect/detect_tags.hpp"

#include <algorithm>
#include <string>
#include <tuple>

#include "tagcal/detect/apriltag/family_detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"

namespace tagcal {
using namespace internal;
namespace {

Wanted any_of(const TagKind& kind) {
  Wanted wanted;
  wanted.family = kind.family;
  wanted.border_bits = kind.border_bits;
  wanted.any = tag_family(kind.family, kind.border_bits);
  // Tags with two bits of border mostly come from Kalibr's boards, whose squares touch them.
  wanted.corner_squares = kind.border_bits == 2;
  return wanted;
}

// The state of one thread.
class TagReader {
 public:
  TagReader(const TagKind& kind, const DetectOptions& options)
      : camera_(options.camera),
        refinement_(options.refinement),
        detector_(any_of(kind), options) {}

  std::vector<DetectedTag> read(const ImageView8& image, const std::string& name) {
    check_size(camera_, image.size(), name);
    if (std::min(image.width(), image.height()) < kMinPictureSidePx) return {};
    std::vector<FoundTag> found = find(image);
    if (refinement_ == Refinement::fit) fit(image, found);
    std::ranges::sort(found, {}, [](const FoundTag& tag) {
      const Eigen::Vector2d centre = centre_of(tag.corners);
      return std::tuple(tag.id, centre.x(), centre.y());
    });
    std::vector<DetectedTag> tags;
    for (const FoundTag& tag : found) {
      tags.push_back({tag.id, tag.corners, {}});
      if (tag.fitted) tags.back().covariance_px2 = tag.covariance_px2;
    }
    return tags;
  }

 private:
  // Coarse pictures first: they show large tags in noise, and their search is quick.
  std::vector<FoundTag> find(const ImageView8& image) {
    const PixelBox all{0, 0, image.size()};
    std::vector<FoundTag> found;
    const auto search = [&](int halvings) {
      for (std::size_t pass = 0; pass < detector_.num_passes(); ++pass)
        detector_.find(image, {all, halvings, pass}, found);
    };
    const bool is_refined = refinement_ != Refinement::stock;
    for (int halvings = is_refined ? num_halvings(image.size()) : 0; halvings >= 0; --halvings)
      search(halvings);
    if (is_refined && found.empty() && is_worth_doubling(image.size())) search(-1);
    return found;
  }

  // Fits strongly bent tags too, then all tags again with the picture's gamma. Tags without a fit
  // are dropped: their corners are unreliable, or they are none.
  void fit(const ImageView8& image, std::vector<FoundTag>& found) {
    const auto fit_bent = [&] {
      for (FoundTag& tag : found)
        if (!tag.fitted) tag = detector_.refined(image, tag.id, tag.corners, false).value_or(tag);
    };
    fit_bent();
    std::vector<FoundTag*> tags;
    for (FoundTag& tag : found) tags.push_back(&tag);
    if (detector_.find_gamma(image, tags)) fit_bent();
    detector_.forget_gamma();
    std::erase_if(found, [](const FoundTag& tag) { return !tag.fitted; });
  }

  const Camera* camera_;
  Refinement refinement_;
  FamilyDetector detector_;
};

PictureTags tags_of(TagReader& reader, const ImageSource& source, bool skip_unreadable) {
  Image8 image;
  try {
    image = source.load();
  } catch (const Error& error) {
    if (!skip_unreadable) throw;
    return {{}, error.what()};
  }
  return {reader.read(image, source.name), ""};
}

}  // namespace

std::vector<DetectedTag> detect_tags(const ImageView8& image, const TagKind& kind,
                                     const DetectOptions& options) {
  return TagReader(kind, options).read(image, "picture");
}

std::vector<PictureTags> detect_all_tags(const std::vector<ImageSource>& images,
                                         const TagKind& kind, const DetectOptions& options,
                                         const std::function<void(int, int)>& progress) {
  std::vector<TagReader> readers;
  const int num_readers =
      std::clamp(static_cast<int>(images.size()), 1, threads_of(options.threads));
  for (int i = 0; i < num_readers; ++i) readers.emplace_back(kind, options);
  std::vector<PictureTags> tags(images.size());
  parallel_for(
      images.size(), readers,
      [&](TagReader& reader, std::size_t i) {
        tags[i] = tags_of(reader, images[i], options.skip_unreadable);
      },
      progress);
  return tags;
}

}  // namespace tagcal
