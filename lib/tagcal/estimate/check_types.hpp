#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

// Options and results of check_camera and check_rig (check_camera.hpp).

namespace tagcal {

struct CheckOptions {
  // The change that matters, px > 0: of CameraCheck::smallest_px beyond it the verdict is
  // cannot_tell.
  double limit_px = 1;
  int max_iterations = 50;
  std::size_t num_threads = 1;  // 0: one per core; the answer does not depend on it
};

// The kinds of change of a camera, the leanest first.
enum class ChangeKind {
  focal_length,      // both focal lengths by the same share
  principal_point,   // (cx, cy)
  focal_and_centre,  // both
  place,             // of the camera in its rig
  lens,              // all parameters of the lens
};
std::string_view kind_name(ChangeKind kind);  // "focal length", "principal point", ..

// A parameter now less what the camera says. Its standard deviation is by the pictures and by the
// camera's covariance.
struct ParameterChange {
  std::string name;  // fx, cx, k1, ..; of a place rx, ry, rz (rad), tx, ty, tz (m): `retract`
  double known = 0;  // what the camera says; 0 of a place
  double change = 0;
  double sigma = 0;
};

struct ChangedPart {
  std::size_t camera = 0;  // index in the rig; 0 for one camera
  ChangeKind kind = ChangeKind::lens;
};

// The leanest change that explains the pictures: what remains is not significant.
struct CameraChange {
  std::size_t camera = 0;  // index in the rig; 0 for one camera
  ChangeKind kind = ChangeKind::lens;
  std::vector<ParameterChange> parameters;
  // By how much it moves a projection where these pictures have corners: of a lens at infinity less
  // a rotation of the camera (projection_uncertainty.hpp), of a place the corners themselves.
  double rms_px = 0;
  double max_px = 0;
  std::vector<ChangedPart> as_well;  // other changes, without this one, that also explain them
};

// The smallest change of one kind that these pictures would have shown with the probability
// CameraCheck::power: of any combination of its parameters the one that shows least.
struct DetectableChange {
  std::size_t camera = 0;
  ChangeKind kind = ChangeKind::lens;
  double max_px = 0;  // as CameraChange::max_px; infinite if nothing of it shows
  // For the place in a rig of two cameras: max_px without the part that is a change of all lengths
  // alike, which another print of the board makes as well. Else max_px.
  double without_scale_px = 0;
  // Its size: px of the focal length (fx) or of the principal point; mm of a place, whose rotation
  // is that of the same pixels; 0 for the others.
  double size = 0;
  // The change itself, with either sign: of the free parameters of the lens, or (omega rad, tau m)
  // of a place.
  std::vector<double> step;
};

// A camera of the check, or a rig's.
struct CheckedCamera {
  std::string name;
  int num_views = 0;  // that take part
  int num_corners = 0;
  double sigma_px = 0;  // noise per coordinate that the residuals of the free camera show
  // RMS of the residuals, each picture with its own pose: with the free camera, and with the camera
  // as it was calibrated.
  double rms_px = 0;
  double known_rms_px = 0;
};

struct CameraCheck {
  CheckVerdict verdict = CheckVerdict::cannot_tell;
  // The test: the normal score of the likelihood ratio, a quantile of the standard normal
  // distribution exceeded with the same probability; 0 +- 1 if nothing changed. Minus infinity
  // without a test.
  double in_sigmas = 0;
  double false_alarm = 0;  // probability of `changed` if nothing changed
  double power = 0;        // with which the changes of `detectable` are found
  // With verdict changed: no value if no single kind explains the pictures.
  std::optional<CameraChange> change;
  std::vector<DetectableChange> detectable;  // of each camera and kind
  // The largest max_px of them but for the whole lens: focus, zoom and blows change the focal
  // length, the principal point and the place, and no one combination of all coefficients. Infinite
  // without a test.
  double smallest_px = 0;
  std::vector<CheckedCamera> cameras;
  std::vector<Finding> findings;
};

}  // namespace tagcal
