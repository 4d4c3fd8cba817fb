#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tagcal/scene/scene.hpp"
#include "tagcal/viewing/clip.hpp"

// The print of a board, the surfaces of a scene, and the parts that they hide from an eye. The
// exact corners, the renderer and the drawings share them, so that they agree.

namespace tagcal {

// ---- Boards

// A rectangle in the board frame (metres), corners as those of a tag: lower-left, lower-right,
// upper-right, upper-left seen from its front.
using Rectangle = std::array<Eigen::Vector3d, 4>;

// A box of the plane z = 0 of a frame.
Rectangle rectangle(const Pose& board_from_frame, const Eigen::AlignedBox2d& box);

// The black squares of a checkerboard, or Kalibr's between the tags of a grid; none on other
// boards. Disjoint, and outside of the tags. `spread_m` moves each edge outwards, a negative one
// inwards. What two grown squares that touch at a corner have in common belongs to one of them, and
// what a square has in common with a grown tag to the tag; then a square is several rectangles.
std::vector<Rectangle> black_squares(const Board& board, double spread_m = 0);

// The whole area of a checkerboard, its white squares included, in the board frame.
Eigen::AlignedBox2d checkerboard_area(const Checkerboard& board);

// A flat part of a board: what is printed on one sheet of paper. A checkerboard is one panel, and
// so is a board whose tags lie in one plane and face the same way; on any other (a cube of tags,
// say) each tag is a panel of its own.
struct BoardPanel {
  Rectangle paper;
  std::vector<Tag> tags;            // of a ChArUco board the markers
  std::vector<Rectangle> squares;   // black_squares
  std::vector<TargetPoint> points;  // that can be observed on it
};

// A convex polygon in the board frame, counter-clockwise seen from its front.
using InkCell = std::vector<Eigen::Vector3d>;

// The panels of a board; a board of measured points has none. The paper is the bounding rectangle
// of tags, discs and squares, white squares included, grown by the margin; tags with cells outside
// of their corners (tagStandard41h12 and its kin) count with those cells.
std::vector<BoardPanel> board_panels(const Board& board, double margin_m);

// The black area of a panel as disjoint polygons: rectangles, and discs as regular polygons of the
// disc's area whose sides lie within 6e-5 radii of the circle. The border width of the
// family is replaced by that of the board; boards without tags need no family. `spread_m` moves
// every edge of the print into the white, a negative one into the black; corners stay right angles.
// Black squares that touch at a corner grow together there, or draw apart. `grid_m` is
// Scene::print_grid_m, less than a cell. Throws Error if a tag's id is not in the family, the
// family does not allow the board's border or corner squares, or edges would meet: |spread_m| must
// be less than half a cell and half the gap between tags, and less than half a square and half the
// gap between square and marker, or than the radius of a disc and half the gap between discs.
std::vector<InkCell> ink_cells(const Board& board, const BoardPanel& panel, const TagFamily& family,
                               double spread_m = 0, double grid_m = 0);

// The ids of two tags in one plane, squares `outer` of their size wider on each side, that overlap
// or touch when every side moves outwards by `spread_m`.
std::optional<std::pair<int, int>> overlapping_tags(const std::vector<Tag>& tags, double outer,
                                                    double spread_m);

// The same for what a flat board prints; tags may touch, as within a micrometre.
std::optional<std::pair<int, int>> overlapping_tags(const Board& board);

// The same for all panels of a board.
std::vector<InkCell> ink_cells(const Board& board, const TagFamily& family);

// The print of a panel for a drawing: whole tags, the squares of a checkerboard, and discs with
// fewer corners than those of ink_cells().
std::vector<InkCell> drawn_print(const Board& board, const BoardPanel& panel);

// ---- Scenes

// A flat, convex, opaque polygon: the paper of a panel, or an occluder.
struct Sheet {
  std::vector<Eigen::Vector3d> corners;
  Eigen::Vector3d normal;  // unit; the corners run counter-clockwise seen from where it points
  std::size_t board = 0;   // index in the scene, of a paper
  std::size_t occluder = 0;
  std::shared_ptr<const BoardPanel> panel;  // of a paper; shared by copies of the sheet
};

// All opaque surfaces of a scene, in its world. Where several lie in one plane, each lies on those
// before it: the occluders in the order of the scene, then the papers (an occluder is the desk
// under a board). Throws Error if an occluder has fewer than three corners or no area.
std::vector<Sheet> sheets(const Scene& scene);

// A sheet of the world in another frame.
Sheet in_frame(Sheet sheet, const Pose& target_from_world);

// "board 0", "occluder 2", or the occluder's own name.
std::string sheet_name(const Scene& scene, const Sheet& sheet);

// The shadow of a convex sheet, if the eye were a lamp, is an intersection of half-spaces: one
// beyond its plane and, through the eye, one inside each of its edges (Crow, SIGGRAPH 1977). A
// point is hidden if it is in the shadow of a sheet that it is not on, and the seen area of a sheet
// is what the shadows of the others leave (Weiler & Atherton, SIGGRAPH 1977). No order of the
// sheets is needed: the rule holds for sheets that intersect or hide each other in a ring. Sheets
// closer than a tolerance count as lying in one plane (kTouching). A sheet that is seen edge-on is
// not seen and has no shadow.
class Shadows {
 public:
  using Polygon = std::vector<Eigen::Vector3d>;
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  // Takes sheets in the world, or makes those of a scene.
  Shadows(std::vector<Sheet> sheets, const Lens& lens, const Pose& camera_from_world);
  Shadows(const Scene& scene, const Lens& lens, const Pose& camera_from_world)
      : Shadows(tagcal::sheets(scene), lens, camera_from_world) {}

  // The sheets of the scene, in the camera frame.
  const std::vector<Sheet>& sheets() const { return sheets_; }

  // Returns true if the front of the sheet is turned to the eye.
  bool faces(std::size_t sheet) const;

  // The sheet (index) that the eye sees at the image of x instead of x, a point on the sheet `own`.
  // No value if nothing hides x.
  std::optional<std::size_t> seen_instead(const Eigen::Vector3d& x, std::size_t own = kNone) const;

  // The point in the plane of a sheet that has the same image as x. Precondition: the sheet is not
  // seen edge-on.
  Eigen::Vector3d in_line(std::size_t sheet, const Eigen::Vector3d& x) const;

  // The parts of a convex polygon on the sheet `own` that the eye sees, disjoint and convex; in the
  // second form, if there were only the sheets `hidden_by` besides. A corner of one part on an edge
  // of another is a corner of both: a tracer that follows shared edges from corner to corner gives
  // them the same image.
  std::vector<Polygon> visible_parts(Polygon polygon, std::size_t own) const {
    return visible_parts(std::move(polygon), own, all_);
  }
  std::vector<Polygon> visible_parts(Polygon polygon, std::size_t own,
                                     std::span<const std::size_t> hidden_by) const;

  // The indices of all sheets.
  const std::vector<std::size_t>& all() const { return all_; }

  // The half-spaces of the shadow of `sheet` on points of the sheet `own`; none if it has no
  // shadow.
  std::span<const HalfSpace> shadow(std::size_t sheet, std::size_t own) const;

 private:
  // The eye in homogeneous coordinates of the camera frame: a point (w = 1), or for parallel rays
  // the direction opposite to them (w = 0). The ray from a point x to the eye runs along
  // position - w x.
  struct Eye {
    Eigen::Vector3d position;
    double w = 1;

    Eigen::Vector3d towards_from(const Eigen::Vector3d& x) const { return position - w * x; }
  };

  int side(const Sheet& sheet) const;
  std::vector<HalfSpace> half_spaces(const Sheet& sheet, double lift_m) const;

  std::vector<Sheet> sheets_;
  std::vector<std::size_t> all_;
  Eye eye_;
  double tolerance_m_ = 0;
  // For each sheet, its shadow on sheets above it and on sheets below it in a common plane. The
  // first half-space is the one beyond the sheet.
  std::vector<std::array<std::vector<HalfSpace>, 2>> shadows_;
};

}  // namespace tagcal
