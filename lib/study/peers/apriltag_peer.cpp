#include "study/peers/tag_peers.hpp"

namespace tagcal::study {
using namespace internal;

std::mutex& apriltag_family_lock() {
  static std::mutex lock;
  return lock;
}

AprilTagPeer::AprilTagPeer(const std::string& family, int border_bits)
    : detector_(apriltag_detector_create()) {
  const std::scoped_lock lock(apriltag_family_lock());
  family_ = create_family(family, border_bits);
  apriltag_detector_add_family_bits(detector_.get(), family_.get(), 1);
  detector_->nthreads = 1;
  detector_->quad_decimate = 1;
}

std::vector<PeerTag> AprilTagPeer::find(const Image8& image, bool refine_edges) const {
  detector_->refine_edges = refine_edges;
  image_u8_t view = {image.width(), image.height(), image.width(),
                     const_cast<std::uint8_t*>(image.row(0))};
  const DetectionsHandle all(apriltag_detector_detect(detector_.get(), &view));
  std::vector<PeerTag> tags;
  for (int i = 0; i < zarray_size(all.get()); ++i) {
    apriltag_detection_t* found = nullptr;
    zarray_get(all.get(), i, &found);
    PeerTag tag;
    tag.id = found->id;
    for (std::size_t k = 0; k < 4; ++k)  // AprilTag's pixel centres are at 0.5
      tag.corners[k] = {found->p[k][0] - 0.5, found->p[k][1] - 0.5};
    tags.push_back(tag);
  }
  return tags;
}

}  // namespace tagcal::study
