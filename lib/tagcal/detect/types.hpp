#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/scene/dataset.hpp"
#include "tagcal/scene/image.hpp"
#include "tagcal/scene/scene.hpp"

namespace tagcal {

using Matrix8 = Eigen::Matrix<double, 8, 8, Eigen::DontAlign>;

// How the corners of a decoded tag are refined.
enum class Refinement {
  stock,  // as AprilTag gives them
  edges,  // each side of the tag fitted by itself, without covariances
  fit,    // the whole printed pattern fitted (refine.hpp), with covariances; if that fails,
          // under the lens estimated from the picture's tags; if that fails too, the tag is not
          // reported
};

// A tag that was read but is not reported, because its pattern could not be fitted.
struct UnfittedTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  // approximate, px
};

// All that a search found in one picture.
struct DetectedPicture {
  View view;  // corners ordered by id
  ImageSize size;
  // Standard deviation per coordinate by which corners scatter beyond the claims of their fits, of
  // all pictures of the call: it is part of the covariances. 0 if the claims explain the scatter.
  double corner_error_px = 0;
  std::vector<UnfittedTag> unfitted;
  std::vector<std::string> warnings;  // begin with the picture's name
  // Numbers of the boards' tags: whose print surely is the target's, and which were expected in the
  // picture but not surely read. They decide whether the target's border is wrong.
  int num_sure = 0;
  int num_unread = 0;
  bool has_strange_tags = false;  // of the boards' families, on no board
  std::string unreadable;  // why it could not be loaded; the rest is empty then
};

// A mistake in a target file, or in the way a picture was made, that pictures show.
struct TargetMistake {
  std::string name;            // "wrong border"
  std::string sentence;        // what the picture shows, what the file says, what to write
  bool moves_corners = false;  // corners found with this file have wrong numbers or places
  // Only several pictures that show the same make it a mistake: one may show a part of the board.
  bool needs_others = false;

  std::string text() const { return name + ": " + sentence; }
};

// Results that a program kept from an earlier run on the same pictures, with the same boards and
// options. The functions are called from worker threads, with the picture's index.
struct EarlierResults {
  // `first`: the picture from which on its sequence was followed (ImageSource::follows).
  std::function<std::optional<DetectedPicture>(std::size_t picture, std::size_t first)> find;
  std::function<void(std::size_t, const DetectedPicture&)> keep;  // one that was not found
};

struct DetectOptions {
  int threads = 0;      // for pictures in parallel; 0: one per core
  int max_hamming = 1;  // wrong bits accepted in a tag (0-2; 1 at most in families of more than
                        // 4096 tags)
  Refinement refinement = Refinement::fit;
  // The camera of all pictures, if it is known; it must outlive the search. Tags are fitted under
  // its lens (TagFitOptions::camera), or without it if that fails.
  const Camera* camera = nullptr;
  bool skip_unreadable = false;             // pictures that cannot be loaded do not end the search
  const EarlierResults* earlier = nullptr;  // of detect_all; must outlive the search
};

// A tag in a picture that is on no known board. An id may be seen more than once.
struct DetectedTag {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  // 0..3 as in CornerId, pixel centres at whole numbers
  // Covariance of (x0, y0, x1, y1, ..), if the tag's pattern was fitted.
  std::optional<Matrix8> covariance_px2;
};

// The tags of one picture of many.
struct PictureTags {
  std::vector<DetectedTag> tags;
  std::string unreadable;  // why it could not be loaded; it has no tags then
};

// One image of a batch: its name and how to load it (called from a worker thread, may throw Error).
struct ImageSource {
  std::string name;
  std::function<Image8()> load;
  // It shows what the source before it shows, a moment later: the next frame of a sequence. The
  // board is then looked for where it was (BoardTracker).
  bool follows = false;
};

// The print on and around a tag, as a grid of black and white cells. Unit of the tag's plane: the
// side between the corners; (0, 0) is the upper-left corner, x right, y down on the upright tag.
// Everything beyond the outermost lines is unknown.
struct TagPattern {
  enum Cell : std::uint8_t { black, white, unknown };
  std::vector<double> lines;  // borders of the cells, ascending, the same in x and in y
  std::vector<Cell> cells;    // (lines - 1)^2, row by row from above
};

// The print around a tag beyond its family's own frame.
struct TagSurroundings {
  double gap = 0;  // least white to each side, in sides of the tag; 0: only the family's frame
  bool corner_squares = false;  // Kalibr's: black squares `gap` wide touch the corners (of unknown
                                // width if the gap is 0)
};

// The parameters of a tag's fit beside its corners: blur, grey levels, shifts of borders and bends.
using TagFitRest = std::array<double, 19>;

// A camera's processing of the light of a picture.
struct CameraProcessing {
  // Grey level = light to this power, as cameras encode it for screens: it makes the blur of a
  // border asymmetric.
  double gamma = 1;
  // Sharpening after that, which is undone before the fit. Amount 0: none.
  Sharpen sharpen = {0, 1};

  bool is_none() const { return gamma == 1 && sharpen.amount == 0; }
};

enum class TagFitStatus {
  converged,
  not_converged,  // the pixels do not look like this pattern near the start
  out_of_image,   // a corner lies outside of the picture
  too_small,      // too few pixels to determine corners
};

struct TagFitOptions {
  // Prior of the bends that a lens gives to lines within one tag: sd of a line's curvature, 1/px,
  // and of its change along the line, 1/px^2. If either is zero, the tag is the image under a
  // homography. The defaults are those of detect() for pictures 1280 px wide: 2 / 1280 and
  // 20 / 1280^2 (kTagBendSd and kTagTwistSd of policy/policy.hpp), rounded.
  double bend_sd_per_px = 1.6e-3;    // numeric: default, source above
  double twist_sd_per_px2 = 1.2e-5;  // numeric: default, source above
  int max_iterations = 20;
  // The camera of the picture, if it is known; it must outlive the call. Then the prior of bends is
  // not used, and a tag of any size is fitted as a whole. Pixels without a ray are not used. Throws
  // Error unless its image has the picture's size. Has no effect for a parallel projection, under
  // which lines are straight.
  const Camera* camera = nullptr;
  // The camera is only roughly known: the prior of bends applies to what its lens leaves.
  bool is_rough = false;
  // Fits the whole tag however large and bent it is, never corner by corner.
  bool is_whole = false;
  // Every how many-th row of pixels is used: fewer are faster and tell less.
  int row_step = 1;
  // A fit under the picture's lens follows: a tag that would be fitted corner by corner is not, and
  // only gets approximate corners (TagFit::is_by_corner, not converged); a corner is fitted to half
  // as much of the sides next to it.
  bool lens_follows = false;
  // The start of a corner and of its neighbourhood is good to a quarter of a pixel, by earlier
  // fits: stages that lead there are left out.
  bool is_near = false;
  // The result of this tag's fit in the picture before, with which the fit begins; the start of the
  // corners must then be good to half a pixel. It must outlive the call.
  const TagFitRest* rest = nullptr;
  // Prior standard deviation of the shift of borders between black and white, px: by ink that
  // spreads, and by bloom of bright paper, each. Corners are reported without the shift. Zero: no
  // shift.
  double shift_sd_px = 0;
  CameraProcessing processing;
};

// The fit of a printed pattern to pixels. Only if it converged, the numbers are those of its
// minimum.
struct PatternFit {
  TagFitStatus status = TagFitStatus::not_converged;
  double blur_px = 0;  // sd of the Gaussian without the pixel's square; 0 if less than that
  double black = 0;    // grey levels at the tag's centre, or at the corner
  double white = 0;
  double noise_levels = 0;  // sd of a pixel about the model, quantisation (1/12) included
  int num_pixels = 0;       // used by the fit
};

struct TagFit : PatternFit {
  std::array<Eigen::Vector2d, 4> corners{};  // 0..3 as in CornerId, pixel centres at whole numbers
  Matrix8 covariance_px2 = Matrix8::Zero();  // for (x0, y0, x1, y1, ..), from the residuals
  // Shift of borders towards black, px: the part that is constant in the picture (bloom), and the
  // part that is constant on the tag (ink). A tag that faces the camera determines only their sum.
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  int iterations = 0;
  TagFitRest rest{};
  // Strongly bent: a camera, even a rough one, would improve the corners.
  bool is_by_corner = false;
};

// The print about a place where four squares of a checkerboard meet, as a grid of cells. The place
// is (0, 0), and a line of each direction passes through it; any unit, any handedness. Everything
// beyond the outermost lines is unknown.
struct CornerPattern {
  std::vector<double> columns, rows;    // borders of the cells in x and in y, ascending, 3 to 24
  std::vector<TagPattern::Cell> cells;  // (columns - 1) x (rows - 1), by rows from the lowest y
};

struct CornerFit : PatternFit {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();          // pixel centres at whole numbers
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  // from the residuals
};

}  // namespace tagcal
