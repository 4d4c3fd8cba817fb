#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"

namespace tagcal {

// How the corners of a decoded tag are made finer.
enum class Refinement {
  stock,  // as AprilTag gives them
  edges,  // each side of the tag fitted by itself: refine_edges.hpp
  fit,    // the whole printed pattern fitted (refine_tag.hpp), with covariances; where that fails,
          // under the lens that the tags of the picture show together; where that fails too, the
          // tag is not reported
};

struct DetectOptions {
  int threads = 0;      // working side by side, on pictures or in a single one; 0: one per core
  int max_hamming = 1;  // wrong bits accepted in a tag (0-2)
  Refinement refinement = Refinement::fit;
  // The camera of all pictures, if it is known; it must outlive the search. Tags are fitted under
  // its lens (TagFitOptions::camera), and without where that fails.
  const Camera* camera = nullptr;
};

// A tag that was read, but is not reported: its pattern could not be fitted.
struct UnfittedTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  // roughly, px
};

struct DetectResult {
  std::vector<View> views;  // in the order of the images; corners ordered by id
  std::vector<std::vector<UnfittedTag>> unfitted;  // of each view
  std::vector<std::string> warnings;               // in plain words; those of one image name it
};

// One image of a batch: its name and how to load it (called from a worker thread, may throw Error).
struct ImageSource {
  std::string name;
  std::function<Image8()> load;
};

// What is printed on and around a tag, as far as it is known: a grid of black and white cells. The
// tag's plane has its unit along the side between the corners; (0, 0) is the upper-left corner, x
// right, y down on the upright tag. What lies outside of the outermost lines is not known.
struct TagPattern {
  enum Cell : std::uint8_t { black, white, unknown };
  std::vector<double> lines;  // borders of the cells, ascending, the same in x and in y
  std::vector<Cell> cells;    // (lines - 1)^2, row by row from above
};

// What surrounds a tag beyond its family's own frame.
struct TagSurroundings {
  double gap = 0;  // white to each side at least, in sides of the tag; 0: only the family's frame
  bool corner_squares = false;  // Kalibr's: black squares `gap` wide touch the corners (where the
                                // gap is 0, it is not known how wide)
};

enum class TagFitStatus {
  converged,
  not_converged,  // the pixels do not look like this pattern near the start
  out_of_image,   // a corner lies outside of the picture
  too_small,      // cells so narrow against the blur, or so few pixels, that corners are not fixed
};

struct TagFitOptions {
  // How far lenses are believed to bend lines within one tag: sd of a line's curvature, 1/px, and
  // of its change along the line, 1/px^2. Either zero: the tag is the image under a homography.
  double bend_sd_per_px = 1.6e-3;
  double twist_sd_per_px2 = 1.2e-5;
  int max_iterations = 12;
  // The camera of the picture, if it is known; it must outlive the call. Then nothing else is
  // believed to bend lines, and a tag of any size is fitted as a whole. What has no ray is not
  // looked at. Error unless its image has the picture's size. Of no use for parallel rays, under
  // which lines are straight.
  const Camera* camera = nullptr;
  // The camera is known roughly only: bends as above are believed of what it leaves.
  bool is_rough = false;
  // Never corner by corner: the whole tag, however large and bent.
  bool is_whole = false;
  // How far borders between black and white are believed to be shifted, px: by ink that spreads,
  // and by paper so bright that it eats black, each. Corners are where they would be without. Zero:
  // not at all.
  double shift_sd_px = 0;
  // Grey levels are light to this power, as cameras make it for screens: then the blur of a border
  // is not symmetric.
  double gamma = 1;
};

struct TagFit {
  TagFitStatus status = TagFitStatus::not_converged;
  // Only where converged:
  std::array<Eigen::Vector2d, 4> corners{};  // 0..3 as in CornerId, pixel centres at whole numbers
  Eigen::Matrix<double, 8, 8> covariance_px2 =
      Eigen::Matrix<double, 8, 8>::Zero();  // of (x0, y0, x1, y1, ..), from the residuals
  double blur_px = 0;                       // Gaussian before the pixels' squares; 0 if less
  double black = 0;                         // grey levels at the tag's centre
  double white = 0;
  // Of borders towards black, px: the part that is the same all over the picture, and the part that
  // is the same all over the tag. Of a tag that faces the camera only their sum is known.
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double noise_levels = 0;  // sd of a pixel about the model, quantisation (1/12) included
  int num_pixels = 0;       // that were used
  int iterations = 0;
  bool is_by_corner = false;  // strongly bent: a camera, even one known roughly, would say more
};

}  // namespace tagcal
