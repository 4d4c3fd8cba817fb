#include "tagcal/detect/apriltag/family_detector.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tagcal/detect/families.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/picture_gamma.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/error.hpp"

namespace tagcal::internal {
namespace {

// The quad with every side moved outwards by `distance`.
Quad grown(const Quad& quad, double distance) {
  const auto side = [&](std::size_t i) {
    const Eigen::Vector2d along = (quad[(i + 1) % 4] - quad[i]).normalized();
    const Eigen::Vector2d outwards(-along.y(), along.x());
    return Eigen::Vector3d(outwards.x(), outwards.y(), -outwards.dot(quad[i]) - distance);
  };
  Quad result;
  for (std::size_t i = 0; i < 4; ++i) {
    result[i] = side((i + 3) % 4).cross(side(i)).hnormalized();
  }
  return result;
}

// True if two tags of one id are the same tag.
bool overlap(const Quad& a, const Quad& b) {
  return (centre_of(a) - centre_of(b)).norm() <
         policy::kTagSameShare * std::min(shortest_side(a), shortest_side(b));
}

// Corners in a picture from those in the doubled one, whose pixel x lies at x / 2 - 1 / 4.
Quad undoubled(Quad corners) {
  for (Eigen::Vector2d& corner : corners) corner = corner / 2 - Eigen::Vector2d::Constant(1.0 / 4);
  return corners;
}

int most_wrong_bits(const Wanted& wanted) {
  const FamilyHandle family = create_family(wanted.family, wanted.border_bits);
  const int by_distance = (static_cast<int>(family->h) - 1) / 2;  // a code stays the nearest one
  return std::min(by_distance, family->ncodes > policy::kTagMaxCodesForTwo ? 1 : 2);
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
  return size.width * size.height <= policy::kBoardMaxDoubledPixels;
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
  if (std::min(searched.width(), searched.height()) < policy::kTagMinPictureSidePx) return;
  const Pass& pass = passes_[search.pass];
  const Eigen::Vector2d offset(search.box.left, search.box.top);
  for (const Sighting& seen : look(searched, pass)) {
    Quad corners = is_doubled ? undoubled(seen.corners) : unhalved(scaled, seen, pass.shrink > 0);
    for (Eigen::Vector2d& corner : corners) corner += offset;
    if (wanted_.any && !wanted_.patterns.contains(seen.id))
      wanted_.patterns.emplace(seen.id, tag_pattern(*wanted_.any, seen.id, wanted_.border_bits,
                                                    {0, wanted_.corner_squares}));
    add(image, {seen.id, corners}, search.halvings <= 0 && pass.shrink == 0, found);
  }
  num_quads_ = std::max(num_quads_, static_cast<int>(pass.detector->nquads));
}

std::vector<FamilyDetector::Sighting> FamilyDetector::look(const ImageView8& searched,
                                                           const Pass& pass) const {
  Image8 shrunk;
  if (pass.shrink > 0) shrunk = brightest(searched, pass.shrink);
  const ImageView8 looked_at = pass.shrink > 0 ? ImageView8(shrunk) : searched;
  pass.detector->qtp.min_white_black_diff =
      std::clamp(static_cast<int>(std::lround(policy::kTagNoiseRange * noise_of(searched))),
                 policy::kTagLeastRange, policy::kTagMostRange);
  // AprilTag does not write into the picture that it is given.
  image_u8_t view = {looked_at.width(), looked_at.height(), static_cast<int>(looked_at.stride()),
                     const_cast<std::uint8_t*>(looked_at.row(0))};
  const DetectionsHandle detections(apriltag_detector_detect(pass.detector.get(), &view));
  std::vector<Sighting> sightings;
  for (int i = 0; i < zarray_size(detections.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections.get(), i, &detection);
    if (detection->hamming > max_hamming_) continue;
    Sighting seen{detection->id, {}};
    for (std::size_t c = 0; c < 4; ++c) {
      constexpr double kCentre = 1.0 / 2;  // of AprilTag's first pixel
      seen.corners[c] = {detection->p[c][0] - kCentre, detection->p[c][1] - kCentre};
    }
    if (!is_face(seen.corners)) continue;
    if (pass.shrink > 0) seen.corners = grown(seen.corners, pass.shrink);
    sightings.push_back(seen);
  }
  return sightings;
}

// Corners in a picture from those in the last of its halved versions. Corners are refined in each
// version on the way, because the next fit needs a start within 2 px; AprilTag's own corners are
// that good after one halving.
Quad FamilyDetector::unhalved(const std::vector<Image8>& halves, const Sighting& seen,
                              bool is_shrunk) const {
  Quad corners = seen.corners;
  const QuadShape shape{family_->width_at_border, !family_->reversed_border};
  for (std::size_t i = halves.size(); i-- > 0;) {
    if (i > 0 || is_shrunk) corners = refine_edges(halves[i], corners, shape).value_or(corners);
    for (Eigen::Vector2d& corner : corners)
      corner = 2 * corner + Eigen::Vector2d::Constant(1.0 / 2);
  }
  return corners;
}

// Adds a sighting to `found`, or replaces the same tag of another pass if that was not refined.
// Corners that are not `exact` are used only if they can be refined.
void FamilyDetector::add(const ImageView8& image, const Sighting& sighting, bool exact,
                         std::vector<FoundTag>& found) {
  const auto same = std::ranges::find_if(found, [&](const FoundTag& other) {
    return other.id == sighting.id && overlap(other.corners, sighting.corners);
  });
  if (same != found.end() && (same->refined || refinement_ == Refinement::stock)) return;
  if (!is_inside(sighting.corners, image.size())) return;
  FoundTag tag{sighting.id, sighting.corners, false};
  if (refinement_ != Refinement::stock) tag = refined(image, tag.id, tag.corners).value_or(tag);
  if (!tag.refined && (!exact || same != found.end())) return;
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

bool FamilyDetector::fit(FoundTag& tag, const ImageView8& image, bool lens_follows) const {
  return (camera_ && fit(tag, image, {camera_, false, gamma_})) ||
         fit(tag, image, {nullptr, false, gamma_, false, lens_follows});
}

bool FamilyDetector::find_gamma(const ImageView8& image, const std::vector<FoundTag*>& tags) {
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
  gamma_ = gamma_of_picture(image, std::move(fitted));
  if (gamma_ == 1) return false;
  for (FoundTag* tag : tags)
    if (!fit(*tag, image, true)) tag->fitted = false;  // its fit without gamma is biased
  return true;
}

bool FamilyDetector::fit_roughly(FoundTag& tag, const ImageView8& image,
                                 const Camera& camera) const {
  return fit(tag, image, {&camera, true, gamma_});
}

bool FamilyDetector::fit(FoundTag& tag, const ImageView8& image,
                         const KnownTagOptions& known) const {
  const auto pattern = wanted_.patterns.find(tag.id);
  if (pattern == wanted_.patterns.end()) return false;
  const auto fit = fit_known_tag(image, pattern->second, tag.corners, known);
  if (!fit) return false;
  tag.corners = fit->corners;
  tag.covariance_px2 = fit->covariance_px2;
  tag.fitted = fit->status == TagFitStatus::converged;
  tag.refined = true;
  tag.by_corner = fit->is_by_corner;
  tag.rough_camera.reset();
  if (known.is_rough) tag.rough_camera = *known.camera;
  return true;
}

}  // namespace tagcal::internal
