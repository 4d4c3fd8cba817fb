// The residuals of a fit show what the model of refine_tag() lacks: uneven light, and noise that is
// larger at borders or shared by neighbours.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {
namespace {

using namespace tag_parameter;

// px. Between pixels whose noise may be correlated, in x and y: by a filter of 3x3 pixels, as for a
// mosaic, as a limit of work.
constexpr int kCorrelatedPx = 2;
constexpr int kNumOffsets = (kCorrelatedPx + 1) * (2 * kCorrelatedPx + 1) - kCorrelatedPx - 1;
// numeric: change of a tag's distance over half its side, as a share, from which on terms of light
// are tried whatever the residuals are, as a limit of work
constexpr double kTilted = 0.06;

// From a pixel to those after it in rows whose noise may be correlated with its own.
std::array<Eigen::Vector2i, kNumOffsets> correlated_offsets() {
  std::array<Eigen::Vector2i, kNumOffsets> offsets;
  std::size_t k = 0;
  for (int dy = 0; dy <= kCorrelatedPx; ++dy)
    for (int dx = dy == 0 ? 1 : -kCorrelatedPx; dx <= kCorrelatedPx; ++dx) offsets[k++] = {dx, dy};
  return offsets;
}

// Sums of the products of values so many places apart, in one pass over the few that are not zero.
// Precondition: the last values, as many as the largest distance and three, are zero.
std::array<double, kNumOffsets> products_apart(const Eigen::VectorXf& values,
                                               const std::array<Eigen::Index, kNumOffsets>& apart) {
  std::array<Eigen::Array4f, kNumOffsets> sums;
  sums.fill(Eigen::Array4f::Zero());
  const Eigen::Index end = values.size() - apart.back() - 3;
  for (Eigen::Index i = 0; i < end; i += 4) {
    const Eigen::Array4f here = values.segment<4>(i);
    if ((here == 0).all()) continue;
    for (std::size_t k = 0; k < apart.size(); ++k)
      sums[k] += here * values.segment<4>(i + apart[k]).array();
  }
  std::array<double, kNumOffsets> result;
  std::ranges::transform(sums, result.begin(), [](const auto& sum) -> double { return sum.sum(); });
  return result;
}

}  // namespace

int TagPatch::room_for_residuals() const {
  return width * height + kCorrelatedPx * (width + 1) + 3;
}

double TagSums::variance(double left) const {
  return std::max(kBoxVariance, left / std::max(1, num_pixels - kCount));
}

// A test that costs little, by the tag's tilt and from the residuals of pixels of one colour: sums
// of their products with the terms, squared, over their variances.
bool TagFitter::may_need_light() const {
  // Mean squares of x^2 about its mean, and of xy, over that of x, if x and y are uniform.
  constexpr double kOfSquare = 4.0 / 15, kOfProduct = 1.0 / 3;
  const TagParameters& p = model_.parameters();
  // Pixels sample these borders too coarsely: sampling, not light, makes their residuals.
  if (model_.spread() < policy::kUsualSpreadPx / 2) return false;
  if (p.segment<2>(kM3).norm() > kTilted) return true;
  const auto share = [](double sum, double variance) {
    return variance > 0 ? sum * sum / variance : 0;
  };
  // Sums over pixels of one colour, of black and of both as light shades them.
  const FlatPixels& black = flat_[0];
  const double b = p[kBlack], w = p[kBlack] + p[kGain];
  const Eigen::Matrix<double, 6, 6> products = b * b * black.products + w * w * flat_[1].products;
  const Eigen::Vector<double, 6> shaded = b * black.by_residual + w * flat_[1].by_residual;
  const double n = std::max(1.0, black.products(0, 0));
  const double xx = products(1, 1), yy = products(2, 2);
  const auto about_mean = [&](int k) {
    return black.products(k, k) - black.products(0, k) * black.products(0, k) / n;
  };
  const double squares =
      share(black.by_residual[1], about_mean(1)) + share(black.by_residual[2], about_mean(2)) +
      share(shaded[3], kOfSquare * xx) + share(shaded[4], kOfProduct * (xx + yy) / 2) +
      share(shaded[5], kOfSquare * yy);
  return squares > policy::kLightSure / 2 * last_.variance;
}

// Computes the sums at the model's parameters, and those of the terms of light.
LightSums TagFitter::collect_light() {
  light_.emplace();
  collect();
  const LightSums sums = *light_;
  light_.reset();
  return sums;
}

// The sum of the squares of the residuals without some light, which stay for borders. Other sums
// are not computed: their products are half of the work.
double TagFitter::squares_without(const LightSums::Terms& light) {
  light_.emplace().light = light;
  if (!is_selection_kept_) select();
  for (TagBlock& block : blocks_) {
    model_.evaluate(block, derivatives_);
    add_light(block);
    keep_residuals(block);
  }
  sums_.squares = light_->products(LightSums::kTerms, kTagResidual);
  add_flat_pixels();
  const double squares = light_->squares_without_light(sums_.squares);
  light_.reset();
  return squares;
}

// The terms are a slope of black by x and y (white has one in the model), shade of second order, by
// which light multiplies both, and a slope of the spread: a tilted tag is not in focus everywhere.
void TagFitter::add_light(const TagBlock& block) {
  // By whole packs: what pads a block is zero in all columns.
  const int size = (block.size + kTagPack - 1) / kTagPack * kTagPack;
  const auto column = [&](int k) {
    return Eigen::Map<Eigen::ArrayXf, Eigen::Aligned64>(derivatives_.columns[k], size);
  };
  const Eigen::Map<const Eigen::ArrayXf> x(block.x, size), y(block.y, size);
  const TagParameters& p = model_.parameters();
  const auto& one = column(kBlack);
  const auto& spread = column(kLogSpread);
  int k = kTagColumns;
  column(k++) = x * one;
  column(k++) = y * one;
  const Eigen::ArrayXf level =
      static_cast<float>(p[kBlack]) * one + static_cast<float>(p[kGain]) * column(kGain);
  column(k++) = x * x * level;
  column(k++) = x * y * level;
  column(k++) = y * y * level;
  column(k++) = x * spread;
  column(k++) = y * spread;
  column(k) = column(kTagResidual);
  fastest_tag_kernels().add_light_products(derivatives_, light_->products.data());
  for (int i = 0; i < LightSums::kTerms; ++i)
    column(kTagResidual) -= static_cast<float>(light_->light[i]) * column(kTagColumns + i);
}

// Adds pixels of one colour, where the terms of the spread are zero.
void TagFitter::add_flat_light(bool white) {
  const FlatPixels& pixels = flat_[white ? 1 : 0];
  const double share = white;
  const double level = model_.parameters()[kBlack] + share * model_.parameters()[kGain];
  const Eigen::DiagonalMatrix<double, 5> levels(1, 1, level, level, level);
  // Products of x, y, xx, xy, yy with each other, and with black, gain, its slopes, the residual.
  const auto own = pixels.products.bottomRightCorner<5, 5>();
  const auto by_1_x_y = pixels.products.bottomLeftCorner<5, 3>();
  Eigen::Matrix<double, 5, 5> by_column;
  by_column << by_1_x_y.col(0), share * by_1_x_y, pixels.by_residual.tail<5>();
  light_->products.block<5, 5>(0, kBlack) += levels * by_column;
  light_->products.block<5, 5>(0, kTagColumns) += levels * own * levels;
}

// Makes one more step, with the terms of light, if the residuals show these: few tags need them, so
// they are no parameters of each step.
void TagFitter::admit_light() {
  const LightSums sums = collect_light();
  Eigen::Matrix<double, kCount, LightSums::kTerms> cross;
  const auto columns = sums.columns();
  const auto of_light = sums.own();
  cross << columns.topRows<kTagResidual>(), columns.bottomRows<kCount - kTagResidual>();
  const double variance = sums_.variance(sums_.squares);
  const TagParameters weights = variance * prior_weights();
  TagInformation system = sums_.information;
  system.diagonal() += weights;
  const TagSystem inverse = solvable(system);
  const TagParameters right =
      sums_.gradient - weights.cwiseProduct(model_.parameters() - prior_mean_);
  const auto by_light = inverse.solve(cross).eval();
  const auto own = (of_light - cross.transpose() * by_light).eval();
  const auto gradient =
      (columns.row(kTagResidual).transpose() - by_light.transpose() * right).eval();
  const auto light = own.ldlt().solve(gradient).eval();
  const double gain = gradient.dot(light);
  // Rounding has a structure of its own, so the terms must change levels by more than it does.
  if (!(gain > std::max(policy::kLightSure * variance, kBoxVariance * sums_.num_pixels))) return;
  const TagSums before = sums_;
  Eigen::VectorXf residuals = border_residuals_;
  model_.set(before.at + inverse.solve(right - cross * light));
  const double left = squares_without(light);
  if (before.squares - left < gain / 2) {  // a border sharper than a pixel: far from linear
    model_.set(before.at);
    sums_ = before;
    border_residuals_ = std::move(residuals);
    return;
  }
  sums_ = before;
  sums_.at = model_.parameters();
  sums_.information -= cross * of_light.ldlt().solve(cross.transpose());
  last_.variance = sums_.variance(left);
}

// The variance of a corner over that by the mean square of all residuals, if these were
// independent. A corner is a sum of the borders' residuals with weights, which across a border
// change as its profile's slope does and along it hardly: weights d px apart are correlated by
// c(d) = exp(-(n d)^2 / (4 spread^2)), n the border's normal.
double TagFitter::noise_factor() const {
  const Eigen::VectorXf& r = border_residuals_;
  const auto n = static_cast<double>((r.array() != 0).count());
  if (n < 2 * kCount) return 1;
  const TagParameters& p = model_.parameters();
  const Eigen::Vector2d across_columns = p.segment<2>(kM1).normalized();
  const Eigen::Vector2d across_rows = p.segment<2>(kM2).normalized();
  const double spread2 = std::pow(model_.spread(), 2);
  // The fit of a homography takes its share of independent residuals' squares, and of their
  // products as much as the weights are correlated.
  const double lost = 8 / n;
  const double square = r.cast<double>().squaredNorm() / (n - 8);
  double sum = 1, variance = 2 / n;
  static const std::array<Eigen::Vector2i, kNumOffsets> kOffsets = correlated_offsets();
  std::array<Eigen::Index, kNumOffsets> apart;
  std::ranges::transform(kOffsets, apart.begin(), [&](const Eigen::Vector2i& offset) {
    return offset.y() * patch_.width + offset.x();
  });
  const std::array<double, kNumOffsets> products = products_apart(r, apart);
  for (std::size_t k = 0; k < kOffsets.size(); ++k) {
    const Eigen::Vector2d d = kOffsets[k].cast<double>();
    const double c = (std::exp(-std::pow(across_columns.dot(d), 2) / (4 * spread2)) +
                      std::exp(-std::pow(across_rows.dot(d), 2) / (4 * spread2))) /
                     2;
    sum += 2 * c * (products[k] / n / square + lost * c);
    variance += 4 * c * c / n;
  }
  const double factor = sum * square / last_.variance;
  return std::max(1.0, factor - policy::kNoiseSureSds * std::sqrt(variance));
}

}  // namespace tagcal::internal
