#include <algorithm>
#include <cmath>

#include "tagcal/detect/refine_tag_fitter.hpp"

namespace tagcal {

using namespace tag_parameter;

// Sums over the pixels at the model's parameters.
void TagFitter::collect() {
  num_graded_ = num_pixels_ = 0;
  sums_.setZero();
  for (FlatSums& sums : flat_) sums = {};
  for (int row = 0; row < patch_.height; row += row_step_) collect_row(row);
  add_block();
  // The residual's row stands before those of the bends.
  information_.setIdentity();  // of bends that are held at zero
  information_.topLeftCorner<kBend, kBend>() = sums_.topLeftCorner<kBend, kBend>();
  information_.block(kBend, kBend, num_bends_, num_bends_) =
      sums_.block(kBend + 1, kBend + 1, num_bends_, num_bends_);
  information_.block(0, kBend, kBend, num_bends_) = sums_.block(0, kBend + 1, kBend, num_bends_);
  information_.block(kBend, 0, num_bends_, kBend) = sums_.block(kBend + 1, 0, num_bends_, kBend);
  gradient_.setZero();
  gradient_.head<kBend>() = sums_.col(kBend).head<kBend>();
  gradient_.segment(kBend, num_bends_) = sums_.col(kBend).segment(kBend + 1, num_bends_);
  squares_ = sums_(kBend, kBend);
  for (const bool white : {false, true}) add_flat(white);
}

// Products in single precision, summed over blocks in double.
void TagFitter::add_block() {
  const Eigen::Index n = kBend + 1 + num_bends_;
  Eigen::Matrix<float, kCount + 1, kCount + 1> block;
  block.setZero();
  block.topLeftCorner(n, n).selfadjointView<Eigen::Lower>().rankUpdate(
      graded_.topLeftCorner(n, num_graded_));
  block.triangularView<Eigen::StrictlyUpper>() = block.transpose();
  sums_ += block.cast<double>();
  num_graded_ = 0;
}

PixelSpan TagFitter::in_window(int row) const {
  if (window_px_ == 0) return {0, patch_.width};
  const Eigen::Vector2d corner = start_[*region_.corner] - Eigen::Vector2d(patch_.x0, patch_.y0);
  if (std::abs(row - corner.y()) > window_px_) return {};
  return {std::max(0, static_cast<int>(std::ceil(corner.x() - window_px_))),
          std::min(patch_.width, static_cast<int>(std::floor(corner.x() + window_px_)) + 1)};
}

void TagFitter::collect_row(int row) {
  const TagParameters& p = model_.parameters();
  TagRow place{(patch_.x0 - middle_.x()) / scale_, 1 / scale_,
               (patch_.y0 + row - middle_.y()) / scale_};
  if (places_) place.straight = places_->row(row);
  PixelSpan& span = spans_[static_cast<std::size_t>(row)];
  if (!are_spans_fixed_) span = in_window(row);
  int begin = span.begin, end = span.end;
  model_.set_row(place, are_spans_fixed_ ? 0.5 * TagAxis::kUnknownReach : TagAxis::kUnknownReach,
                 begin, end);
  span = {begin, std::max(begin, end)};
  TagPixel pixel;
  for (int c = begin; c < end; ++c) {
    const double level = patch_.at(c, row);
    const double x = place.left + c * place.step;
    const TagModel::Seen seen = model_.seen(c);
    if (seen == TagModel::Seen::unknown) continue;
    ++num_pixels_;
    if (seen != TagModel::Seen::both) {
      flat_[seen == TagModel::Seen::white ? 1 : 0].add(x, place.y, level);
      continue;
    }
    model_.evaluate(c, pixel);
    const double gain = p[kGain] + p[kGainSlope] * x + p[kGainSlope + 1] * place.y;
    if (num_graded_ == kBlock) add_block();
    float* out = graded_.col(num_graded_++).data();
    std::copy_n(pixel.by_parameter.begin(), kBend, out);
    out[kBend] = static_cast<float>(level - p[kBlack] - gain * pixel.white);
    std::copy_n(pixel.by_parameter.begin() + kBend, num_bends_, out + kBend + 1);
  }
}

// Pixels of one colour know of the grey levels only.
void TagFitter::add_flat(bool white) {
  const FlatSums& s = flat_[white ? 1 : 0];
  const Eigen::Vector4d share(1, white, white, white);
  Eigen::Matrix4d places;
  places << s.n, s.n, s.x, s.y, s.n, s.n, s.x, s.y, s.x, s.x, s.xx, s.xy, s.y, s.y, s.xy, s.yy;
  const Eigen::Matrix4d part = share.asDiagonal() * places * share.asDiagonal();
  const Eigen::Vector4d levels =
      share.cwiseProduct(Eigen::Vector4d(s.level, s.level, s.x_level, s.y_level));
  const Eigen::Vector4d now = model_.parameters().segment<4>(kBlack);
  information_.block<4, 4>(kBlack, kBlack) += part;
  gradient_.segment<4>(kBlack) += levels - part * now;
  squares_ += s.square_level - 2 * now.dot(levels) + now.dot(part * now);
}

}  // namespace tagcal
