#include "study/peers/pose_peers.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/apriltag_pose.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <memory>

#include "study/peers/quiet_stderr.hpp"
#include "study/peers/tag_peers.hpp"
#include "tagcal/solvers/plane.hpp"

namespace tagcal::study {
using namespace internal;
namespace {

using Eigen::Vector3d;

// A matd_t of 3 x 3 (the library exports no function that makes one).
struct Matd3 {
  alignas(matd_t) unsigned char bytes[sizeof(matd_t) + 9 * sizeof(double)] = {};

  matd_t* set(const Eigen::Matrix3d& m) {
    auto* matd = new (bytes) matd_t{3, 3};
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matd->data) = m;
    return matd;
  }
};

// Has pointers to its own members: must not be copied.
struct State {
  apriltag_detection_t detection{};
  apriltag_detection_info_t info{};
  Matd3 homography;
  Eigen::Matrix3d rotation;
  Vector3d translation;

  // AprilTag's own frame has y down and z into the tag: its corners are (-1, 1), (1, 1), (1, -1),
  // (-1, -1) in half sides.
  explicit State(const PoseTask& task) {
    const auto p = parameters(task.camera.lens);
    std::vector<Eigen::Vector2d> corners;
    std::vector<Vector3d> pixels;
    for (std::size_t i = 0; i < 4; ++i) {
      const Correspondence& c = task.correspondences[3 - i];
      detection.p[i][0] = c.pixel.x(), detection.p[i][1] = c.pixel.y();
      corners.emplace_back(i == 0 || i == 3 ? -1 : 1, i < 2 ? 1 : -1);
      pixels.push_back(c.pixel.homogeneous());
    }
    const auto h = tagcal::homography(corners, pixels);
    if (h) detection.H = homography.set(*h / (*h)(2, 2));
    const double side = (task.correspondences[1].point - task.correspondences[0].point).norm();
    info = {&detection, side, p[0], p[1], p[2], p[3]};
  }

  void solve() {
    if (!detection.H) return;
    apriltag_pose_t pose{};
    const QuietStderr quiet;  // "Error, more than one new minimum found"
    estimate_tag_pose(&info, &pose);
    rotation = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.R->data);
    translation = Eigen::Map<Vector3d>(pose.t->data);
    std::free(pose.R);
    std::free(pose.t);
  }

  PoseAnswer answer() const {
    PoseAnswer result;
    result.success = detection.H && rotation.allFinite() && translation.allFinite();
    if (!result.success) return result;
    const Eigen::Matrix3d ours = rotation * Vector3d(1, -1, -1).asDiagonal();
    result.camera_from_target = Pose(Eigen::Quaterniond(ours), translation);
    return result;
  }
};

}  // namespace

PoseMethod apriltag_pose() {
  return {"AprilTag estimate_tag_pose",
          [](const PoseTask& task) {
            return prepare_state<PoseAnswer>(
                std::make_shared<State>(task), [](const auto& state) { state->solve(); },
                [](const auto& state) { return state->answer(); });
          },
          "orthogonal iteration, 50 steps, the better of two poses; the detector's homography is "
          "there before"};
}

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
