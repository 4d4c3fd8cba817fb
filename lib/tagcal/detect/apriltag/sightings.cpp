#include "tagcal/detect/apriltag/sightings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tagcal/detect/opencv/picture_filters.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/image_filters.hpp"

namespace tagcal::internal {
namespace {

// numeric: grey levels. Bounds of the range that counts as one colour: AprilTag's default, and the
// contrast of a weak tag where the whole picture is finely textured.
constexpr int kLeastRange = 5;
constexpr int kMostRange = 20;

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

}  // namespace

std::vector<Sighting> sightings(apriltag_detector_t& detector, const ImageView8& image,
                                int shrink) {
  if (std::max(image.width(), image.height()) > kMaxPictureSidePx) return {};
  Image8 shrunk;
  if (shrink > 0) shrunk = brightest(image, shrink);
  const ImageView8 looked_at = shrink > 0 ? ImageView8(shrunk) : image;
  detector.qtp.min_white_black_diff =
      std::clamp(static_cast<int>(std::lround(policy::kTagNoiseRange * noise_of(image))),
                 kLeastRange, kMostRange);
  // AprilTag does not write into the picture that it is given.
  image_u8_t view = {looked_at.width(), looked_at.height(), static_cast<int>(looked_at.stride()),
                     const_cast<std::uint8_t*>(looked_at.row(0))};
  const DetectionsHandle detections(apriltag_detector_detect(&detector, &view));
  std::vector<Sighting> sightings;
  for (int i = 0; i < zarray_size(detections.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections.get(), i, &detection);
    Sighting seen{detection->family, detection->id, detection->hamming, {}};
    for (std::size_t c = 0; c < 4; ++c) {
      constexpr double kCentre = 1.0 / 2;  // of AprilTag's first pixel
      seen.corners[c] = {detection->p[c][0] - kCentre, detection->p[c][1] - kCentre};
    }
    if (!is_face(seen.corners)) continue;
    if (shrink > 0) seen.corners = grown(seen.corners, shrink);
    sightings.push_back(seen);
  }
  return sightings;
}

bool are_one_tag(const Quad& a, const Quad& b) {
  return (centre_of(a) - centre_of(b)).norm() <
         policy::kTagSameShare * std::min(shortest_side(a), shortest_side(b));
}

}  // namespace tagcal::internal
