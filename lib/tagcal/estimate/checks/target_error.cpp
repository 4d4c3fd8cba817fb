#include "tagcal/estimate/checks/target_error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "tagcal/camera/batch.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/solvers/numeric/statistics.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Jacobian of a pixel by its point, row-major because its rows are used.
using ByShift = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

// The normal equations of one shift, in units of the corners' noise, and their matrix in pixels.
struct Sums {
  int count = 0;
  Matrix3d information = Matrix3d::Zero();
  Matrix3d pixels = Matrix3d::Zero();
  Vector3d gradient = Vector3d::Zero();
  double square = 0;  // of the residuals

  // `whitening` may be null.
  void add(const ByShift& by_shift, const Vector2d& residual, const Matrix2* whitening) {
    ++count;
    const ByShift white = whitening ? ByShift(*whitening * by_shift) : by_shift;
    const Vector2d r = whitening ? Vector2d(*whitening * residual) : residual;
    information.noalias() += white.transpose() * white;
    pixels.noalias() += by_shift.transpose() * by_shift;
    gradient.noalias() += white.transpose() * r;
    square += r.squaredNorm();
  }
  // Makes the residuals relative to the point after this shift.
  void move(const Vector3d& shift) {
    square -= explained(shift);
    gradient -= information * shift;
  }
  Vector3d shift() const {
    // Damps the line of sight, which the views do not determine, and keeps from a division by zero.
    const double damping = 1e-3 * information.trace() + 1e-300;  // numeric: see above
    return (information + damping * Matrix3d::Identity()).ldlt().solve(gradient);
  }
  double explained(const Vector3d& shift) const {
    return 2 * gradient.dot(shift) - shift.dot(information * shift);
  }
};

struct Corner {
  Vector3d point;                           // of the target
  Vector3d from_centre = Vector3d::Zero();  // of its tag, along `axes`; zero if unknown
  Sums inliers, outliers;
};
using Corners = std::map<CornerId, Corner>;

// Adds a view, whose pose is that of the fit, to the sums of its corners.
void add_view(Corners& corners, const CalibrationView& view, const ViewProblem& problem,
              const Lens& lens, const Pose& camera_from_world, const Matrix3d& axes,
              const std::vector<std::uint8_t>& inlier) {
  const ViewArrays arrays(problem);
  const std::size_t n = view.ids.size();
  std::vector<Vector2d> pixels(n);
  std::vector<std::uint8_t> valid(n);
  std::vector<double> by_pose(12 * n);
  project_with_jacobians(lens, camera_from_world, arrays.view().points, {},
                         {pixels, valid, by_pose});
  const Matrix3d turned = camera_from_world.rotation().toRotationMatrix() * axes;
  auto hint = corners.begin();
  for (std::size_t i = 0; i < n; ++i) {
    if (!valid[i]) continue;
    const Vector3d& point = view.problem.correspondences[i].point;
    hint = corners.try_emplace(hint, view.ids[i], Corner{point});
    Corner& corner = hint++->second;
    // The last three of six columns are by the translation. Observed minus projected, so that the
    // shifts are the target's.
    const Eigen::Map<const Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> rows(&by_pose[12 * i]);
    (inlier[i] ? corner.inliers : corner.outliers)
        .add(rows.rightCols<3>() * turned, arrays.view().pixels[i] - pixels[i],
             problem.whitening.empty() ? nullptr : &problem.whitening[i]);
  }
}

Corners sums_of(const CalibrationInput& input, const CalibrationFit& fit, const Matrix3d& axes) {
  const std::optional<FlatBoard>& board = fit.bundle.board;
  Corners corners;
  ViewProblem bent;
  const Lens lens = fit.bundle.lens();
  // With several boards the rows stay as observed: row terms take up what a board at a wrong place
  // does to each view.
  const bool has_rows = board && !fit.bundle.row_terms.empty();
  for (std::size_t i = 0; i < fit.used.size(); ++i) {
    const CalibrationView& view = input.views[fit.used[i]];
    const Vector6d rows = has_rows ? fit.bundle.row_terms[i] : Vector6d(Vector6d::Zero());
    add_view(corners, view, fit.bundle.corrected(view.problem, rows, bent), lens,
             fit.bundle.camera_from_target[i], axes, fit.selection.inlier[fit.used[i]]);
  }
  return corners;
}

// Fills in the offset of each corner from the centre of its tag, for tags with all four corners.
void set_offsets_from_centre(Corners& corners, const Matrix3d& axes) {
  for (auto first = corners.begin(); first != corners.end();) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    auto end = first;
    for (; end != corners.end() && end->first.tag_id == first->first.tag_id; ++end, ++count)
      sum += end->second.point;
    for (; first != end; ++first)
      if (count == 4)
        first->second.from_centre = axes.transpose() * (first->second.point - sum / 4);
  }
}

// Fits a common scale of all tags about their centres to the residuals of the inliers, and removes
// it, unless it is larger than a printer or a detector can cause.
struct TagScale {
  double change = 0;      // of the size: 0.01 is 1 % larger than in the file
  double sigma = 0;       // for noise of 1
  double shifted_px = 0;  // RMS over the inliers
};

TagScale remove_scale(Corners& corners) {
  double information = 0, gradient = 0, square_px = 0;
  int count = 0;
  for (const auto& [id, corner] : corners) {
    const Sums& sums = corner.inliers;
    information += corner.from_centre.dot(sums.information * corner.from_centre);
    gradient += corner.from_centre.dot(sums.gradient);
    square_px += corner.from_centre.dot(sums.pixels * corner.from_centre);
    count += sums.count;
  }
  const double change = information > 0 ? gradient / information : 0;
  if (change == 0 || std::abs(change) > policy::kLargestTagScale) return {};
  for (auto& [id, corner] : corners) {
    corner.inliers.move(change * corner.from_centre);
    corner.outliers.move(change * corner.from_centre);
  }
  return {change, 1 / std::sqrt(information), std::abs(change) * std::sqrt(square_px / count)};
}

// The chi-square that `k` coordinates without an error exceed hardly ever.
double largest_chi_square(int k) { return chi_square_quantile(k, policy::kOutlierSigmas); }

// The shift of a tag, from those of its corners.
struct TagShift {
  int tag_id = 0;
  int corners = 0;
  double square_m = 0;
  double explained = 0;
  bool rejected = false;  // in most views

  double mm() const { return 1e3 * std::sqrt(square_m / std::max(1, corners)); }
  bool is_outlying(int dimensions, double variance, double median_mm) const {
    return rejected || (explained > variance * largest_chi_square(dimensions * corners) &&
                        mm() > policy::kOutlierSigmas * median_mm);
  }
};

// Sums over the inliers of all corners.
struct Total {
  int count = 0;
  int shifted = 0;                   // corners with a shift
  double square = 0, explained = 0;  // in units of the corners' noise
  double shifted_px2 = 0;            // by the shifts
};

// The tags by the size of their shifts, the largest first.
std::vector<TagShift> tags_of(const Corners& corners, Total& total) {
  std::map<int, TagShift> tags;
  for (const auto& [id, corner] : corners) {
    total.count += corner.inliers.count;
    total.square += corner.inliers.square;
    const bool out = corner.outliers.count > corner.inliers.count;
    const Sums& sums = out ? corner.outliers : corner.inliers;
    if (sums.count < policy::kFewestComparedViews) continue;
    const Vector3d shift = sums.shift();
    const double explained = std::max(0.0, sums.explained(shift));
    if (out && explained < policy::kMostOfResiduals * sums.square) continue;
    TagShift& tag = tags[id.tag_id];
    tag.tag_id = id.tag_id;
    ++tag.corners;
    tag.square_m += shift.squaredNorm();
    tag.explained += explained;
    tag.rejected |= out;
    if (out) continue;
    ++total.shifted;
    total.explained += explained;
    total.shifted_px2 += shift.dot(sums.pixels * shift);
  }
  std::vector<TagShift> all;
  for (const auto& [id, tag] : tags) all.push_back(tag);
  std::ranges::sort(all, std::greater(), &TagShift::mm);
  return all;
}

std::string sentence_of(const std::vector<TagShift>& tags) {
  constexpr std::size_t kTagsNamed = 3;
  std::string text = "the target is not as its file says: ";
  for (std::size_t i = 0; i < std::min(kTagsNamed, tags.size()); ++i)
    text += (i > 0 ? ", tag " : "tag ") + std::to_string(tags[i].tag_id) + " is displaced by " +
            with_digits(tags[i].mm(), 2) + " mm";
  if (tags.size() > kTagsNamed)
    text += ", and " + std::to_string(tags.size() - kTagsNamed) + " more tags";
  return text + "; measure them, and correct the file or print the target again";
}

// The finding that all tags have another size than in the file, relative to their spacing.
std::optional<Finding> scale_finding(const TagScale& scale, double variance) {
  if (!(std::abs(scale.change) > policy::kOutlierSigmas * scale.sigma * std::sqrt(variance) &&
        scale.shifted_px > policy::kLeastSigmaPx))
    return std::nullopt;
  return finding(code::tag_scale,
                 "all tags look " + with_digits(100 * std::abs(scale.change), 2) + " % " +
                     (scale.change < 0 ? "smaller" : "larger") +
                     " relative to their spacing than in the target's file (" +
                     with_digits(scale.shifted_px, 2) +
                     " px): ink or light shifted their edges, or another detector found the "
                     "corners; check tagSize and tagSpacing");
}

// The axes along which a corner may be displaced: those of a flat board's plane.
Matrix3d axes_of(const std::optional<FlatBoard>& board) {
  if (!board) return Matrix3d::Identity();
  Matrix3d axes = board->world_from_board.rotation().toRotationMatrix();
  axes.col(2).setZero();
  return axes;
}

}  // namespace

std::optional<TargetError> target_error(const CalibrationInput& input, const CalibrationFit& fit) {
  if (std::ssize(fit.used) < policy::kFewestComparedViews) return std::nullopt;
  const Matrix3d axes = axes_of(fit.bundle.board);
  const int dimensions = fit.bundle.board ? 2 : 3;
  Corners corners = sums_of(input, fit, axes);
  set_offsets_from_centre(corners, axes);
  const TagScale scale = remove_scale(corners);
  Total total;
  std::vector<TagShift> tags = tags_of(corners, total);
  const int k = dimensions * total.shifted;
  const double rest = 2 * total.count - k - 6.0 * static_cast<double>(fit.used.size());
  if (tags.empty() || rest < k) return std::nullopt;
  const double least_noise = input.whitened ? 1 : policy::kLeastSigmaPx;
  const double variance =
      std::max((total.square - total.explained) / rest, least_noise * least_noise);
  const double excess = std::max(0.0, total.explained - k * variance);

  TargetError error;
  error.share = total.square > 0 ? excess / total.square : 0;
  const double share_of_shifts = total.explained > 0 ? excess / total.explained : 0;
  const double shift_px = std::sqrt(share_of_shifts * total.shifted_px2 / std::max(1, total.count));
  const bool all = error.share > policy::kTargetShareFound &&
                   shift_px > policy::kTargetShiftFoundPx &&
                   total.explained > variance * largest_chi_square(k);
  const double median_mm = tags[tags.size() / 2].mm(), largest_mm = tags[0].mm();
  const auto is_outlying = [&](const TagShift& tag) {
    return tag.is_outlying(dimensions, variance, median_mm);
  };
  const auto wrong = static_cast<std::size_t>(std::ranges::count_if(tags, is_outlying));
  error.gross = (all && error.share > policy::kMostOfResiduals &&
                 shift_px > 2 * policy::kTargetShiftFoundPx) ||
                policy::is_above(wrong, policy::kMinority, tags.size());
  std::erase_if(tags, [&](const TagShift& tag) {
    return !is_outlying(tag) && !(all && 2 * tag.mm() > largest_mm);
  });
  if (!tags.empty()) error.tags_misplaced = finding(code::tags_misplaced, sentence_of(tags));
  error.tag_scale = scale_finding(scale, variance);
  if (!error.tags_misplaced && !error.tag_scale) return std::nullopt;
  return error;
}

}  // namespace tagcal::internal
