#include "tagcal/detect/family_detector.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "tagcal/detect/families.hpp"
#include "tagcal/detect/quad.hpp"

namespace tagcal {
namespace {

constexpr double kSamePlace = 3;         // px
constexpr double kMaxMove = 2;           // px, of a corner by its fit
constexpr std::array kShrinks = {1, 2};  // px

// The brightest of each pixel's neighbours up to `radius` away: black shrinks by so much. The
// corner squares of a Kalibr board, which touch the tags' corners, then no longer hang together
// with them.
Image8 brightest(const Image8& image, int radius) {
  const auto width = image.width();
  const auto height = image.height();
  Image8 rows(image.size());
  Image8 result(image.size());
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* in = image.row(y);
    for (int x = 0; x < width; ++x) {
      rows(x, y) =
          *std::max_element(in + std::max(0, x - radius), in + std::min(width, x + radius + 1));
    }
  }
  for (int y = 0; y < height; ++y) {
    std::uint8_t* out = result.row(y);
    for (int i = std::max(0, y - radius); i <= std::min(height - 1, y + radius); ++i) {
      const std::uint8_t* in = rows.row(i);
      for (int x = 0; x < width; ++x) out[x] = std::max(out[x], in[x]);
    }
  }
  return result;
}

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

// The same tag, seen in another pass, is kept once.
void keep(const FoundTag& tag, std::vector<FoundTag>& found) {
  for (FoundTag& other : found) {
    if (other.id != tag.id || largest_distance(other.corners, tag.corners) > kSamePlace) continue;
    if (!other.refined) other = tag;
    return;
  }
  found.push_back(tag);
}

}  // namespace

FamilyDetector::FamilyDetector(const Wanted& wanted, const DetectOptions& options)
    : wanted_(wanted),
      family_(create_family(wanted.family, wanted.border_bits)),
      detector_(apriltag_detector_create()),
      max_hamming_(std::clamp(options.max_hamming, 0, 2)),
      refinement_(options.refinement),
      patterns_of_(tag_family(wanted.family, wanted.border_bits)) {
  apriltag_detector_add_family_bits(detector_.get(), family_.get(), max_hamming_);
  detector_->nthreads = 1;
  detector_->quad_decimate = 1;  // 2 misses a third of the tags 20 px wide
  detector_->refine_edges = true;
}

std::vector<FoundTag> FamilyDetector::find(const Image8& image) {
  std::vector<FoundTag> found;
  num_quads_ = 0;
  look(image, image, 0, found);
  if (wanted_.corner_squares) {
    for (const int radius : kShrinks) look(image, brightest(image, radius), radius, found);
  }
  return found;
}

// Looks at a picture in which black has shrunk by `shrink` px.
void FamilyDetector::look(const Image8& image, const Image8& shrunk, int shrink,
                          std::vector<FoundTag>& found) {
  // AprilTag does not write into the picture that it is given.
  image_u8_t view = {shrunk.width(), shrunk.height(), shrunk.width(),
                     const_cast<std::uint8_t*>(shrunk.row(0))};
  const DetectionsHandle detections(apriltag_detector_detect(detector_.get(), &view));
  num_quads_ = std::max(num_quads_, static_cast<int>(detector_->nquads));
  for (int i = 0; i < zarray_size(detections.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections.get(), i, &detection);
    if (detection->hamming > max_hamming_) continue;
    if (const auto tag = named(*detection, image, shrink)) keep(*tag, found);
  }
}

std::optional<FoundTag> FamilyDetector::named(const apriltag_detection_t& detection,
                                              const Image8& image, int shrink) {
  Quad start;
  for (std::size_t i = 0; i < 4; ++i) {
    // AprilTag's pixel centres are at 0.5.
    start[i] = {detection.p[i][0] - 0.5, detection.p[i][1] - 0.5};
  }
  if (!is_face(start)) return std::nullopt;
  if (shrink > 0) start = grown(start, shrink);
  if (!is_inside(start, image.size())) return std::nullopt;
  FoundTag tag{detection.id, start, false};
  if (refinement_ != Refinement::stock) tag = refined(image, tag.id, start).value_or(tag);
  if (!tag.refined && shrink > 0) return std::nullopt;  // where black shrank, so did the corners
  if (!is_face(tag.corners) || !is_inside(tag.corners, image.size())) return std::nullopt;
  return tag;
}

std::optional<FoundTag> FamilyDetector::refined(const Image8& image, int id, const Quad& start) {
  FoundTag tag{id, start, false};
  if (refinement_ == Refinement::fit && fit(tag, image)) return tag;
  const QuadShape shape{family_->width_at_border, !family_->reversed_border};
  const std::optional<Quad> corners = refine_edges(image, start, shape);
  if (!corners) return std::nullopt;
  tag.corners = *corners;
  tag.refined = true;
  if (refinement_ == Refinement::fit) fit(tag, image);  // from nearer
  return tag;
}

bool FamilyDetector::fit(FoundTag& tag, const Image8& image) {
  auto pattern = patterns_.find(tag.id);
  if (pattern == patterns_.end()) {
    const auto known = wanted_.surroundings.find(tag.id);
    const TagSurroundings around =
        known == wanted_.surroundings.end() ? TagSurroundings() : known->second;
    pattern =
        patterns_.emplace(tag.id, tag_pattern(patterns_of_, tag.id, wanted_.border_bits, around))
            .first;
  }
  const TagFit fit = refine_tag(image, pattern->second, tag.corners);
  if (fit.status != TagFitStatus::converged ||
      largest_distance(fit.corners, tag.corners) > kMaxMove)
    return false;
  tag.corners = fit.corners;
  tag.covariance_px2 = fit.covariance_px2;
  tag.refined = true;
  return true;
}

}  // namespace tagcal
