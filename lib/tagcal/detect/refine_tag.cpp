#include "tagcal/detect/refine_tag.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "tagcal/detect/refine_tag_model.hpp"
#include "tagcal/error.hpp"

namespace tagcal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace tag_parameter;
using Corners = std::array<Vector2d, 4>;
using Information = Eigen::Matrix<double, kCount, kCount>;
using CornerJacobian = Eigen::Matrix<double, 8, kCount>;

constexpr double kStartBlur = 0.8;         // px
constexpr double kBoxVariance = 1.0 / 12;  // of a pixel's square, px^2, and of rounding, levels^2
constexpr double kMinSpread = 0.3;         // a little more than the square's own
constexpr double kMaxSpread = 6;
constexpr double kMaxLogStep = 0.4;      // of the spread in one iteration
constexpr double kMaxStepPx = 0.7;       // of a corner in one iteration
constexpr double kRoundingPx = 1e-5;     // no corner needs a smaller step
constexpr double kSmallStep = 0.03;      // squared, in standard deviations
constexpr double kMinContrast = 8;       // grey levels
constexpr double kMaxNoiseShare = 0.15;  // of the contrast, in what the model leaves over
constexpr double kMaxSdPx = 0.5;         // of a corner
constexpr double kLeastGain = 1e-3;      // squared, of a step's size over that of the one before
constexpr double kHeld = 1e18;           // the prior's weight of what is held at zero
constexpr double kBeyondPx = 16;         // around a tag, that is looked at
constexpr int kManyRows = 24;
constexpr int kBlock = 256;  // pixels
constexpr int kMinPixels = 64;
constexpr int kFreeIterations = 2;  // in which the set of pixels may change

constexpr std::array<std::array<double, 2>, 4> kTagCorners = {{{0, 1}, {1, 1}, {1, 0}, {0, 0}}};

// The pixels about a tag.
struct Patch {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
  std::vector<float> levels;

  float at(int x, int y) const {
    return levels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

struct Span {
  int begin = 0;
  int end = 0;
};

// Sums over pixels that one colour fills.
struct FlatSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  double level = 0, x_level = 0, y_level = 0, square_level = 0;

  void add(double px, double py, double value) {
    n += 1;
    x += px;
    y += py;
    xx += px * px;
    xy += px * py;
    yy += py * py;
    level += value;
    x_level += px * value;
    y_level += py * value;
    square_level += value * value;
  }
};

// Far from the corners, what is printed around a large tag would only say how the lens bends there.
TagPattern trimmed(TagPattern pattern, double side_px) {
  std::vector<double>& lines = pattern.lines;
  const std::size_t n = lines.size();
  const double beyond = kBeyondPx / side_px;
  if (-beyond < lines[1]) lines[0] = std::max(lines[0], -beyond);
  if (1 + beyond > lines[n - 2]) lines[n - 1] = std::min(lines[n - 1], 1 + beyond);
  return pattern;
}

// Image from the tag's plane.
Matrix3d homography(const Corners& corners) {
  Eigen::Matrix<double, 8, 8> system;
  Eigen::Matrix<double, 8, 1> right;
  for (int i = 0; i < 4; ++i) {
    const auto [u, v] = kTagCorners[static_cast<std::size_t>(i)];
    const Vector2d& c = corners[static_cast<std::size_t>(i)];
    system.row(2 * i) << u, v, 1, 0, 0, 0, -c.x() * u, -c.x() * v;
    system.row(2 * i + 1) << 0, 0, 0, u, v, 1, -c.y() * u, -c.y() * v;
    right.segment<2>(2 * i) = c;
  }
  const Eigen::Matrix<double, 8, 1> h = system.partialPivLu().solve(right);
  Matrix3d result;
  result << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return result;
}

class TagFitter {
 public:
  TagFitter(const TagPattern& pattern, const Corners& start, const TagFitOptions& options)
      : pattern_(trimmed(pattern, 2 * mean_half_side(start))),
        options_(options),
        scale_(mean_half_side(start)),
        middle_((start[0] + start[1] + start[2] + start[3]) / 4),
        model_(pattern_, scale_) {
    Corners scaled;
    for (std::size_t i = 0; i < 4; ++i) scaled[i] = (start[i] - middle_) / scale_;
    image_from_tag_ = homography(scaled);
  }

  // The pixels that the pattern reaches; empty where the start is no view of a tag.
  template <typename T>
  bool cut(const Image<T>& image);
  TagFit fit();

 private:
  static double mean_half_side(const Corners& corners) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += (corners[(i + 1) % 4] - corners[i]).norm();
    return sum / 8;
  }

  bool start_parameters(TagParameters& parameters) const;
  bool start_levels(TagParameters& parameters) const;
  void set_prior();
  void collect();
  void collect_row(int row);
  void add_block();
  void add_flat(bool white);
  bool step();
  Vector2d corner(std::size_t i) const;
  CornerJacobian corner_jacobian() const;
  TagFit result(int iterations) const;

  const TagPattern pattern_;
  const TagFitOptions& options_;
  double scale_;
  Vector2d middle_;
  TagModel model_;
  Matrix3d image_from_tag_;
  Patch patch_;

  // Of the present parameters: a row of derivatives and the residual for each graded pixel, sums
  // over all.
  Eigen::Matrix<float, kCount + 1, kBlock> graded_;
  Eigen::Matrix<double, kCount + 1, kCount + 1> sums_;
  Information information_;
  TagParameters gradient_;
  TagParameters prior_ = TagParameters::Zero();
  double squares_ = 0;
  double variance_ = 1;
  std::array<FlatSums, 2> flat_;  // black, white
  std::vector<Span> spans_;       // of known pixels, row by row
  bool are_spans_fixed_ = false;
  int row_step_ = 1;
  int num_bends_ = kNumBends;  // that are free
  int num_graded_ = 0;
  int num_pixels_ = 0;
  double step_size_ = 1e-9;  // of the last step, squared, in standard deviations
  double left_over_ = 0;     // what is left after it, likewise
};

template <typename T>
bool TagFitter::cut(const Image<T>& image) {
  Eigen::AlignedBox2d box;
  const double ends[] = {pattern_.lines.front(), pattern_.lines.back()};
  for (const double u : ends) {
    for (const double v : ends) {
      const Vector3d p = image_from_tag_ * Vector3d(u, v, 1);
      if (!(p.z() > 0)) return false;
      box.extend(middle_ + scale_ * p.hnormalized());
    }
  }
  const Vector2d last(image.width() - 1, image.height() - 1);
  const Vector2d low = box.min().cwiseMax(0.0).cwiseMin(last);
  const Vector2d high = box.max().cwiseMax(0.0).cwiseMin(last);
  patch_.x0 = static_cast<int>(std::floor(low.x()));
  patch_.y0 = static_cast<int>(std::floor(low.y()));
  patch_.width = static_cast<int>(std::ceil(high.x())) - patch_.x0 + 1;
  patch_.height = static_cast<int>(std::ceil(high.y())) - patch_.y0 + 1;
  for (int y = 0; y < patch_.height; ++y) {
    const T* row = image.row(patch_.y0 + y) + patch_.x0;
    patch_.levels.insert(patch_.levels.end(), row, row + patch_.width);
  }
  spans_.resize(static_cast<std::size_t>(patch_.height));
  return true;
}

bool TagFitter::start_parameters(TagParameters& parameters) const {
  Matrix3d tag_from_image = image_from_tag_.inverse();
  tag_from_image /= tag_from_image(2, 2);
  parameters.setZero();
  parameters.segment<3>(kM1) = tag_from_image.row(0);
  parameters.segment<3>(kM2) = tag_from_image.row(1);
  parameters.segment<2>(kM3) = tag_from_image.row(2).head<2>();
  parameters[kLogSpread] = 0.5 * std::log(kStartBlur * kStartBlur + kBoxVariance);
  return parameters.allFinite() && start_levels(parameters);
}

// Mean levels at the middles of black and of white cells.
bool TagFitter::start_levels(TagParameters& parameters) const {
  double sum[2] = {0, 0};
  int count[2] = {0, 0};
  const std::size_t n = pattern_.lines.size() - 1;
  for (std::size_t i = 0; i < n * n; ++i) {
    const std::size_t column = i % n, row = i / n;
    const double u = 0.5 * (pattern_.lines[column] + pattern_.lines[column + 1]);
    const double v = 0.5 * (pattern_.lines[row] + pattern_.lines[row + 1]);
    const Vector2d place = middle_ + scale_ * (image_from_tag_ * Vector3d(u, v, 1)).hnormalized();
    const int x = static_cast<int>(std::lround(place.x())) - patch_.x0;
    const int y = static_cast<int>(std::lround(place.y())) - patch_.y0;
    if (x < 0 || y < 0 || x >= patch_.width || y >= patch_.height) continue;
    if (pattern_.cells[i] == TagPattern::unknown) continue;
    const int white = pattern_.cells[i] == TagPattern::white ? 1 : 0;
    sum[white] += patch_.at(x, y);
    ++count[white];
  }
  if (count[0] == 0 || count[1] == 0) return false;
  parameters[kBlack] = sum[0] / count[0];
  parameters[kGain] = sum[1] / count[1] - parameters[kBlack];
  return parameters[kGain] > 0;
}

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

void TagFitter::collect_row(int row) {
  const TagParameters& p = model_.parameters();
  const TagRow place{(patch_.x0 - middle_.x()) / scale_, 1 / scale_,
                     (patch_.y0 + row - middle_.y()) / scale_};
  Span& span = spans_[static_cast<std::size_t>(row)];
  if (!are_spans_fixed_) span = {0, patch_.width};
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

// One step from the sums; false where it is not a number.
bool TagFitter::step() {
  variance_ = std::max(kBoxVariance, squares_ / std::max(1, num_pixels_ - kCount));
  Information system = information_;
  system.diagonal() += variance_ * prior_;
  const TagParameters right = gradient_ - variance_ * prior_.cwiseProduct(model_.parameters());
  TagParameters change = system.ldlt().solve(right);
  if (!change.allFinite()) return false;
  // Gauss-Newton at a small residual: every step about the square of the one before. What the next
  // would do is known before it is made.
  const double size = change.dot(right) / variance_;
  left_over_ = std::max(size * size * size / (step_size_ * step_size_), kLeastGain * size);
  step_size_ = size;
  const double move = (corner_jacobian() * change).cwiseAbs().maxCoeff();
  if (move < kRoundingPx) left_over_ = 0;
  const double share = std::min({1.0, kMaxStepPx / std::max(1e-12, move),
                                 kMaxLogStep / std::max(1e-12, std::abs(change[kLogSpread]))});
  TagParameters next = model_.parameters() + share * change;
  next[kLogSpread] = std::clamp(next[kLogSpread], std::log(kMinSpread), std::log(kMaxSpread));
  model_.set(next);
  return true;
}

Vector2d TagFitter::corner(std::size_t i) const {
  const TagParameters& p = model_.parameters();
  const auto [u, v] = kTagCorners[i];
  const auto line = [&](int row, double at) {
    Vector3d result = p.segment<3>(row);
    result.head<2>() -= at * p.segment<2>(kM3);
    result.z() -= at;
    return result;
  };
  const Vector2d bent = line(kM1, u).cross(line(kM2, v)).hnormalized();
  Vector2d place = bent;
  for (int k = 0; k < 5; ++k)
    place = bent - bend_basis(place.x(), place.y()) * p.segment<kNumBends>(kBend);
  return place;
}

CornerJacobian TagFitter::corner_jacobian() const {
  const TagParameters& p = model_.parameters();
  CornerJacobian result = CornerJacobian::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [u, v] = kTagCorners[i];
    const Vector2d place = corner(i);
    const Eigen::Matrix<double, kNumBends, 1> bend = p.segment<kNumBends>(kBend);
    const BendBasis basis = bend_basis(place.x(), place.y());
    const Vector2d bent = place + basis * bend;
    Eigen::Matrix2d across;
    across.row(0) = p.segment<2>(kM1) - u * p.segment<2>(kM3);
    across.row(1) = p.segment<2>(kM2) - v * p.segment<2>(kM3);
    Eigen::Matrix<double, 2, kCount> by = Eigen::Matrix<double, 2, kCount>::Zero();
    by.row(0).segment<3>(kM1) = -bent.homogeneous();
    by.row(1).segment<3>(kM2) = -bent.homogeneous();
    by.row(0).segment<2>(kM3) = u * bent;
    by.row(1).segment<2>(kM3) = v * bent;
    by = (across.inverse() * by).eval();
    by.middleCols<kNumBends>(kBend) -= basis;
    Eigen::Matrix2d straight;        // bent place by place
    constexpr double kDelta = 1e-4;  // exact for cubics but for its square
    for (int k = 0; k < 2; ++k) {
      const Vector2d d = kDelta * Vector2d::Unit(k);
      const Vector2d more = place + d, less = place - d;
      straight.col(k) =
          Vector2d::Unit(k) +
          (bend_basis(more.x(), more.y()) - bend_basis(less.x(), less.y())) * bend / (2 * kDelta);
    }
    result.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = scale_ * straight.inverse() * by;
  }
  return result;
}

TagFit TagFitter::result(int iterations) const {
  TagFit fit;
  const TagParameters& p = model_.parameters();
  fit.iterations = iterations;
  fit.num_pixels = num_pixels_;
  fit.noise_levels = std::sqrt(variance_);
  fit.black = p[kBlack];
  fit.white = p[kBlack] + p[kGain];
  fit.blur_px = std::sqrt(std::max(0.0, std::pow(model_.spread(), 2) - kBoxVariance));
  for (std::size_t i = 0; i < 4; ++i) fit.corners[i] = middle_ + scale_ * corner(i);
  Information system = information_ / variance_;
  system.diagonal() += prior_;
  const CornerJacobian by = corner_jacobian();
  fit.covariance_px2 = by * system.ldlt().solve(by.transpose());
  const double largest = std::sqrt(fit.covariance_px2.diagonal().maxCoeff());
  const bool matches = left_over_ < kSmallStep && p[kGain] >= kMinContrast &&
                       fit.noise_levels < kMaxNoiseShare * p[kGain];
  if (!matches) return fit;
  const bool is_fixed = num_pixels_ >= kMinPixels && largest < kMaxSdPx;
  fit.status = is_fixed ? TagFitStatus::converged : TagFitStatus::too_small;
  return fit;
}

void TagFitter::set_prior() {
  const double bend_sd = options_.bend_sd_per_px * scale_ / 2;
  const double twist_sd = options_.twist_sd_per_px2 * scale_ * scale_ / 6;
  num_bends_ = bend_sd > 0 && twist_sd > 0 ? kNumBends : 0;
  prior_.segment<kNumBends>(kBend).setConstant(kHeld);
  if (num_bends_ == 0) return;
  prior_.segment<4>(kBend).setConstant(1 / (bend_sd * bend_sd));
  prior_.segment<8>(kBend + 4).setConstant(1 / (twist_sd * twist_sd));
}

TagFit TagFitter::fit() {
  TagParameters parameters;
  if (!start_parameters(parameters)) return {};
  set_prior();
  model_.set(parameters);
  for (int iteration = 1; iteration <= options_.max_iterations; ++iteration) {
    // From the third on, so that no pixel comes and goes with every step.
    are_spans_fixed_ = iteration > kFreeIterations;
    // The first only comes near.
    row_step_ = iteration == 1 && patch_.height >= kManyRows ? 2 : 1;
    collect();
    if (num_pixels_ < kMinPixels) {
      TagFit fit;
      fit.status = TagFitStatus::too_small;
      return fit;
    }
    if (!step()) return {};
    if (left_over_ < kSmallStep || iteration == options_.max_iterations) return result(iteration);
  }
  return {};
}

bool is_inside(const Corners& corners, const ImageSize& size) {
  return std::ranges::all_of(corners, [&](const Vector2d& corner) {
    return corner.x() >= -0.5 && corner.y() >= -0.5 && corner.x() <= size.width - 0.5 &&
           corner.y() <= size.height - 0.5;
  });
}

void check(const TagPattern& pattern) {
  const std::size_t n = pattern.lines.size();
  if (n < 4 || n > kMaxTagLines || pattern.cells.size() != (n - 1) * (n - 1))
    throw Error("refine_tag: pattern: must have 4 to 24 lines and a cell between each two");
  if (!std::ranges::is_sorted(pattern.lines, std::ranges::less_equal()))
    throw Error("refine_tag: pattern: lines must ascend");
}

template <typename T>
TagFit refine(const Image<T>& image, const TagPattern& pattern, const Corners& start,
              const TagFitOptions& options) {
  check(pattern);
  TagFit fit;
  fit.status = TagFitStatus::out_of_image;
  if (!is_inside(start, image.size())) return fit;
  TagFitter fitter(pattern, start, options);
  if (!fitter.cut(image)) return {};
  fit = fitter.fit();
  if (fit.status == TagFitStatus::converged && !is_inside(fit.corners, image.size()))
    fit.status = TagFitStatus::out_of_image;
  return fit;
}

}  // namespace

TagFit refine_tag(const Image8& image, const TagPattern& pattern,
                  const std::array<Vector2d, 4>& start, const TagFitOptions& options) {
  return refine(image, pattern, start, options);
}

TagFit refine_tag(const Image16& image, const TagPattern& pattern,
                  const std::array<Vector2d, 4>& start, const TagFitOptions& options) {
  return refine(image, pattern, start, options);
}

}  // namespace tagcal
