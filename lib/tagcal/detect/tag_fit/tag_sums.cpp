#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {

using namespace tag_parameter;

// Computes the normal equations at the model's parameters.
void TagFitter::collect() {
  num_pixels_ = 0;
  flat_ = {};
  products_.setZero();
  for (TagBlock& block : blocks_) model_.start(block, num_bends_ > 0, places_.has_value());
  for (int row = 0; row < patch_.height; row += row_step_) collect_row(row);
  for (TagBlock& block : blocks_) add_block(block);
  const auto lower = products_.triangularView<Eigen::Lower>();
  const TagProducts sums = lower.toDenseMatrix().selfadjointView<Eigen::Lower>();
  // The residual's column stands between those of the parameters.
  constexpr int kFirst = kTagResidual, kRest = kTagResidual + 1;
  const int num_rest = (num_bends_ > 0 ? kTagColumns : kTagStraightColumns) - kRest;
  information_.setIdentity();  // held bends keep a one
  information_.topLeftCorner<kFirst, kFirst>() = sums.topLeftCorner<kFirst, kFirst>();
  information_.block(kFirst, kFirst, num_rest, num_rest) =
      sums.block(kRest, kRest, num_rest, num_rest);
  information_.block(0, kFirst, kFirst, num_rest) = sums.block(0, kRest, kFirst, num_rest);
  information_.block(kFirst, 0, num_rest, kFirst) = sums.block(kRest, 0, num_rest, kFirst);
  gradient_.setZero();
  gradient_.head<kFirst>() = sums.col(kTagResidual).head<kFirst>();
  gradient_.segment(kFirst, num_rest) = sums.col(kTagResidual).segment(kRest, num_rest);
  squares_ = sums(kTagResidual, kTagResidual);
  for (const bool white : {false, true}) add_flat(white);
}

void TagFitter::add_span(TagBlock& block, PixelSpan span) {
  num_pixels_ += span.end - span.begin;
  while (span.begin < span.end) {
    const int count = std::min(span.end - span.begin, kTagBlock - block.size);
    model_.add(block, span.begin, count);
    span.begin += count;
    if (block.size == kTagBlock) add_block(block);
  }
}

void TagFitter::add_block(TagBlock& block) {
  if (block.size == 0) return;
  model_.evaluate(block);
  fastest_tag_kernels().add_products(block, products_.data());
  block.size = block.num_felt = 0;
}

PixelSpan TagFitter::in_window(int row) const {
  if (window_px_ == 0) return {0, patch_.width};
  const Eigen::Vector2d corner = start_[*region_.corner] - Eigen::Vector2d(patch_.x0, patch_.y0);
  if (std::abs(row - corner.y()) > window_px_) return {};
  return {std::max(0, static_cast<int>(std::ceil(corner.x() - window_px_))),
          std::min(patch_.width, static_cast<int>(std::floor(corner.x() + window_px_)) + 1)};
}

// Columns of a row that are far enough from the picture's edge: a picture that was filtered before
// has values there that were extrapolated beyond it.
PixelSpan TagFitter::in_picture(int row) const {
  constexpr double kHalf = 1.0 / 2;  // px, from a pixel's centre to its edge
  const int margin =
      static_cast<int>(std::ceil(policy::kTagUnknownReach * model_.spread() - kHalf));
  const int y = patch_.y0 + row;
  if (y < margin || y >= size_.height - margin) return {};
  return {margin - patch_.x0, size_.width - margin - patch_.x0};
}

void TagFitter::collect_row(int row) {
  TagRow place{(patch_.x0 - middle_.x()) / scale_, 1 / scale_,
               (patch_.y0 + row - middle_.y()) / scale_};
  if (places_) place.straight = places_->row(row);
  PixelSpan& span = spans_[static_cast<std::size_t>(row)];
  if (!are_spans_fixed_) {
    const PixelSpan window = in_window(row), picture = in_picture(row);
    span = {std::max(window.begin, picture.begin), std::min(window.end, picture.end)};
  }
  if (span.begin >= span.end) return;
  model_.select(place, patch_.row(row), policy::kTagUnknownReach / (are_spans_fixed_ ? 2 : 1),
                span.begin, span.end, flat_.data());
  while (span.begin < span.end && model_.seen(span.begin) == kSeenNothing) ++span.begin;
  while (span.begin < span.end && model_.seen(span.end - 1) == kSeenNothing) --span.end;
  for (PixelSpan same = {span.begin, span.begin}; same.begin < span.end; same.begin = same.end) {
    const std::int32_t seen = model_.seen(same.begin);
    while (same.end < span.end && model_.seen(same.end) == seen) ++same.end;
    if (seen == kSeenLine) add_span(blocks_[0], same);
    if (seen == kSeenLines) add_span(blocks_[1], same);
  }
}

// Adds pixels of one colour, which depend on the grey levels only.
void TagFitter::add_flat(bool white) {
  const TagFlatSums& s = flat_[white ? 1 : 0];
  num_pixels_ += static_cast<int>(s.n);
  const Eigen::Vector4d share(1, white, white, white);
  Eigen::Matrix4d places;
  places << s.n, s.n, s.x, s.y, s.n, s.n, s.x, s.y, s.x, s.x, s.xx, s.xy, s.y, s.y, s.xy, s.yy;
  information_.block<4, 4>(kBlack, kBlack) += share.asDiagonal() * places * share.asDiagonal();
  gradient_.segment<4>(kBlack) += share.cwiseProduct(Eigen::Vector4d(s.r, s.r, s.xr, s.yr));
  squares_ += s.rr;
}

}  // namespace tagcal::internal
