#include "tagcal/detect/apriltag/family_detector.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tagcal/detect/apriltag/sightings.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/detect/tag_fit/refine_edges.hpp"
#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

// numeric: limit of memory. Tags of a family up to which two wrong bits may be accepted: AprilTag's
// decoding table has an entry of 16 bytes for three times tags * bits * (bits - 1); 2115 tags of 41
// bits take 166 MB, 42211 of 48 bits would take 4.6 GB.
constexpr unsigned kMaxCodesForTwo = 4096;
constexpr int kMaxDoubledPixels = 1'500'000;  // of a picture, as a limit of work

// Corners in a picture from those in the doubled one, whose pixel x lies at x / 2 - 1 / 4.
Quad undoubled(Quad corners) {
  for (Eigen::Vector2d& corner : corners) corner = corner / 2 - Eigen::Vector2d::Constant(1.0 / 4);
  return corners;
}

int most_wrong_bits(const Wanted& wanted) {
  const FamilyHandle family = create_family(wanted.family, wanted.border_bits);
  const int by_distance = (static_cast<int>(family->h) - 1) / 2;  // a code stays the nearest one
  return std::min(by_distance, family->ncodes > kMaxCodesForTwo ? 1 : 2);
}

constexpr int kPinholeSide =
    256;  // numeric: px; tags that AprilTag does not see otherwise are large
constexpr double kPinholeHalfWidth = 2;  // numeric: tangent of half its field of view, 63 degrees

// A picture of a fisheye camera as a pinhole camera along its axis would see it, small and wide.
// The lens must outlive it.
class PinholePicture {
 public:
  PinholePicture(const ImageView8& picture, const Lens& lens);

  const Image8& image() const { return image_; }
  // The place in the picture; no value if it is outside.
  std::optional<Eigen::Vector2d> in_picture(const Eigen::Vector2d& pixel) const;

 private:
  ImageSize size_;
  const Lens& lens_;
  Image8 image_;
};

PinholePicture::PinholePicture(const ImageView8& picture, const Lens& lens)
    : size_(picture.size()), lens_(lens), image_({kPinholeSide, kPinholeSide}) {
  for (int y = 0; y < kPinholeSide; ++y)
    for (int x = 0; x < kPinholeSide; ++x)
      if (const auto at = in_picture(Eigen::Vector2d(x, y)))
        image_(x, y) = picture(static_cast<int>(at->x()), static_cast<int>(at->y()));
}

std::optional<Eigen::Vector2d> PinholePicture::in_picture(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d tangent =
      (pixel / (kPinholeSide / 2) - Eigen::Vector2d::Ones()) * kPinholeHalfWidth;
  const auto at = project(lens_, tangent.homogeneous());
  const bool is_inside =
      at && at->minCoeff() >= 0 && at->x() < size_.width && at->y() < size_.height;
  return is_inside ? at : std::nullopt;
}

}  // namespace

bool is_whole(const FoundTag& tag, const ImageSize& size) {
  return is_inside(
      tag.corners, size,
      tag.fitted || tag.by_corner ? policy::kTagEdgeMarginPx : policy::kTagUnfittedEdgeMarginPx);
}

int num_halvings(const ImageSize& size) {
  const double pixels = static_cast<double>(size.width) * size.height;
  return std::max(
      0, static_cast<int>(std::floor(std::log2(pixels / policy::kBoardMinHalvedPixels) / 2)));
}

bool is_worth_doubling(const ImageSize& size) {
  return static_cast<double>(size.width) * size.height <= kMaxDoubledPixels;
}

void check_size(const Camera* camera, const ImageSize& size, const std::string& name) {
  if (!camera || size == camera->image_size) return;
  const ImageSize& expected = camera->image_size;
  throw Error(fmt::format("{}: must be {}x{} pixels as the camera's, got {}x{}", name,
                          expected.width, expected.height, size.width, size.height));
}

FamilyDetector::FamilyDetector(const Wanted& wanted, const DetectOptions& options)
    : wanted_(wanted),
      max_hamming_(std::clamp(options.max_hamming, 0, most_wrong_bits(wanted))),
      family_(shared_family(wanted.family, wanted.border_bits, max_hamming_)),
      refinement_(options.refinement),
      camera_(options.camera) {
  for (const int shrink : policy::kTagShrinksPx) {
    // Shrinking black moves the corners inwards, so they must be refined afterwards.
    if (shrink > 0 && (!wanted.corner_squares || refinement_ == Refinement::stock)) break;
    passes_.push_back({shrink, DetectorHandle(apriltag_detector_create())});
    apriltag_detector_t& detector = *passes_.back().detector;
    apriltag_detector_add_family_bits(&detector, family_.get(), max_hamming_);
    detector.nthreads = 1;
    detector.quad_decimate = 1;  // 2 misses a third of the tags 20 px wide
    // AprilTag's refine_edges loses small tags and is less accurate than ours. Tags whose corners
    // touch squares need it where ours fails.
    detector.refine_edges = refinement_ == Refinement::stock || wanted.corner_squares;
  }
}

std::vector<FoundTag> FamilyDetector::find(const ImageView8& image) {
  std::vector<FoundTag> found;
  for (std::size_t pass = 0; pass < num_passes(); ++pass)
    find(image, {{0, 0, image.size()}, 0, pass}, found);
  std::erase_if(found, [](const FoundTag& tag) { return tag.is_approximate; });
  return found;
}

void FamilyDetector::find(const ImageView8& image, const Search& search,
                          std::vector<FoundTag>& found) {
  const bool whole = search.box.size == image.size();
  Image8 part;
  if (!whole) part = part_of(image, search.box);
  const ImageView8 from = whole ? image : ImageView8(part);
  const bool is_doubled = search.halvings < 0;
  std::vector<Image8> scaled;
  if (is_doubled) scaled.push_back(doubled(from));
  for (int i = 0; i < search.halvings; ++i)
    scaled.push_back(halved(i > 0 ? ImageView8(scaled.back()) : from));
  const ImageView8 searched = scaled.empty() ? from : ImageView8(scaled.back());
  if (std::min(searched.width(), searched.height()) < kMinPictureSidePx) return;
  const Pass& pass = passes_[search.pass];
  const Eigen::Vector2d offset(search.box.left, search.box.top);
  for (const Sighting& seen : sightings(*pass.detector, searched, pass.shrink)) {
    if (seen.hamming > max_hamming_) continue;
    Quad corners =
        is_doubled ? undoubled(seen.corners) : unhalved(scaled, seen.corners, pass.shrink > 0);
    for (Eigen::Vector2d& corner : corners) corner += offset;
    if (wanted_.any && !wanted_.patterns.contains(seen.id))
      wanted_.patterns.emplace(seen.id, tag_pattern(*wanted_.any, seen.id, wanted_.border_bits,
                                                    {0, wanted_.corner_squares}));
    add(image, seen.id, corners, search.halvings <= 0 && pass.shrink == 0, found);
  }
}

void FamilyDetector::find_bent(const ImageView8& image, const Lens& lens,
                               std::vector<FoundTag>& found) const {
  const PinholePicture straight(image, lens);
  const Pass& pass =
      passes_[passes_.size() / 2];  // most squares are off the tags, and few tags lost
  for (const Sighting& seen : sightings(*pass.detector, straight.image(), pass.shrink)) {
    FoundTag tag{.id = seen.id, .is_approximate = true};
    bool is_inside = seen.hamming <= max_hamming_;
    for (std::size_t i = 0; i < 4 && is_inside; ++i) {
      const auto at = straight.in_picture(seen.corners[i]);
      is_inside = at.has_value();
      if (at) tag.corners[i] = *at;
    }
    if (is_inside) found.push_back(tag);
  }
}

// Corners in a picture from those in the last of its halved versions. Corners are refined in each
// version on the way, because the next fit needs a start within 2 px; AprilTag's own corners are
// that good after one halving.
Quad FamilyDetector::unhalved(const std::vector<Image8>& halves, Quad corners,
                              bool is_shrunk) const {
  const QuadShape shape{family_->width_at_border, !family_->reversed_border};
  for (std::size_t i = halves.size(); i-- > 0;) {
    if (i > 0 || is_shrunk) corners = refine_edges(halves[i], corners, shape).value_or(corners);
    for (Eigen::Vector2d& corner : corners)
      corner = 2 * corner + Eigen::Vector2d::Constant(1.0 / 2);
  }
  return corners;
}

// Adds a sighting to `found`, or replaces the same tag of another pass if that was not refined.
// Corners that are not `exact` are approximate unless they can be refined.
void FamilyDetector::add(const ImageView8& image, int id, const Quad& corners, bool exact,
                         std::vector<FoundTag>& found) {
  const auto same = std::ranges::find_if(found, [&](const FoundTag& other) {
    return other.id == id && are_one_tag(other.corners, corners);
  });
  const bool is_known = same != found.end() && !same->is_approximate;
  if (is_known && (same->refined || refinement_ == Refinement::stock)) return;
  if (!is_inside(corners, image.size())) return;
  FoundTag tag{id, corners, false};
  if (refinement_ != Refinement::stock) tag = refined(image, tag.id, tag.corners).value_or(tag);
  if (!tag.refined && (is_known || (!exact && refinement_ != Refinement::fit))) return;
  tag.is_approximate = !tag.refined && !exact;
  if (!is_face(tag.corners) || !is_whole(tag, image.size())) return;
  if (same != found.end()) {
    *same = tag;
  } else {
    found.push_back(tag);
  }
}

std::optional<FoundTag> FamilyDetector::refined(const ImageView8& image, int id, const Quad& start,
                                                bool lens_follows) const {
  FoundTag tag{id, start, false};
  if (refinement_ == Refinement::fit && fit(tag, image, lens_follows)) return tag;
  const QuadShape shape{family_->width_at_border, !family_->reversed_border};
  const std::optional<Quad> corners = refine_edges(image, start, shape);
  if (!corners) return std::nullopt;
  tag.corners = *corners;
  tag.refined = true;
  if (refinement_ == Refinement::fit) fit(tag, image, lens_follows);  // from a better start
  return tag;
}

std::optional<FoundTag> FamilyDetector::refined_again(const ImageView8& image,
                                                      const FoundTag& before,
                                                      const Quad& start) const {
  FoundTag tag{before.id, start, false};
  const TagFitOptions options{
      .camera = camera_, .lens_follows = true, .rest = before.rest ? &*before.rest : nullptr};
  // A tag that has become too bent for a fit as a whole is fitted as one that is new.
  if (before.rest && is_inside(start, image.size(), 0) && fit(tag, image, options) && tag.rest)
    return tag;
  return refined(image, before.id, start);
}

bool FamilyDetector::fit(FoundTag& tag, const ImageView8& image, bool lens_follows) const {
  return (camera_ && fit(tag, image, {.camera = camera_})) ||
         fit(tag, image, {.lens_follows = lens_follows});
}

bool FamilyDetector::find_terms(const ImageView8& image, const std::vector<FoundTag*>& tags) {
  // Tags fitted as a whole first: their bends are modelled completely.
  std::vector<const FoundTag*> order(tags.begin(), tags.end());
  std::stable_partition(order.begin(), order.end(),
                        [](const FoundTag* tag) { return !tag->by_corner; });
  std::vector<TagInPicture> fitted;
  for (const FoundTag* tag : order) {
    if (!tag->fitted) continue;
    const bool is_rough = tag->rough_camera.has_value();
    fitted.push_back({&wanted_.patterns.at(tag->id), tag->corners,
                      is_rough ? &*tag->rough_camera : camera_, is_rough});
  }
  terms_ = terms_of_picture(image, std::move(fitted));
  if (terms_.is_none()) return false;
  for (FoundTag* tag : tags)
    if (!fit(*tag, image, true)) tag->fitted = false;  // its fit without them is biased
  return true;
}

bool FamilyDetector::fit_roughly(FoundTag& tag, const ImageView8& image, const Camera& camera,
                                 double reach_px) const {
  return fit(tag, image, {.camera = &camera, .is_rough = true}, reach_px);
}

bool FamilyDetector::fit(FoundTag& tag, const ImageView8& image, const TagFitOptions& options,
                         double reach_px) const {
  const auto pattern = wanted_.patterns.find(tag.id);
  if (pattern == wanted_.patterns.end()) return false;
  const auto fit = fit_tag_with(terms_, image, pattern->second, tag.corners, options, reach_px);
  if (!fit) return false;
  tag.corners = fit->corners;
  tag.covariance_px2 = fit->covariance_px2;
  tag.fitted = fit->status == TagFitStatus::converged;
  tag.refined = true;
  tag.by_corner = fit->is_by_corner;
  tag.rough_camera.reset();
  tag.rest.reset();
  if (options.is_rough) tag.rough_camera = *options.camera;
  if (tag.fitted && !tag.by_corner && !options.is_rough) tag.rest = fit->rest;
  return true;
}

}  // namespace tagcal::internal
