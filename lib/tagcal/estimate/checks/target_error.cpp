#include "tagcal/estimate/checks/target_error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "tagcal/camera/kernels/parameter_index.hpp"
#include "tagcal/estimate/findings/finding_codes.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/pose/reprojection.hpp"
#include "tagcal/estimate/pose/residual_test.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Jacobian of a pixel by its point, row-major because its rows are used.
using ByShift = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

constexpr std::size_t kTagsNamed = 3;  // in the sentence

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
  // The sums for residuals relative to the point after this shift.
  Sums after(const Vector3d& shift) const {
    Sums rest = *this;
    rest.gradient -= information * shift;
    rest.square -= 2 * gradient.dot(shift) - shift.dot(information * shift);
    return rest;
  }
  Vector3d shift() const {
    const double damping =
        policy::kTargetShiftDamping * information.trace() + 1e-300;  // numeric: no division by zero
    return (information + damping * Matrix3d::Identity()).ldlt().solve(gradient);
  }
  double explained(const Vector3d& shift) const {
    return std::max(0.0, 2 * gradient.dot(shift) - shift.dot(information * shift));
  }
  double square_px(const Vector3d& shift) const { return shift.dot(pixels * shift); }
};

struct Corner {
  CornerId id;
  Vector3d point;                    // of the target
  Vector3d from_centre = {0, 0, 0};  // of its tag, along `axes`; zero if unknown
  Sums inliers, outliers;
};

// Corners by id. Most views have them in the same order, so the next one is tried first.
class Corners {
 public:
  Corner& at(const CornerId& id, const Vector3d& point) {
    if (next_ < all_.size() && all_[next_].id == id) return all_[next_++];
    const auto [place, added] = index_.emplace(id, all_.size());
    if (added) all_.push_back({id, point});
    next_ = place->second + 1;
    return all_[place->second];
  }
  const std::vector<Corner>& all() const { return all_; }
  std::vector<Corner>& all() { return all_; }

 private:
  std::vector<Corner> all_;
  std::map<CornerId, std::size_t> index_;
  std::size_t next_ = 0;
};

// Reads the outliers one by one; they are in the order of the views and their corners.
class OutlierList {
 public:
  explicit OutlierList(const std::vector<Outlier>& all) : next_(all.begin()), end_(all.end()) {}

  bool take(std::size_t view, std::size_t corner) {
    if (next_ == end_ || next_->view != view || next_->corner != corner) return false;
    ++next_;
    return true;
  }

 private:
  std::vector<Outlier>::const_iterator next_, end_;
};

// Jacobian of a pixel by its point along `axes`, of a lens without distortion.
class PixelByShift {
 public:
  PixelByShift(const Lens& lens, const Pose& camera_from_world, const Matrix3d& axes)
      : turned_(camera_from_world.rotation().toRotationMatrix() * axes),
        rotation_(camera_from_world.rotation().toRotationMatrix()),
        translation_(camera_from_world.translation()),
        focal_(parameters(lens)[kFx], parameters(lens)[kFy]) {}

  bool at(const Vector3d& point, ByShift& by_shift) const {
    const Vector3d x = rotation_ * point + translation_;
    if (!(x.z() > 0 && x.z() * x.z() > policy::kTargetLeastCosine * policy::kTargetLeastCosine *
                                           x.squaredNorm()))
      return false;
    const double nearness = 1 / x.z();
    for (int i = 0; i < 2; ++i)
      by_shift.row(i) = focal_[i] * nearness * (turned_.row(i) - x[i] * nearness * turned_.row(2));
    return true;
  }

 private:
  Matrix3d turned_, rotation_;
  Vector3d translation_;
  Vector2d focal_;
};

struct Total {
  int count = 0, corners = 0;
  double square = 0, explained = 0;  // in units of the corners' noise
  double shifted_px2 = 0;            // of the inliers, by the shifts
};

Corners sums_of(const CalibrationInput& input, const CalibrationFit& fit, const Matrix3d& axes,
                Total& total) {
  Corners corners;
  ViewProblem bent;
  OutlierList outliers(fit.outliers);
  const Lens lens = fit.bundle.lens();
  std::size_t used = 0;
  ByShift by_shift;
  for (const CalibrationView& view : input.views) {
    if (used == fit.views.size() || fit.views[used] != view.index) {
      for (const std::size_t corner : view.corners) outliers.take(view.index, corner);
      continue;
    }
    const Pose& camera_from_world = fit.bundle.camera_from_target[used++];
    const auto residuals =
        residuals_px(fit.bundle.bent(view.problem, bent).correspondences, lens, camera_from_world);
    const PixelByShift pixel_by_shift(lens, camera_from_world, axes);
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const bool out = outliers.take(view.index, view.corners[i]);
      if (!residuals[i].allFinite() ||
          !pixel_by_shift.at(view.problem.correspondences[i].point, by_shift))
        continue;
      const auto& whitening = view.problem.whitening;
      Corner& corner = corners.at(view.ids[i], view.problem.correspondences[i].point);
      Sums& sums = out ? corner.outliers : corner.inliers;
      // Observed minus projected, so that the shifts are the target's.
      sums.add(by_shift, -residuals[i], whitening.empty() ? nullptr : &whitening[i]);
      total.count += !out;
    }
  }
  return corners;
}

// Fills in the offset of each corner from the centre of its tag, for tags with all four corners.
void set_offsets_from_centre(Corners& corners, const Matrix3d& axes) {
  std::map<int, std::vector<Corner*>> tags;
  for (Corner& corner : corners.all()) tags[corner.id.tag_id].push_back(&corner);
  for (const auto& [id, of_tag] : tags) {
    if (of_tag.size() != 4) continue;
    Vector3d centre = Vector3d::Zero();
    for (const Corner* corner : of_tag) centre += corner->point / 4;
    for (Corner* corner : of_tag) corner->from_centre = axes.transpose() * (corner->point - centre);
  }
}

// A common scale of all tags about their centres, fitted to the residuals of the inliers.
struct TagScale {
  double change = 0;      // of the size: 0.01 is 1 % larger than in the file
  double sigma = 0;       // for noise of 1
  double shifted_px = 0;  // RMS over the inliers
};

TagScale tag_scale(const Corners& corners) {
  double information = 0, gradient = 0, square_px = 0;
  int count = 0;
  for (const Corner& corner : corners.all()) {
    const Sums& sums = corner.inliers;
    information += corner.from_centre.dot(sums.information * corner.from_centre);
    gradient += corner.from_centre.dot(sums.gradient);
    square_px += sums.square_px(corner.from_centre);
    count += sums.count;
  }
  if (!(information > 0)) return {};
  const double change = gradient / information;
  return {change, 1 / std::sqrt(information),
          std::abs(change) * std::sqrt(square_px / std::max(1, count))};
}

// Removes the scale from the sums, unless it is larger than a printer or a detector can cause.
void remove_scale(const TagScale& scale, Corners& corners, Total& total) {
  const bool is_possible = std::abs(scale.change) < policy::kLargestTagScale;
  for (Corner& corner : corners.all()) {
    if (is_possible) {
      corner.inliers = corner.inliers.after(scale.change * corner.from_centre);
      corner.outliers = corner.outliers.after(scale.change * corner.from_centre);
    }
    total.square += corner.inliers.square;
  }
}

// The shift of a tag, from those of its corners.
struct TagShift {
  int tag_id = 0;
  int corners = 0;
  double square_m = 0;
  double explained = 0;
  bool rejected = false;  // in most views

  double mm() const { return 1e3 * std::sqrt(square_m / std::max(1, corners)); }
};

std::vector<TagShift> tags_of(const Corners& corners, Total& total) {
  std::map<int, TagShift> tags;
  for (const Corner& corner : corners.all()) {
    const bool out = corner.outliers.count > corner.inliers.count;
    const Sums& sums = out ? corner.outliers : corner.inliers;
    if (sums.count < policy::kTargetFewestViews) continue;
    const Vector3d shift = sums.shift();
    const double explained = sums.explained(shift);
    if (out && explained < policy::kOneShiftShare * sums.square) continue;
    TagShift& tag = tags[corner.id.tag_id];
    tag.tag_id = corner.id.tag_id;
    ++tag.corners;
    tag.square_m += shift.squaredNorm();
    tag.explained += explained;
    tag.rejected |= out;
    if (out) continue;
    ++total.corners;
    total.explained += explained;
    total.shifted_px2 += sums.square_px(shift);
  }
  std::vector<TagShift> all;
  for (const auto& [id, tag] : tags) all.push_back(tag);
  std::sort(all.begin(), all.end(),
            [](const TagShift& a, const TagShift& b) { return a.mm() > b.mm(); });
  return all;
}

bool is_outlying(const TagShift& tag, double median_mm, double variance, int dimensions) {
  return tag.explained >
             variance * chi_square_quantile(dimensions * tag.corners, policy::kTargetQuantile) &&
         tag.mm() > policy::kOutlyingTagRatio * median_mm;
}

std::string sentence_of(const std::vector<MisplacedTag>& tags) {
  std::string text = "the target is not as its file says: ";
  for (std::size_t i = 0; i < std::min(kTagsNamed, tags.size()); ++i) {
    char part[64];
    std::snprintf(part, sizeof part, "%stag %d is displaced by %.2g mm", i > 0 ? ", " : "",
                  tags[i].tag_id, tags[i].shift_mm);
    text += part;
  }
  if (tags.size() > kTagsNamed)
    text += ", and " + std::to_string(tags.size() - kTagsNamed) + " more tags";
  return text + "; measure them, and correct the file or print the target again";
}

// The finding that all tags have another size than in the file, relative to their spacing.
std::optional<Finding> scale_finding(const TagScale& scale, double variance) {
  const double sigma = scale.sigma * std::sqrt(variance);
  if (!(std::abs(scale.change) > policy::kTargetQuantile * sigma &&
        scale.shifted_px > policy::kLeastBiasPx &&
        std::abs(scale.change) < policy::kLargestTagScale))
    return std::nullopt;
  char text[250];
  std::snprintf(text, sizeof text,
                "all tags look %.2g %% %s relative to their spacing than in the target's file "
                "(%.2g px): ink or light shifted their edges, or another detector found the "
                "corners; check tagSize and tagSpacing",
                100 * std::abs(scale.change), scale.change < 0 ? "smaller" : "larger",
                scale.shifted_px);
  return finding(code::tag_scale, text);
}

}  // namespace

std::optional<TargetError> target_error(const CalibrationInput& input, const CalibrationFit& fit,
                                        const FlatBoard* board) {
  if (std::ssize(fit.views) < policy::kTargetFewestViews) return std::nullopt;
  Matrix3d axes = Matrix3d::Identity();
  if (board) {
    axes = board->world_from_board.rotation().toRotationMatrix();
    axes.col(2).setZero();
  }
  const int dimensions = board ? 2 : 3;
  Total total;
  Corners corners = sums_of(input, fit, axes, total);
  set_offsets_from_centre(corners, axes);
  const TagScale scale = tag_scale(corners);
  remove_scale(scale, corners, total);
  const std::vector<TagShift> tags = tags_of(corners, total);
  const int k = dimensions * total.corners;
  const double lost = 6.0 * static_cast<double>(fit.views.size());
  const double rest = 2 * total.count - k - lost;
  if (tags.empty() || rest < k) return std::nullopt;
  const double least_noise = input.whitened ? 1 : policy::kLeastSigmaPx;
  const double variance =
      std::max((total.square - total.explained) / rest, least_noise * least_noise);
  const double excess = std::max(0.0, total.explained - k * variance);

  TargetError error;
  error.share = total.square > 0 ? excess / total.square : 0;
  const double share_of_shifts = total.explained > 0 ? excess / total.explained : 0;
  error.shift_px = std::sqrt(share_of_shifts * total.shifted_px2 / std::max(1, total.count));
  const bool all = error.share > policy::kTargetShareFound &&
                   error.shift_px > policy::kTargetShiftFoundPx &&
                   total.explained > variance * chi_square_quantile(k, policy::kTargetQuantile);
  const double median_mm = tags[tags.size() / 2].mm();
  std::size_t wrong = 0;
  for (const TagShift& tag : tags) {
    const bool outlying = tag.rejected || is_outlying(tag, median_mm, variance, dimensions);
    wrong += outlying;
    if (outlying || (all && 2 * tag.mm() > tags[0].mm()))
      error.tags.push_back({tag.tag_id, tag.mm()});
  }
  error.gross =
      (all && error.share > policy::kTargetShareRefused &&
       error.shift_px > policy::kTargetShiftRefusedPx) ||
      static_cast<double>(wrong) > policy::kTagsShareRefused * static_cast<double>(tags.size());
  if (!error.tags.empty())
    error.tags_misplaced = finding(code::tags_misplaced, sentence_of(error.tags));
  error.tag_scale = scale_finding(scale, variance);
  if (!error.tags_misplaced && !error.tag_scale) return std::nullopt;
  return error;
}

}  // namespace tagcal::internal
