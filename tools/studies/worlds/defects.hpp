#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/random.hpp"
#include "tagcal/scene/board.hpp"

// Defects of a world's board and views, and the switches that force or exclude them.

namespace tagcal {

inline constexpr std::string_view kPixels = "pixels";    // rendered, and found in the pictures
inline constexpr std::string_view kCorners = "corners";  // projected, with noise

// Names a world: equal ids give equal worlds.
struct WorldId {
  std::uint64_t seed = 0, index = 0;
  std::string mode{kPixels};
  std::string switches;  // "+bend-rows": each world has a bend, none has sheared rows
  auto operator<=>(const WorldId&) const = default;
};

enum class Defect { bend, twist, aspect, rows, few, light, outliers, bare, camera };

struct DefectKind {
  std::string_view name;
  double share;         // of the worlds that have it, without a switch
  bool in_pixels;       // the renderer can draw it
  bool in_corners;      // it changes exact corners
  std::string_view is;  // for the help text
};
const DefectKind& kind_of(Defect defect);
std::string_view help_on_defects();  // a line for each kind

// The switches as in WorldId; "camera:jpeg" fixes the kind of pictures. Throws Error for an unknown
// name, a defect that is both forced and
// excluded, and one that is forced in a mode that does not have it.
std::string switches_text(const std::vector<std::string>& with,
                          const std::vector<std::string>& without, std::string_view mode);

// The kind of pictures that the switches fix; "" without one.
std::string fixed_pictures(const WorldId& id);

// A stream of random numbers of its own for a part of a world, so that a switch changes nothing but
// its defect.
Random stream_of(const WorldId& id, std::uint64_t part);

// The defects of the board and of all views.
struct Defects {
  // Out of the plane, as shares of the board's diagonal; x' and y' run from -1 to 1 over the
  // corners:  bend.x (1 - x'^2) + bend.y (1 - y'^2) + twist x' y'.
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();
  double twist = 0;
  double aspect = 0;   // share by which the print is longer along y
  double skew = 0;     // and by which x grows with y
  double rows_px = 0;  // largest displacement of the uppermost and lowest row, of all views
  int most_views = 0;  // 0: as many as were drawn
  bool uneven_light = false;
  bool outliers = false;    // some corners are grossly wrong
  bool covariances = true;  // each corner has a covariance
  bool camera = false;      // the camera changes its pictures (picture_kinds)

  bool of_board() const { return !bend.isZero(0) || twist != 0 || aspect != 0 || skew != 0; }
};
Defects draw_defects(const WorldId& id);

// The names of bend, twist, aspect and rows, joined by '+'; "" for right data.
std::string names_of(const Defects& defects);

// Where the printed, bent board has the points of its file.
class RealBoard {
 public:
  RealBoard(const Board& board, const Defects& defects);
  Eigen::Vector3d place_of(const Eigen::Vector3d& x_in_board) const;

 private:
  Defects defects_;
  Eigen::Vector2d centre_, half_size_;
};

// A number whose logarithm is uniform; low > 0.
double log_uniform(double low, double high, Random& random);

// The same with a random sign.
double signed_log_uniform(double low, double high, double share_negative, Random& random);

}  // namespace tagcal
