#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "tagcal/detect/board_search/board_patterns.hpp"
#include "tagcal/detect/board_search/complete_board.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

// Pictures of one board, and what complete_board() makes of them.

namespace tagcal::internal {

inline const Lens kPinhole = pinhole(600, 600, 319.5, 239.5);

// A board 0.65 m before a camera, tilted about its middle, with the corners where they truly are.
class BoardSight {
 public:
  explicit BoardSight(const Board& shown, const Lens& lens = kPinhole, double tilt_rad = 0.6,
                      const Eigen::Vector3d& middle_in_camera = {0, 0, 0.65})
      : board(shown) {
    scene_.camera = {lens, {640, 480}};
    scene_.boards = {{board, Pose()}};
    scene_.sensor = {1, 0.7, 2};
    const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
    const Eigen::Quaterniond tilt(
        Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d(0.5, 1, 0.2).normalized()));
    const auto points = target_points(board);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const TargetPoint& p : points) middle += p.position / static_cast<double>(points.size());
    const Eigen::Quaterniond rotation = tilt * facing;
    camera_from_board_ = Pose(rotation, middle_in_camera - rotation * middle);
  }

  // Grey paper over a tag, a millimetre above it, `share` of its side from its lower-left corner.
  void hide(int tag_id, double share = 1) {
    for (const Tag& tag : tags_of(board)) {
      if (tag.id != tag_id) continue;
      const auto c = tag_corners(tag);
      const Eigen::Vector3d up(0, 0, 1e-3);
      const Eigen::Vector3d right = share * (c[1] - c[0]), along = share * (c[3] - c[0]);
      scene_.occluders.push_back(
          {{c[0] + up, c[0] + right + up, c[0] + right + along + up, c[0] + along + up}, 0.5});
    }
  }

  Image8 image() const {
    return expose(render_light(scene_, tag_families(scene_.boards), camera_from_board_),
                  scene_.sensor, 7);
  }

  // The corners of a tag, in the picture or out of it.
  Quad truth(int tag_id) const {
    Quad quad;
    for (const Tag& tag : tags_of(board)) {
      if (tag.id != tag_id) continue;
      const auto corners = tag_corners(tag);
      for (std::size_t i = 0; i < 4; ++i)
        quad[i] = *project(scene_.camera.lens, camera_from_board_ * corners[i]);
    }
    return quad;
  }

  FoundTag seed(int tag_id) const { return {tag_id, truth(tag_id), true}; }

  Board board;

 private:
  Scene scene_;
  Pose camera_from_board_;
};

inline Board kalibr_board(int first_id = 0) {
  return make_board(AprilGrid{6, 5, 0.06, 0.3, first_id});
}

// Completes with the refinement that the detector has if no fit under the picture's lens follows.
inline Completion completed(const BoardSight& sight, const Image8& image,
                            const std::vector<FoundTag>& found, const Board& board) {
  const TagKind kind = tag_kind(board).value();
  FamilyDetector detector({kind.family,
                           kind.border_bits,
                           {},
                           tag_surroundings(board).corner_squares,
                           board_patterns({{board, Pose()}})},
                          {});
  const CompletionRules rules{
      1, {}, [&](int id, const Quad& start) { return detector.refined(image, id, start, false); }};
  const TagFamily family = tag_family(kind.family, kind.border_bits);
  Completion completion = complete_board(image, board, family, found, rules);
  for (const FoundTag& tag : completion.tags) {
    const Quad truth = sight.truth(tag.id);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT((tag.corners[i] - truth[i]).norm(), 0.25) << "tag " << tag.id;
  }
  return completion;
}

inline Completion completed(const BoardSight& sight, const std::vector<FoundTag>& found) {
  return completed(sight, sight.image(), found, sight.board);
}

inline std::map<int, WhyNot> reasons(const Completion& completion) {
  std::map<int, WhyNot> why;
  for (const MissingTag& tag : completion.missing) why[tag.id] = tag.why;
  return why;
}

// For messages.
inline std::string missing(const Completion& completion) {
  std::string text;
  for (const MissingTag& tag : completion.missing) {
    text += std::to_string(tag.id) + ": " + std::string(why_not_text(tag.why));
    if (tag.expected) {
      const Eigen::Vector2d at = ((*tag.expected)[0] + (*tag.expected)[2]) / 2;
      text += " at " + std::to_string(at.x()) + " " + std::to_string(at.y());
    }
    text += "\n";
  }
  return text;
}

}  // namespace tagcal::internal
