#include "tagcal/detect/tag_fit/printed_lines.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/known_tag.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {
namespace {

using Eigen::VectorXd;
using namespace policy;

constexpr std::size_t kFewTags = 2;    // to see whether cells are equal, as a limit of work
constexpr int kFewTagsRowStep = 3;     // of them, every how many-th is used, as a limit of work
constexpr std::size_t kManyTags = 6;   // to estimate the lines, as a limit of work
constexpr double kNoPromise = 25;      // numeric: few tags with equal cells have up to half of it
constexpr int kMaxLineSteps = 4;       // numeric: Newton's
constexpr double kLinesSettled = 5;    // numeric: change of the cost by a last step
constexpr double kMaxStepCells = 0.3;  // numeric: of a line
constexpr double kPriorSd = 0.03;      // numeric: sides, of a line without contrast

// The grids of drawings: pixels a cell, and what is added before a place is rounded down, which
// rounds it down, to the nearest (ties down or up) or up.
constexpr int kLeastPerCell = 2, kMostPerCell = 40;  // numeric: ends of the search
constexpr double kTie = 1e-6;  // numeric: products of whole numbers are not exact
constexpr double kRoundings[] = {kTie, 1.0 / 2 - kTie, 1.0 / 2 + kTie, 1 - kTie};

VectorXd inner_lines(const TagPattern& pattern) {
  std::vector<double> inner;
  for (const double at : pattern.lines)
    if (at > 0 && at < 1) inner.push_back(at);
  return Eigen::Map<const VectorXd>(inner.data(), static_cast<Eigen::Index>(inner.size()));
}

// How the residuals of tags depend on the lines between their cells, which are the same in all.
class LineEvidence {
 public:
  // With the lines where they are said to be. Tags with other lines, or without a fit, are left
  // out.
  LineEvidence(const ImageView8& image, std::span<const TagInPicture> tags,
               const CameraProcessing& processing, const VectorXd& lines, int row_step = 1)
      : lines_(lines) {
    for (const TagInPicture& tag : tags) {
      sums_.emplace_back();
      if (inner_lines(*tag.pattern).size() != lines.size()) continue;
      TagFitOptions options{.camera = tag.camera,
                            .is_rough = tag.is_rough,
                            .is_whole = true,
                            .row_step = row_step,
                            .processing = processing};
      options = with_usual_priors(options, image.size());
      const TagRegion region = whole_tag(PrintedLines{lines}.printed(*tag.pattern), tag.corners);
      TagFitter fitter(region, tag.corners, options);
      if (fitter.cut(image) && fitter.fit().status == TagFitStatus::converged)
        sums_.back() = fitter.line_sums();
    }
  }

  // Minus twice the log-likelihood, over that of other lines.
  double cost_over(const LineEvidence& other) const {
    double cost = 0;
    for (std::size_t i = 0; i < sums_.size(); ++i)
      if (sums_[i] && other.sums_[i])
        cost += sums_[i]->num_pixels * std::log(sums_[i]->squares / other.sums_[i]->squares);
    return cost;
  }
  // The same of lines elsewhere, over these, as the linear model predicts it.
  double cost_at(const VectorXd& lines) const {
    double cost = 0;
    for (const auto& sums : sums_)
      if (sums) cost -= sums->num_pixels * sums->gain(lines - lines_) / sums->squares;
    return cost;
  }
  // The lines at the minimum of the linear model.
  VectorXd minimum() const {
    const Eigen::Index n = lines_.size();
    Eigen::MatrixXd information = VectorXd::Constant(n, 1 / (kPriorSd * kPriorSd)).asDiagonal();
    VectorXd gradient = VectorXd::Zero(n);
    for (const auto& sums : sums_) {
      if (!sums) continue;
      const double weight = sums->num_pixels / sums->squares;
      information += weight * sums->information;
      gradient += weight * sums->gradient;
    }
    const double most = kMaxStepCells / static_cast<double>(n + 1);
    return lines_ + information.ldlt().solve(gradient).cwiseMax(-most).cwiseMin(most);
  }

 private:
  VectorXd lines_;
  std::vector<std::optional<LineSums>> sums_;  // by tags
};

// The lines of the drawing that agrees best.
VectorXd nearest_drawing(const LineEvidence& evidence, const VectorXd& equal) {
  VectorXd best = equal;
  double least = evidence.cost_at(equal);
  const auto cells = static_cast<int>(equal.size()) + 1;
  for (int pixels = kLeastPerCell * cells; pixels <= kMostPerCell * cells; ++pixels) {
    for (const double rounding : kRoundings) {
      const VectorXd lines = (equal * pixels).array().unaryExpr([&](double at) {
        return std::floor(at + rounding) / pixels;
      });
      const double cost = evidence.cost_at(lines);
      if (cost < least) best = lines;
      least = std::min(least, cost);
    }
  }
  return best;
}

}  // namespace

TagPattern PrintedLines::printed(TagPattern pattern) const {
  if (inner_lines(pattern).size() != inner.size()) return pattern;  // of another family
  const double* next = inner.data();
  for (double& at : pattern.lines)
    if (at > 0 && at < 1) at = *next++;
  return pattern;
}

PrintedLines printed_lines_of_picture(const ImageView8& image, std::span<const TagInPicture> tags,
                                      const CameraProcessing& processing,
                                      const PrintedLines& start) {
  if (tags.empty()) return {};
  const VectorXd equal = inner_lines(*tags.front().pattern);
  if (start.is_none()) {
    const LineEvidence few(image, tags.first(std::min(kFewTags, tags.size())), processing, equal,
                           kFewTagsRowStep);
    if (few.cost_at(few.minimum()) > -kNoPromise) return {};
  }
  const auto some = tags.first(std::min(kManyTags, tags.size()));
  const LineEvidence before(image, some, processing, equal);
  LineEvidence evidence =
      start.is_none() ? before : LineEvidence(image, some, processing, start.inner);
  VectorXd lines = evidence.minimum();
  for (int step = 0; step < kMaxLineSteps && evidence.cost_at(lines) < -kLinesSettled; ++step) {
    evidence = LineEvidence(image, some, processing, lines);
    lines = evidence.minimum();
  }
  const VectorXd drawn = nearest_drawing(evidence, equal);
  if (evidence.cost_at(drawn) - evidence.cost_at(lines) < kPrintIsDrawing) lines = drawn;
  const LineEvidence after(image, some, processing, lines);
  return after.cost_over(before) < -kPrintSure ? PrintedLines{lines} : PrintedLines();
}

}  // namespace tagcal::internal
