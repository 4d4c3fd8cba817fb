#include <algorithm>
#include <cmath>

#include "tagcal/detect/policy/policy.hpp"
#include "tagcal/detect/tag_fit/tag_fitter.hpp"

namespace tagcal::internal {

using namespace tag_parameter;

FlatPixels::FlatPixels(const TagFlatSums& s) : squares(s.rr) {
  const double by_powers[5][5] = {{s.n, s.y, s.yy, s.yyy, s.yyyy},
                                  {s.x, s.xy, s.xyy, s.xyyy},
                                  {s.xx, s.xxy, s.xxyy},
                                  {s.xxx, s.xxxy},
                                  {s.xxxx}};
  constexpr int kPowers[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      products(i, j) = by_powers[kPowers[i][0] + kPowers[j][0]][kPowers[i][1] + kPowers[j][1]];
  by_residual << s.r, s.xr, s.yr, s.xxr, s.xyr, s.yyr;
}

FlatPixels& FlatPixels::operator+=(const FlatPixels& other) {
  products += other.products;
  by_residual += other.by_residual;
  squares += other.squares;
  return *this;
}

void FlatPixels::change_model(const Eigen::Vector3d& by) {
  squares += by.dot(products.topLeftCorner<3, 3>() * by - 2 * by_residual.head<3>());
  by_residual -= products.leftCols<3>() * by;
}

// Computes the normal equations at the model's parameters.
void TagFitter::collect() {
  sums_.at = model_.parameters();
  if (!is_selection_kept_) select();
  products_.setZero();
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
  add_flat_pixels();
}

void TagFitter::add_flat_pixels() {
  for (const bool white : {false, true}) {
    add_flat(white);
    if (light_) add_flat_light(white);
  }
}

void TagFitter::add_span(std::deque<TagBlock>& blocks, TagBlock*& block, int row, PixelSpan span) {
  while (span.begin < span.end) {
    if (!block || block->size == kTagBlock) {
      block = &blocks.emplace_back();
      block->is_bent = frees_bends();
      block->is_stretched = places_.has_value();
    }
    const int count = std::min(span.end - span.begin, kTagBlock - block->size);
    model_.add(*block, span.begin, count, row * patch_.width + span.begin);
    span.begin += count;
  }
}

void TagFitter::add_block(TagBlock& block) {
  model_.evaluate(block, derivatives_);
  fastest_tag_kernels().add_products(derivatives_, products_.data());
  if (light_) add_light(block);
  if (displaced_) add_lines(block);
  keep_residuals(block);
}

void TagFitter::keep_residuals(const TagBlock& block) {
  if (stage_.is_rough) return;
  for (int i = 0; i < block.size; ++i)
    border_residuals_[block.in_patch[i]] = derivatives_.columns[kTagResidual][i];
}

// Sorts the stage's pixels into those of one colour and blocks of the others.
void TagFitter::select() {
  blocks_.clear();
  ends_ = {};
  open_ = {};
  if (!stage_.is_rough) border_residuals_.setZero(patch_.room_for_residuals());
  std::array<TagFlatSums, 2> flat{};
  for (int row = 0; row < patch_.height; row += stage_.row_step) select_row(row, flat);
  selected_flat_ = {FlatPixels(flat[0]), FlatPixels(flat[1])};
  selected_at_ = model_.parameters();
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
  const double margin_px = std::ceil(policy::kTagUnknownReach * model_.spread() - kHalf);
  if (!(margin_px < size_.height)) return {};  // also where a step left no number
  const int margin = static_cast<int>(margin_px);
  const int y = patch_.y0 + row;
  if (y < margin || y >= size_.height - margin) return {};
  return {margin - patch_.x0, size_.width - margin - patch_.x0};
}

void TagFitter::select_row(int row, std::array<TagFlatSums, 2>& flat) {
  TagRow place{(patch_.x0 - region_.middle.x()) / region_.scale, 1 / region_.scale,
               (patch_.y0 + row - region_.middle.y()) / region_.scale};
  if (places_) place.straight = places_->row(row);
  const PixelSpan window = in_window(row), picture = in_picture(row);
  const PixelSpan span = {std::max(window.begin, picture.begin), std::min(window.end, picture.end)};
  if (span.begin >= span.end) return;
  // Stages that are not rough may end with terms of light.
  model_.select(place, patch_.row(row), policy::kTagUnknownReach, span.begin, span.end, flat.data(),
                !stage_.is_rough || light_);
  for (PixelSpan same = {span.begin, span.begin}; same.begin < span.end; same.begin = same.end) {
    const std::int32_t seen = model_.seen(same.begin);
    while (same.end < span.end && model_.seen(same.end) == seen) ++same.end;
    if (seen == kSeenBlackEnd) add_span(ends_[0], open_[2], row, same);
    if (seen == kSeenWhiteEnd) add_span(ends_[1], open_[3], row, same);
    const bool is_flat = seen == kSeenBlack || seen == kSeenWhite;
    if (seen == kSeenLine || (is_flat && wants_flat_)) add_span(blocks_, open_[0], row, same);
    if (seen == kSeenLines) add_span(blocks_, open_[1], row, same);
  }
}

// Adds pixels of one colour, which depend on the grey levels only.
void TagFitter::add_flat(bool white) {
  const TagParameters change = model_.parameters() - selected_at_;
  const double share = white;
  const std::size_t colour = white ? 1 : 0;
  FlatPixels& pixels = flat_[colour];
  pixels = selected_flat_[colour];
  pixels.change_model({change[kBlack] + share * change[kGain], share * change[kGainSlope],
                       share * change[kGainSlope + 1]});
  TagFlatSums ends{};
  for (const TagBlock& block : ends_[colour]) model_.add_ends(block, white, ends);
  pixels += FlatPixels(ends);
  sums_.num_pixels += static_cast<int>(pixels.products(0, 0));
  // Black and gain change the level alike.
  Eigen::Matrix<double, 4, 3> by_model;
  by_model << 1, 0, 0, share, 0, 0, 0, share, 0, 0, 0, share;
  sums_.information.block<4, 4>(kBlack, kBlack) +=
      by_model * pixels.products.topLeftCorner<3, 3>() * by_model.transpose();
  sums_.gradient.segment<4>(kBlack) += by_model * pixels.by_residual.head<3>();
  sums_.squares += pixels.squares;
}

}  // namespace tagcal::internal
