#include <algorithm>
#include <cmath>

#include "tagcal/detect/refine_tag_fitter.hpp"

namespace tagcal {

using namespace tag_parameter;

// Sums over the pixels at the model's parameters.
void TagFitter::collect() {
  num_pixels_ = 0;
  for (FlatSums& sums : flat_) sums = {};
  moments_.start(places_           ? TagMoments::Kind::placed
                 : num_bends_ == 0 ? TagMoments::Kind::straight
                                   : TagMoments::Kind::bent);
  graded_.reserve(patch_.width);
  for (int row = 0; row < patch_.height; row += row_step_) collect_row(row);
  const TagMoments::Result result = moments_.result(model_.parameters());
  information_ = result.information;
  gradient_ = result.gradient;
  squares_ = result.squares;
  for (const bool white : {false, true}) add_flat(white);
}

PixelSpan TagFitter::in_window(int row) const {
  if (window_px_ == 0) return {0, patch_.width};
  const Eigen::Vector2d corner = start_[*region_.corner] - Eigen::Vector2d(patch_.x0, patch_.y0);
  if (std::abs(row - corner.y()) > window_px_) return {};
  return {std::max(0, static_cast<int>(std::ceil(corner.x() - window_px_))),
          std::min(patch_.width, static_cast<int>(std::floor(corner.x() + window_px_)) + 1)};
}

void TagFitter::collect_row(int row) {
  TagRow place{(patch_.x0 - middle_.x()) / scale_, 1 / scale_,
               (patch_.y0 + row - middle_.y()) / scale_};
  if (places_) place.straight = places_->row(row);
  PixelSpan& span = spans_[static_cast<std::size_t>(row)];
  if (!are_spans_fixed_) span = in_window(row);
  int begin = span.begin, end = span.end;
  model_.set_row(place, are_spans_fixed_ ? 0.5 * TagAxis::kUnknownReach : TagAxis::kUnknownReach,
                 begin, end);
  span = {begin, std::max(begin, end)};
  graded_.y = place.y;
  graded_.size = 0;
  for (int c = begin; c < end; ++c) {
    const TagModel::Seen seen = model_.seen(c);
    if (seen == TagModel::Seen::unknown) continue;
    ++num_pixels_;
    if (seen == TagModel::Seen::both)
      add_graded(place, c, patch_.at(c, row));
    else
      flat_[seen == TagModel::Seen::white ? 1 : 0].add(place.left + c * place.step, place.y,
                                                       patch_.at(c, row));
  }
  graded_.end();
  moments_.add(graded_);
}

void TagFitter::add_graded(const TagRow& row, int c, float level) {
  const TagParameters& p = model_.parameters();
  const TagPixel pixel = model_.evaluate(c);
  const double x = row.left + c * row.step;
  const double gain = p[kGain] + p[kGainSlope] * x + p[kGainSlope + 1] * row.y;
  const auto k = static_cast<std::size_t>(graded_.size);
  graded_.add(x, gain, pixel, level - static_cast<float>(p[kBlack] + gain * pixel.white));
  if (!places_) return;
  graded_.place_x[k] = row.straight.x[c];
  graded_.place_y[k] = row.straight.y[c];
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
