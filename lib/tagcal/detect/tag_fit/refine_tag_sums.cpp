#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/refine_tag_fitter.hpp"

namespace tagcal::internal {

using namespace tag_parameter;

// Computes the normal equations at the model's parameters.
void TagFitter::collect() {
  num_pixels_ = 0;
  for (FlatSums& sums : flat_) sums = {};
  products_.setZero();
  model_.start(block_, num_bends_ > 0, places_.has_value());
  for (int row = 0; row < patch_.height; row += row_step_) collect_row(row);
  add_block();
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

void TagFitter::add_block() {
  if (block_.size == 0) return;
  model_.evaluate(block_);
  fastest_tag_kernels().add_products(block_, products_.data());
  block_.size = block_.num_felt = 0;
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
  int begin = span.begin, end = span.end;
  model_.set_row(place, policy::kTagUnknownReach / (are_spans_fixed_ ? 2 : 1), begin, end);
  span = {begin, std::max(begin, end)};
  for (int c = begin; c < end; ++c) {
    const TagModel::Seen seen = model_.seen(c);
    if (seen == TagModel::Seen::unknown) continue;
    ++num_pixels_;
    if (seen == TagModel::Seen::both) {
      model_.add(block_, c, patch_.at(c, row));
      if (block_.size == kTagBlock) add_block();
    } else {
      const Eigen::Vector2d at = model_.place(c).cast<double>();
      flat_[seen == TagModel::Seen::white ? 1 : 0].add(at.x(), at.y(), patch_.at(c, row));
    }
  }
}

// Adds pixels of one colour, which depend on the grey levels only.
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

}  // namespace tagcal::internal
