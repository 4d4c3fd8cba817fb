#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "study/method.hpp"
#include "study/tasks/board_view.hpp"
#include "study/tasks/tag_view.hpp"
#include "tagcal/detect/refine.hpp"

// Detection of the four corners of a tag in a picture, by ours and by the peers. Private to study.

namespace tagcal::study {

// The search of `tagcal detect` for the tags of boards of one kind. It is made before the timed
// part of a method, as for many pictures. The camera of the options must outlive it.
using TagFinder = std::function<std::vector<DetectedTag>(const ImageView8&)>;
TagFinder our_finder(const std::vector<PlacedBoard>& boards, const DetectOptions& options);

using CornerBound = Eigen::Matrix<double, 8, 8>;

// Cramer-Rao bound of (x0, y0, x1, y1, ..) for a known lens: the covariance of the fit to the
// picture without noise, in proportion to the noise of a pixel and its rounding. NaN if the fit
// does not converge.
CornerBound corner_bound(const Image8& noiseless, const TagPattern& pattern,
                         const TagCorners& corners, const Camera& camera, double noise_levels);

struct CornerTask {
  TagViewSpec spec;
  TagView view;
  PlacedBoard board;  // the tag alone
  TagPattern pattern;
  CornerBound bound_px2;

  double bound_px() const;  // RMS of a coordinate
};

// A tag seen with the tilt of the specification, in the middle of a pinhole's picture.
CornerTask draw_corner_task(const TagViewSpec& spec, Random& random);

struct CornerAnswer {
  TagCorners corners;
  std::optional<std::array<Matrix2, 4>> covariance_px2;  // of each corner, if claimed
};

using CornerMethod = Method<CornerTask, std::optional<CornerAnswer>>;

CornerMethod our_corners();                 // as `tagcal detect` finds them
CornerMethod our_corners_of_edges();        // as `tagcal detect --refinement edges`
CornerMethod our_corners_under_the_lens();  // as `tagcal detect --camera`
CornerMethod apriltag_corners(bool refine_edges);
CornerMethod opencv_corners();  // cornerSubPix, from AprilTag's

}  // namespace tagcal::study
