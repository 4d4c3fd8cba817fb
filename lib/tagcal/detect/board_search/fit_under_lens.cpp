#include "tagcal/detect/board_search/fit_under_lens.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "tagcal/detect/board_search/panel_lens.hpp"
#include "tagcal/detect/board_search/placed_tag.hpp"
#include "tagcal/detect/board_search/rough_lens_error.hpp"
#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/quad.hpp"
#include "tagcal/scene/surfaces.hpp"

namespace tagcal::internal {
namespace {

using namespace policy;

// numeric: weights of fitted corners and of straight sides in the estimate of the lens, px; no
// picture of docs/trust/sensitivity.md depends on them
constexpr double kFittedSdPx = 0.1;
constexpr double kSidesSdPx = 1;
constexpr int kMaxRounds = 8;  // of lens and tags in turn, as a limit of work

struct PanelTag {
  FoundTag* found = nullptr;
  Quad on_panel;
  bool is_plain = false;    // fitted without a lens
  bool is_by_lens = false;  // fitted under the lens of the last round
  double last_move = std::numeric_limits<double>::infinity();  // in standard deviations
};

// Largest move of a coordinate, in its standard deviations.
double move_in_sds(const Quad& from, const FoundTag& to) {
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (int k = 0; k < 2; ++k) {
      const Eigen::Index at = 2 * static_cast<Eigen::Index>(i) + k;
      largest = std::max(
          largest, std::abs(to.corners[i][k] - from[i][k]) / std::sqrt(to.covariance_px2(at, at)));
    }
  return largest;
}

// Fits the found tags of one panel again under the lens estimated from all of them.
class PanelRefinement {
 public:
  PanelRefinement(const ImageView8& image, const FamilyDetector& detector, const BoardPanel& panel,
                  const std::map<int, FoundTag*>& found)
      : image_(image), detector_(detector) {
    const Pose panel_from_board = panel.tags.front().board_from_tag.inverse();
    for (const Tag& tag : panel.tags) {
      const auto it = found.find(tag.id);
      if (it == found.end()) continue;
      const bool is_plain = it->second->fitted && !it->second->rough_camera;
      tags_.push_back({it->second, on_panel(tag, panel_from_board), is_plain});
      before_.push_back(*it->second);
    }
  }

  void run() {
    for (int round = 0; round < kMaxRounds && !has_converged(); ++round) {
      lens_ = lens_of_panel(corners(), image_.size(), lens_ ? &*lens_ : nullptr);
      if (!lens_) break;
      for (PanelTag& tag : tags_)
        if (!has_converged(tag)) fit(tag);
    }
    for (std::size_t i = 0; i < tags_.size(); ++i)
      if (!tags_[i].is_plain && !is_finished(tags_[i])) *tags_[i].found = without_lens(before_[i]);
  }

 private:
  // True if the fit is final; adds the uncertainty of the lens to its covariance.
  bool is_finished(PanelTag& tag) const {
    if (!(tag.last_move < kConvergedSds) || !is_explained(tag)) return false;
    const auto by_lens = covariance_by_lens(*lens_, tag.found->corners);
    if (!by_lens) return false;
    tag.found->covariance_px2 += *by_lens;
    return true;
  }

  // True if the lens projects the tag's corners to where they were fitted.
  bool is_explained(const PanelTag& tag) const {
    const auto expected = predicted(tag);
    if (!expected) return false;
    const double spread_px = kFittedSdPx * lens_->spread;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto at = static_cast<Eigen::Index>(2 * i);
      const double variance =
          spread_px * spread_px + tag.found->covariance_px2.block<2, 2>(at, at).trace() / 2;
      if ((tag.found->corners[i] - (*expected)[i]).squaredNorm() >
          kOutlierSds * kOutlierSds * variance)
        return false;
    }
    return true;
  }

  // The tag, fitted corner by corner if it only had a start.
  FoundTag without_lens(const FoundTag& tag) const {
    if (!tag.by_corner && !tag.rough_camera) return tag;
    const auto fitted = detector_.refined(image_, tag.id, tag.corners, false);
    if (fitted && is_face(fitted->corners) && is_whole(*fitted, image_.size())) return *fitted;
    FoundTag unfitted = tag;
    unfitted.fitted = false;
    return unfitted;
  }

  static bool has_converged(const PanelTag& tag) {
    return tag.is_plain || tag.last_move < kConvergedSds;
  }
  bool has_converged() const {
    return std::ranges::all_of(tags_, [](const PanelTag& tag) { return has_converged(tag); });
  }

  std::vector<PanelCorner> corners() const {
    std::vector<PanelCorner> corners;
    for (const PanelTag& tag : tags_)
      for (std::size_t i = 0; i < 4; ++i)
        corners.push_back({tag.on_panel[i], tag.found->corners[i],
                           tag.found->fitted || tag.found->by_corner ? kFittedSdPx : kSidesSdPx});
    return corners;
  }

  std::optional<Quad> predicted(const PanelTag& tag) const {
    return mapped(tag.on_panel, [&](const Eigen::Vector2d& x) { return lens_->pixel(x); });
  }

  // True if the lens has changed so little since the tag was fitted that the fit would not move.
  bool stays(PanelTag& tag) const {
    if (!tag.is_by_lens) return false;
    const auto moves =
        bias_between(tag.found->rough_camera->lens, lens_->camera.lens, tag.found->corners);
    if (!moves) return false;
    const auto sds = tag.found->covariance_px2.diagonal().cwiseSqrt();
    const double largest = moves->cwiseQuotient(sds).cwiseAbs().maxCoeff();
    if (largest < kConvergedSds) tag.last_move = largest;
    return largest < kConvergedSds;
  }

  // Fits a tag under the present lens: from its corners or, as straight sides may be far off, from
  // their projections.
  void fit(PanelTag& tag) const {
    if (stays(tag)) return;
    std::optional<FoundTag> fitted = fitted_from(*tag.found, tag.found->corners);
    if (!fitted && !tag.found->fitted)
      if (const auto start = predicted(tag)) fitted = fitted_from(*tag.found, *start);
    tag.last_move = fitted && tag.is_by_lens ? move_in_sds(tag.found->corners, *fitted)
                                             : std::numeric_limits<double>::infinity();
    tag.is_by_lens = fitted.has_value();
    if (fitted) *tag.found = *fitted;
  }

  std::optional<FoundTag> fitted_from(const FoundTag& tag, const Quad& start) const {
    FoundTag fitted = tag;
    fitted.corners = start;
    if (!is_inside(start, image_.size(), 0)) return std::nullopt;
    if (!detector_.fit_roughly(fitted, image_, lens_->camera)) return std::nullopt;
    if (!is_face(fitted.corners) || !is_whole(fitted, image_.size())) return std::nullopt;
    return fitted;
  }

  ImageView8 image_;
  const FamilyDetector& detector_;
  std::vector<PanelTag> tags_;
  std::vector<FoundTag> before_;
  std::optional<PanelLens> lens_;
};

}  // namespace

void fit_under_lens(const ImageView8& image, const Board& board, const FamilyDetector& detector,
                    Completion& completion) {
  if (!tag_kind(board)) return;
  std::map<int, FoundTag*> found;
  for (FoundTag& tag : completion.tags) found[tag.id] = &tag;
  for (const BoardPanel& panel : board_panels(board, 0))
    PanelRefinement(image, detector, panel, found).run();
}

}  // namespace tagcal::internal
