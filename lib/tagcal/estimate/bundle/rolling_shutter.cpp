#include "tagcal/estimate/bundle/rolling_shutter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tagcal/estimate/bundle/observability.hpp"
#include "tagcal/estimate/bundle/shape_columns.hpp"
#include "tagcal/estimate/policy/policy.hpp"
#include "tagcal/estimate/policy/shutter_policy.hpp"

namespace tagcal::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kDegree = 7;  // of the polynomial of the pixel that views share
constexpr Index kNumTerms = (kDegree + 1) * (kDegree + 2) / 2;
constexpr Index kNumEffects = 12;  // of a view: velocities by row and by column
constexpr Index kNumCommon = 2 * kNumTerms + kNumShapes;  // of all views: field and board
constexpr double kLeastSize = 0.02;                       // numeric: not distinct from none
constexpr double kFirstStep = 4, kLastStep = 1.5;  // numeric: of the search for the best size
constexpr double kHalf = 0.5;       // numeric: effects by column between none and those by row
constexpr int kRounds = 3;          // of solutions with velocities: to second order
constexpr double kSameSize = 0.01;  // numeric: a hundredth changes no claim

// The terms of a polynomial of two variables.
Eigen::Vector<double, kNumTerms> powers_of(const Vector2d& x) {
  Eigen::Vector<double, kNumTerms> terms;
  Index k = 0;
  double power = 1;
  for (int i = 0; i <= kDegree; ++i, power *= x.x()) {
    double term = power;
    for (int j = 0; i + j <= kDegree; ++j, term *= x.y()) terms[k++] = term;
  }
  return terms;
}

struct Effects {
  double log = -std::numeric_limits<double>::infinity();  // of the likelihood
  double size = 0;                                        // of those by row
  double row_sigma = 0;                                   // of the velocities by row, px a row
  double noise = 0;                                       // of a (whitened) coordinate
  double square = 0;  // of the residuals that neither effects nor the common field explain
};

// Restricted log-likelihoods of the effects' sizes. A size is the standard deviation of the
// displacement at the upper border (by rows) or the left one (by columns), over that of the noise.
class EffectLikelihood {
 public:
  explicit EffectLikelihood(const Bundle& solved) : size_(solved.image_size) {
    const Lens lens = solved.lens();
    for (std::size_t v = 0; v < solved.views.size(); ++v) add_view(solved, v, lens);
  }

  bool is_empty() const { return !(freedom_ > 0); }
  double square() const { return square_; }  // of all residuals

  // The highest likelihood of effects by row, and by column of this share of their size: uphill
  // from a size in steps of a factor, which fall to kLastStep; then a parabola's.
  Effects best_of(double share, double size, double step) const {
    const auto of_size = [&](double s) { return at(s, share * s); };
    Effects best = of_size(size);
    while (true) {
      const Effects smaller = of_size(best.size / step), larger = of_size(best.size * step);
      const Effects& next = larger.log > smaller.log ? larger : smaller;
      if (next.log > best.log && next.size > kLeastSize) {
        best = next;
      } else if (step > kLastStep) {
        step = std::sqrt(step);
      } else {
        const double bend = smaller.log - 2 * best.log + larger.log;
        if (!(bend < 0)) return best;
        const Effects peak =
            of_size(best.size * std::pow(step, (smaller.log - larger.log) / (2 * bend)));
        return peak.log > best.log ? peak : best;
      }
    }
  }

  Effects at(double by_row, double by_column) const {
    VectorXd scale(kNumEffects);
    scale << Vector6d::Constant(by_row), Vector6d::Constant(by_column);
    constexpr double kRidge = 1e-6;  // numeric: what poses take up of the common field, a corner
    MatrixXd common = common_;
    double volume = 0;
    for (const MatrixXd& gram : grams_) {
      MatrixXd effects =
          scale.asDiagonal() * gram.topLeftCorner(kNumEffects, kNumEffects) * scale.asDiagonal();
      effects.diagonal().array() += 1;
      const Eigen::LLT<MatrixXd> root(effects);
      const MatrixXd cross = root.matrixL().solve(scale.asDiagonal() *
                                                  gram.topRightCorner(kNumEffects, kNumCommon + 1));
      common.selfadjointView<Eigen::Lower>().rankUpdate(cross.transpose(), -1);
      volume += root.matrixLLT().diagonal().array().log().sum();
    }
    common.diagonal().head(kNumCommon).array() += kRidge * freedom_;
    // The last entry of the root is that of the residuals without the common field.
    const Eigen::LLT<MatrixXd> root(common);
    const VectorXd diagonal = root.matrixLLT().diagonal();
    const double square = std::max(
        1e-300, diagonal[kNumCommon] * diagonal[kNumCommon]);  // numeric: no logarithm of 0
    volume += diagonal.head(kNumCommon).array().log().sum();
    const double noise = std::sqrt(square / freedom_);
    return {-volume - freedom_ / 2 * std::log(square), by_row, 2 * by_row * noise / size_.height,
            noise, square};
  }

 private:
  // The products of the columns by effects, by the common field and of the residuals, less those
  // that the pose explains.
  void add_view(const Bundle& solved, std::size_t v, const Lens& lens) {
    ViewProblem buffer;
    const ViewProblem& view = solved.corrected(v, buffer);
    const auto seen = reprojection(view, lens, {}, solved.camera_from_target[v]);
    if (!seen) return;
    // The places of projected corners: those of observed ones have the noise of the residuals.
    const auto error_px = residuals_px(view.correspondences, lens, solved.camera_from_target[v]);
    const Vector2d centre = image_centre(size_);
    const ViewRowTerms twists = solved.row_prior(v);
    const Index n = seen->residuals.size();
    MatrixXd all = MatrixXd::Zero(n, kNumEffects + kNumCommon + 1);
    for (std::size_t i = 0; i < view.correspondences.size(); ++i) {
      const auto at = static_cast<Index>(2 * i);
      const Vector2d x = view.correspondences[i].pixel + error_px[i] - centre;
      const auto by_pose = (seen->by_pose.middleRows<2>(at) * *twists.velocities).eval();
      const Eigen::Matrix2d w =
          view.whitening.empty() ? Eigen::Matrix2d::Identity() : Eigen::Matrix2d(view.whitening[i]);
      all.block<2, 6>(at, 0) = 2 * x.y() / size_.height * by_pose;
      all.block<2, 6>(at, 6) = 2 * x.x() / size_.height * by_pose;
      const auto powers = powers_of(2 * x / size_.width);
      for (Index k = 0; k < kNumTerms; ++k)
        all.block<2, 2>(at, kNumEffects + 2 * k) = powers[k] * w;
    }
    if (solved.board) {
      const ViewArrays flat(solved.views[v]);
      const BoardShapes shapes = solved.board->shapes(flat.view().points);
      set_shape_columns(shapes.view(), solved.camera_from_target[v], seen->by_pose,
                        kNumEffects + 2 * kNumTerms, all);
    }
    all.rightCols<1>() = seen->residuals - size_.height / 2.0 * (all.leftCols<6>() * twists.start);
    const Matrix6 information = seen->by_pose.transpose() * seen->by_pose;
    const Eigen::LDLT<Matrix6> pose(information);
    all.noalias() -= seen->by_pose * pose.solve(seen->by_pose.transpose() * all);
    grams_.push_back(all.leftCols<kNumEffects>().transpose() * all);
    common_.selfadjointView<Eigen::Lower>().rankUpdate(all.rightCols<kNumCommon + 1>().transpose());
    square_ += all.rightCols<1>().squaredNorm();
    freedom_ += static_cast<double>(n - 6) - (grams_.size() == 1 ? kNumCommon : 0);
  }

  ImageSize size_;
  std::vector<MatrixXd> grams_;  // of the effects with all columns
  MatrixXd common_ = MatrixXd::Zero(kNumCommon + 1, kNumCommon + 1);  // lower triangle
  double freedom_ = 0, square_ = 0;
};

// As many views as show it, evenly: more are only work.
Bundle some_views_of(const Bundle& solved) {
  constexpr std::size_t kEnoughViews = 60;  // a limit of work
  Bundle some = solved.without_views();
  const std::size_t stride = 1 + (solved.views.size() - 1) / kEnoughViews;
  for (std::size_t v = 0; v < solved.views.size(); v += stride) {
    some.views.push_back(solved.views[v]);
    some.camera_from_target.push_back(solved.camera_from_target[v]);
  }
  return some;
}

}  // namespace

double rolling_sigma_of(const Bundle& solved, int max_iterations, std::size_t num_threads) {
  if (std::ssize(solved.views) < policy::kFewestTellingViews) return 0;
  Bundle rolling = some_views_of(solved);
  rolling.rolling_m = median_distance_m(rolling);
  const EffectLikelihood still(rolling);
  if (still.is_empty()) return 0;
  const Effects of_rows = still.best_of(0, 1, kFirstStep);
  const Effects none = still.at(0, 0);
  if (!(of_rows.log > none.log + policy::kRollingGain)) return 0;
  // A model that is much too small: what its lens leaves is no field of the pixel alone.
  if (still.square() - none.square > none.square - of_rows.square) return 0;
  // The lens and the poses that belong to the velocities: a still camera's are off by what moved.
  Effects best = of_rows;
  double gain = 0;
  for (int round = 0; round < kRounds; ++round) {
    rolling.row_sigma = best.row_sigma;
    rolling.sigma = best.noise;
    solve(rolling, max_iterations, num_threads);
    const EffectLikelihood moving(rolling);
    if (moving.is_empty()) return 0;
    const Effects rows_only = moving.best_of(0, best.size, kLastStep);
    const Effects rows_more = moving.best_of(kHalf, best.size, kLastStep);
    best = rows_only.log > rows_more.log ? rows_only : rows_more;
    gain = best.log - moving.best_of(1, best.size, kLastStep).log;
    if (std::abs(best.row_sigma - rolling.row_sigma) < kSameSize * best.row_sigma) break;
  }
  return gain > policy::kRollingGain ? best.row_sigma : 0;
}

std::vector<double> row_motions_px(const Bundle& solved) {
  const Lens lens = solved.lens();
  std::vector<double> result;
  Bundle still = solved;
  still.row_terms.assign(solved.views.size(), Vector6d::Zero());
  ViewProblem buffer;
  for (std::size_t v = 0; v < solved.views.size(); ++v) {
    const Pose& pose = solved.camera_from_target[v];
    const auto moved = residuals_px(solved.corrected(v, buffer).correspondences, lens, pose);
    const auto middle = residuals_px(still.corrected(v, buffer).correspondences, lens, pose);
    double largest = 0;
    for (std::size_t i = 0; i < moved.size(); ++i)
      largest = std::max(largest, (moved[i] - middle[i]).norm());
    result.push_back(largest);
  }
  return result;
}

}  // namespace tagcal::internal
