#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {

using namespace tag_parameter;

// Computes the normal equations at the model's parameters.
void TagFitter::collect() {
  sums_.at = model_.parameters();
  flat_ = {};
  products_.setZero();
  if (!stage_.is_rough) border_residuals_.setZero(patch_.width * patch_.height);
  for (TagBlock& block : blocks_) model_.start(block, frees_bends(), places_.has_value());
  for (int row = 0; row < patch_.height; row += stage_.row_step) collect_row(row);
  for (TagBlock& block : blocks_) add_block(block);
  const auto lower = products_.triangularView<Eigen::Lower>();
  const TagProducts sums = lower.toDenseMatrix().selfadjointView<Eigen::Lower>();
  // The residual's column stands between those of the parameters.
  constexpr int kFirst = kTagResidual, kRest = kTagResidual + 1;
  const int num_rest = (frees_bends() ? kTagColumns : kTagStraightColumns) - kRest;
  sums_.information.setIdentity();  // held bends keep a one
  sums_.information.topLeftCorner<kFirst, kFirst>() = sums.topLeftCorner<kFirst, kFirst>();
  sums_.information.block(kFirst, kFirst, num_rest, num_rest) =
      sums.block(kRest, kRest, num_rest, num_rest);
  sums_.information.block(0, kFirst, kFirst, num_rest) = sums.block(0, kRest, kFirst, num_rest);
  sums_.information.block(kFirst, 0, num_rest, kFirst) = sums.block(kRest, 0, num_rest, kFirst);
  sums_.gradient.setZero();
  sums_.gradient.head<kFirst>() = sums.col(kTagResidual).head<kFirst>();
  sums_.gradient.segment(kFirst, num_rest) = sums.col(kTagResidual).segment(kRest, num_rest);
  sums_.squares = sums(kTagResidual, kTagResidual);
  sums_.num_pixels = static_cast<int>(sums(kBlack, kBlack));  // those that are not clipped
  for (const bool white : {false, true}) {
    add_flat(white);
    if (light_) add_flat_light(white);
  }
}

void TagFitter::add_span(TagBlock& block, int row, PixelSpan span) {
  while (span.begin < span.end) {
    const int count = std::min(span.end - span.begin, kTagBlock - block.size);
    if (!stage_.is_rough)
      runs_[static_cast<std::size_t>(&block - blocks_.data())].push_back(
          {block.size, row * patch_.width + span.begin, count});
    model_.add(block, span.begin, count);
    span.begin += count;
    if (block.size == kTagBlock) add_block(block);
  }
}

void TagFitter::add_block(TagBlock& block) {
  if (block.size == 0) return;
  model_.evaluate(block);
  fastest_tag_kernels().add_products(block, products_.data());
  if (light_) add_light(block);
  std::vector<PixelRun>& runs = runs_[static_cast<std::size_t>(&block - blocks_.data())];
  for (const PixelRun& run : runs)
    std::copy_n(block.derivatives[kTagResidual] + run.in_block, run.count,
                border_residuals_.data() + run.in_patch);
  runs.clear();
  block.size = block.num_felt = 0;
}

PixelSpan TagFitter::in_window(int row) const {
  if (stage_.window_px == 0) return {0, patch_.width};
  const Eigen::Vector2d corner = start_[*region_.corner] - Eigen::Vector2d(patch_.x0, patch_.y0);
  if (std::abs(row - corner.y()) > stage_.window_px) return {};
  return {std::max(0, static_cast<int>(std::ceil(corner.x() - stage_.window_px))),
          std::min(patch_.width, static_cast<int>(std::floor(corner.x() + stage_.window_px)) + 1)};
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
  TagRow place{(patch_.x0 - region_.middle.x()) / region_.scale, 1 / region_.scale,
               (patch_.y0 + row - region_.middle.y()) / region_.scale};
  if (places_) place.straight = places_->row(row);
  PixelSpan& span = spans_[static_cast<std::size_t>(row)];
  if (!are_spans_fixed_) {
    const PixelSpan window = in_window(row), picture = in_picture(row);
    span = {std::max(window.begin, picture.begin), std::min(window.end, picture.end)};
  }
  if (span.begin >= span.end) return;
  model_.select(place, patch_.row(row), policy::kTagUnknownReach / (are_spans_fixed_ ? 2 : 1),
                span.begin, span.end, flat_.data(), light_.has_value());
  while (span.begin < span.end && model_.seen(span.begin) == kSeenNothing) ++span.begin;
  while (span.begin < span.end && model_.seen(span.end - 1) == kSeenNothing) --span.end;
  for (PixelSpan same = {span.begin, span.begin}; same.begin < span.end; same.begin = same.end) {
    const std::int32_t seen = model_.seen(same.begin);
    while (same.end < span.end && model_.seen(same.end) == seen) ++same.end;
    if (seen == kSeenLine) add_span(blocks_[0], row, same);
    if (seen == kSeenLines) add_span(blocks_[1], row, same);
  }
}

// Adds pixels of one colour, which depend on the grey levels only.
void TagFitter::add_flat(bool white) {
  const TagFlatSums& s = flat_[white ? 1 : 0];
  sums_.num_pixels += static_cast<int>(s.n);
  const Eigen::Vector4d share(1, white, white, white);
  Eigen::Matrix4d places;
  places << s.n, s.n, s.x, s.y, s.n, s.n, s.x, s.y, s.x, s.x, s.xx, s.xy, s.y, s.y, s.xy, s.yy;
  sums_.information.block<4, 4>(kBlack, kBlack) += share.asDiagonal() * places * share.asDiagonal();
  sums_.gradient.segment<4>(kBlack) += share.cwiseProduct(Eigen::Vector4d(s.r, s.r, s.xr, s.yr));
  sums_.squares += s.rr;
}

}  // namespace tagcal::internal
