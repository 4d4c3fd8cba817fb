#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tagcal/scene/visibility/sheets.hpp"
#include "tagcal/viewing/clip.hpp"

// What the sheets of a scene hide from an eye; the exact corners, the renderer and the drawings
// share it, so that they agree.

namespace tagcal::internal {

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

  Shadows(const Scene& scene, const Lens& lens, const Pose& camera_from_world);

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
  // Of each sheet, on those that would lie on it and on those that would lie below it in a common
  // plane. The first half-space is the one beyond the sheet.
  std::vector<std::array<std::vector<HalfSpace>, 2>> shadows_;
};

}  // namespace tagcal::internal
