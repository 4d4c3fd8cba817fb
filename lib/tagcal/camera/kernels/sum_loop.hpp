#pragma once

#include "tagcal/camera/kernels/pack_pose.hpp"

// The loop of the normal equations over packs of points, for any lens kernel and pack. Included by
// the files of kernels only, each of which has its own copy.

namespace tagcal::internal {
namespace {

// Both rows of a pack by its whitening W: W [u; v].
template <typename Pack>
[[gnu::always_inline]] inline void whiten(const double* whitening, int num_columns, Pack* u,
                                          Pack* v) {
  Pack w[4];
  load_fours(whitening, w);
  for (int i = 0; i < num_columns; ++i) {
    const Pack first = u[i], second = v[i];
    u[i] = w[0] * first + w[2] * second;
    v[i] = w[1] * first + w[3] * second;
  }
}

// The columns between the pose step and the residual.
enum SumColumns { kNoColumn, kFocalColumn, kFreeColumns };

template <typename LensKernel, typename Pack, SumColumns kColumns>
class SumLoop {
 public:
  static bool run(const SumJob& job) {
    SumLoop loop(job);
    const unsigned long n = job.num_points;
    unsigned long i = 0;
    bool valid = true;
    // Two packs at a time: the sums do not fit in registers, so they are fetched half as often.
    for (; i + 2 * kSize <= n; i += 2 * kSize) {
      for (unsigned long k = 0; k < 2; ++k)
        valid &= loop.set_rows(job, i + k * kSize, loop.rows_ + 2 * k);
      loop.template add<4>();
    }
    for (; i + kSize <= n; i += kSize) {
      valid &= loop.set_rows(job, i, loop.rows_);
      loop.template add<2>();
    }
    if constexpr (kSize > 1)
      if (i < n) valid &= loop.add_rest(job, i);
    loop.store(job.sums);
    return valid;
  }

 private:
  static constexpr unsigned long kSize = kLanes<Pack>;
  static constexpr int kMaxColumns = kColumns == kNoColumn ? 7
                                     : kColumns == kFocalColumn
                                         ? 8
                                         : 6 + kMaxLensParameters + kNumShapes + kMaxRowTerms + 1;
  static constexpr int kMaxSums = kMaxColumns * (kMaxColumns + 1) / 2;

  explicit SumLoop(const SumJob& job)
      : view_(job),
        num_columns_(kColumns == kFreeColumns
                         ? 6 + job.num_columns + (job.shape ? kNumShapes : 0) + job.row_terms + 1
                         : kMaxColumns) {
    for (Pack& sum : sums_) sum = Pack{};
  }

  // [J | r] of the pack from point i on; row 0 of u, 1 of v. Returns true if all points are in the
  // domain.
  bool set_rows(const SumJob& job, unsigned long i, Pack (*rows)[kMaxColumns]) {
    PackPoint<Pack> source;
    load_points(job.points + 3 * i, source.x, source.y, source.z);
    Pack observed[2];
    load_pairs(job.pixels + 2 * i, observed[0], observed[1]);
    const PackPoint<Pack> turned = view_.turned(source);
    const PackImage<Pack> image =
        LensKernel::project(view_.parameters, view_.limit, view_.moved(turned), &jacobian_);
    const Pack projected[2] = {image.u, image.v};
    for (int row = 0; row < 2; ++row) {
      set_by_pose(turned, jacobian_.by_point[row], rows[row]);
      if constexpr (kColumns == kFocalColumn)
        rows[row][6] = view_.parameters[row] * jacobian_.by_parameters[row][row];  // fx, fy
      if constexpr (kColumns == kFreeColumns) set_free(job, i, row, observed[1], rows[row]);
      rows[row][last_column()] = projected[row] - observed[row];
    }
    if (job.whitening) whiten(job.whitening + 4 * i, last_column() + 1, rows[0], rows[1]);
    return all_set(image.valid);
  }

  // The columns after those by the pose, which begin the row.
  void set_free(const SumJob& job, unsigned long i, int row, const Pack& observed_row,
                Pack* by_pose) const {
    Pack* columns = by_pose + 6;
    for (int k = 0; k < job.num_columns; ++k) *columns++ = column(row, job.columns[k]);
    if (job.shape) {
      Pack shape[kNumShapes];
      load_fours(job.shape + kNumShapes * i, shape);
      const Pack out_of_plane = along(row, job.shape_directions[0]);
      for (int k = 0; k < 3; ++k) *columns++ = shape[k] * out_of_plane;
      *columns++ = shape[3] * along(row, job.shape_directions[1]);
    }
    const Pack from_middle = observed_row - job.middle_row;
    if (job.row_terms == 6)
      for (int k = 0; k < 6; ++k) columns[k] = from_middle * by_pose[k];
    if (job.row_terms == 2) {
      columns[row] = from_middle;
      columns[1 - row] = Pack{};
    }
  }

  Pack along(int row, const double* direction) const {
    const Pack* by_point = jacobian_.by_point[row];
    return by_point[0] * direction[0] + by_point[1] * direction[1] + by_point[2] * direction[2];
  }

  // The sum over the lens parameters that one free parameter sets.
  Pack column(int row, unsigned parameters) const {
    Pack sum = jacobian_.by_parameters[row][__builtin_ctz(parameters)];
    for (unsigned left = parameters & (parameters - 1); left != 0; left &= left - 1)
      sum = sum + jacobian_.by_parameters[row][__builtin_ctz(left)];
    return sum;
  }

  template <int kRows>
  void add() {
    int k = 0;
    if constexpr (kColumns == kFreeColumns) {
      for (int i = 0; i < num_columns_; ++i)
        for (int j = i; j < num_columns_; ++j, ++k) add_products<kRows>(i, j, sums_[k]);
    } else {
#pragma GCC unroll 8
      for (int i = 0; i < kMaxColumns; ++i)
#pragma GCC unroll 8
        for (int j = i; j < kMaxColumns; ++j, ++k) add_products<kRows>(i, j, sums_[k]);
    }
  }

  template <int kRows>
  [[gnu::always_inline]] void add_products(int i, int j, Pack& sum) const {
    // Two chains of sums: one would wait for itself.
    Pack chain = sum;
    if constexpr (kRows == 4) {
      chain += rows_[2][i] * rows_[2][j];
      chain += rows_[3][i] * rows_[3][j];
    }
    sum = chain + (rows_[0][i] * rows_[0][j] + rows_[1][i] * rows_[1][j]);
  }

  // The last points, fewer than a pack: the pack is filled with copies of the last one, whitened to
  // nothing.
  bool add_rest(const SumJob& job, unsigned long begin) {
    double points[3 * kSize], pixels[2 * kSize], weights[4 * kSize], shape[4 * kSize];
    for (unsigned long lane = 0; lane < kSize; ++lane) {
      const bool is_there = begin + lane < job.num_points;
      const unsigned long from = is_there ? begin + lane : job.num_points - 1;
      for (unsigned long k = 0; k < 3; ++k) points[3 * lane + k] = job.points[3 * from + k];
      for (unsigned long k = 0; k < 2; ++k) pixels[2 * lane + k] = job.pixels[2 * from + k];
      for (unsigned long k = 0; k < kNumShapes; ++k)
        shape[kNumShapes * lane + k] = job.shape ? job.shape[kNumShapes * from + k] : 0;
      for (unsigned long k = 0; k < 4; ++k)
        weights[4 * lane + k] = !is_there       ? 0
                                : job.whitening ? job.whitening[4 * from + k]
                                                : (k == 0 || k == 3 ? 1 : 0);
    }
    SumJob part = job;
    part.points = points;
    part.pixels = pixels;
    part.whitening = weights;
    if (job.shape) part.shape = shape;
    const bool valid = set_rows(part, 0, rows_);
    add<2>();
    return valid;
  }

  void store(double* to) const {
    const int count = num_columns_ * (num_columns_ + 1) / 2;
    for (int k = 0; k < count; k += 4) {
      double four[4];
      store_lane_sums(sums_ + k, four);
      for (int lane = 0; lane < 4 && k + lane < count; ++lane) to[k + lane] = four[lane];
    }
  }

  int last_column() const { return (kColumns == kFreeColumns ? num_columns_ : kMaxColumns) - 1; }

  const PackView<Pack> view_;
  const int num_columns_;  // the last one is the residual
  PackJacobian<Pack> jacobian_;
  Pack sums_[kMaxSums + 4];
  Pack rows_[4][kMaxColumns];
};

}  // namespace
}  // namespace tagcal::internal
