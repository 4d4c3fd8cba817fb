// The residuals of a fit show where the lines between a tag's cells are.

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>

#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {
namespace {

using namespace tag_parameter;

constexpr double kInner = 1 - 1e-6;  // numeric: of lines within the tag, from -1 to 1
constexpr int kOwnColumns = kTagColumns + kTagLightColumns;
constexpr double kDisplacedPx = 0.05;  // numeric: of differences, small against a blurred border

}  // namespace

// By differences of the residuals. Pixels of one colour do not feel the lines.
void TagFitter::add_lines(TagBlock& block) {
  const auto column = [&](const TagDerivatives& from, int k) {
    return Eigen::Map<const Eigen::ArrayXf>(from.columns[k], block.size);
  };
  const auto n = static_cast<Eigen::Index>(displaced_->models.size());
  Eigen::MatrixXf all(block.size, kOwnColumns + n);
  for (int k = 0; k < kOwnColumns; ++k) all.col(k) = column(derivatives_, k);
  TagDerivatives displaced;
  for (Eigen::Index k = 0; k < n; ++k) {
    displaced_->models[static_cast<std::size_t>(k)].evaluate(block, displaced);
    all.col(kOwnColumns + k) =
        (column(derivatives_, kTagResidual) - column(displaced, kTagResidual)) /
        static_cast<float>(displaced_->by);
  }
  displaced_->products += (all.rightCols(n).transpose() * all).cast<double>();
}

DisplacedLines TagFitter::displaced_lines() const {
  DisplacedLines lines;
  lines.by = kDisplacedPx / (2 * region_.scale);
  for (std::size_t i = 0; i < region_.grid.columns.size(); ++i) {
    if (std::abs(region_.grid.columns[i]) > kInner) continue;
    TagGrid displaced = region_.grid;
    displaced.columns[i] += 2 * lines.by;
    displaced.rows[i] += 2 * lines.by;
    lines.models.push_back(model_);
    lines.models.back().set_lines(displaced);
  }
  const auto n = static_cast<Eigen::Index>(lines.models.size());
  lines.products.setZero(n, kOwnColumns + n);
  return lines;
}

// The tag's parameters and the terms of light are adapted to the lines.
LineSums TagFitter::line_sums() {
  const Eigen::Index n = displaced_.emplace(displaced_lines()).products.rows();
  const LightSums light = collect_light();
  const Eigen::MatrixXd columns = displaced_->products.leftCols<kOwnColumns>().transpose();
  const Eigen::MatrixXd own = displaced_->products.rightCols(n);
  displaced_.reset();
  constexpr int kTerms = LightSums::kTerms, kAll = kCount + kTerms;
  const auto without_residual = [](const auto& all, auto&& result) {
    result << all.template topRows<kTagResidual>(),
        all.template middleRows<kCount - kTagResidual>(kTagResidual + 1);
  };
  Eigen::MatrixXd cross(kAll, n);
  without_residual(columns, cross.topRows<kCount>());
  cross.bottomRows<kTerms>() = columns.middleRows<kTerms>(kTagColumns);
  const TagParameters weights = sums_.variance(sums_.squares) * prior_weights();
  Eigen::Matrix<double, kAll, kAll> system;
  system.topLeftCorner<kCount, kCount>() = sums_.information;
  system.diagonal().head<kCount>() += weights;
  without_residual(light.columns(), system.topRightCorner<kCount, kTerms>());
  system.bottomLeftCorner<kTerms, kCount>() = system.topRightCorner<kCount, kTerms>().transpose();
  system.bottomRightCorner<kTerms, kTerms>() = light.own();
  Eigen::Vector<double, kAll> right;
  right << sums_.gradient - weights.cwiseProduct(model_.parameters() - prior_mean_),
      light.columns().row(kTagResidual).transpose();
  const Eigen::LDLT<Eigen::Matrix<double, kAll, kAll>> inverse(system);
  const Eigen::MatrixXd adapted = inverse.solve(cross);
  return {.information = own - cross.transpose() * adapted,
          .gradient = columns.row(kTagResidual).transpose() - adapted.transpose() * right,
          .squares = sums_.squares - right.dot(inverse.solve(right)),
          .num_pixels = sums_.num_pixels / noise_factor_};
}

}  // namespace tagcal::internal
