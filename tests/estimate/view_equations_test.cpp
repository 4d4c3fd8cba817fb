#include "tagcal/estimate/pose/view_equations.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "view_fixture.hpp"

namespace tagcal {
using namespace internal;
namespace {

// Normal equations of the given kernels.
template <int N>
bool sums_by(const ProjectKernels& kernels, const Observed& o, double focal_px,
             NormalEquations<N>& equations) {
  SumJob job;
  const ProjectKernelKind kind = set_lens(o.lens, 0, job);
  double sums[36];
  job.num_points = o.points.size();
  job.points = o.points.data()->data();
  job.pixels = o.pixels.data()->data();
  job.whitening = o.whitening.empty() ? nullptr : o.whitening.data()->data();
  job.sums = sums;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(job.rotation) = o.pose.rotation_matrix();
  Eigen::Map<Vector3d>(job.translation) = o.pose.translation();
  if (N == 7) job.parameters[0] = job.parameters[1] = focal_px;
  if (!(N == 7 ? kernels.sums_pose_and_focal : kernels.sums_pose)[kind](job)) return false;
  const double* next = sums;
  equations.information.setZero();
  for (int i = 0; i < N; ++i) {
    for (int k = i; k < N; ++k) equations.information(i, k) = *next++;
    equations.gradient[i] = *next++;
  }
  equations.cost = *next;
  return true;
}

// Difference of upper triangles, relative to the diagonal.
template <int N>
double difference(const NormalEquations<N>& a, const NormalEquations<N>& b) {
  double largest = std::abs(a.cost / b.cost - 1);
  for (int i = 0; i < N; ++i) {
    const double row = std::sqrt(b.information(i, i));
    largest = std::max(largest, std::abs(a.gradient[i] - b.gradient[i]) / row / std::sqrt(b.cost));
    for (int k = i; k < N; ++k)
      largest = std::max(largest, std::abs(a.information(i, k) - b.information(i, k)) / row /
                                      std::sqrt(b.information(k, k)));
  }
  return largest;
}

template <int N>
NormalEquations<N> by_differences(const Observed& o, double focal_px) {
  const MatrixXd j = differences(o, o.pose, focal_px);
  const VectorXd r = residuals(o, o.pose, focal_px);
  return {j.transpose() * j, j.transpose() * r, r.squaredNorm()};
}

std::vector<Lens> every_lens() {
  std::vector<Lens> all = lenses<Perspective>(1, 6);  // rational, Brown-Conrady and pinhole of each
  for (const Lens& lens : lenses<Fisheye>(2, 6)) all.push_back(lens);
  for (const Lens& lens : lenses<Parallel>(3, 6)) all.push_back(lens);
  all.emplace_back(Parallel({500, 510, 320, 240}));
  return all;
}

TEST(ViewEquations, AreThoseOfDifferencesForEveryLens) {
  Random random(1);
  for (const Lens& lens : every_lens())
    for (std::size_t n = 1; n <= 9; ++n)
      for (const bool whitened : {false, true}) {
        const Observed o = observe(lens, n, whitened, random);
        NormalEquations<6> fast;
        ASSERT_TRUE(ViewSums(lens, o.view()).at(state_of(o.pose), fast));
        const auto slow = by_differences<6>(o, 0);
        const auto* parallel = std::get_if<Parallel>(&lens);
        if (parallel && !parallel->oblique()) {  // its distance has no effect
          EXPECT_EQ(fast.information(5, 5), 0);
          fast.information(5, 5) = 1;
          NormalEquations<6> known = slow;
          known.information(5, 5) = 1;
          EXPECT_LT(difference(fast, known), 1e-5) << lens.index() << " " << n << whitened;
          continue;
        }
        EXPECT_LT(difference(fast, slow), 1e-5) << lens.index() << " " << n << whitened;
      }
}

TEST(ViewEquations, TheFocalLengthIsTheSeventh) {
  Random random(2);
  for (int i = 0; i < 10; ++i)
    for (std::size_t n = 1; n <= 9; ++n) {
      const double focal = random.uniform(200, 3000);
      const Observed o = observe(centred_pinhole(focal), n, i % 2 == 0, random);
      // The lens of the sums has another focal length; the state's is used.
      NormalEquations<7> fast;
      ASSERT_TRUE(ViewSums(centred_pinhole(1), o.view()).at(state_of(o.pose, focal), fast));
      EXPECT_LT(difference(fast, by_differences<7>(o, focal)), 1e-5) << n;
      NormalEquations<6> pose_only;
      ASSERT_TRUE(ViewSums(o.lens, o.view()).at(state_of(o.pose), pose_only));
      EXPECT_LT((fast.gradient.head<6>() - pose_only.gradient).norm(),
                1e-9 * pose_only.gradient.norm());
    }
}

template <int N>
void expect_equal_kernels(const Observed& o, double focal_px, const char* what) {
  NormalEquations<N> portable, avx2;
  ASSERT_TRUE(sums_by<N>(kPortableKernels, o, focal_px, portable));
  if (!has_avx2()) return;
  ASSERT_TRUE(sums_by<N>(kAvx2Kernels, o, focal_px, avx2));
  for (NormalEquations<N>* e : {&portable, &avx2})
    if (e->information(5, 5) == 0) e->information(5, 5) = 1;
  // An ulp, amplified by a rational lens near its pole.
  EXPECT_LT(difference(avx2, portable), 1e-10) << what << " " << o.points.size();
}

TEST(ViewEquations, AllKernelsAgree) {
  Random random(3);
  for (const Lens& lens : every_lens())
    for (std::size_t n = 1; n <= 9; ++n) {
      const Observed o = observe(lens, n, n % 2 == 0, random);
      expect_equal_kernels<6>(o, 0, "pose");
      if (lens.index() == 0)
        expect_equal_kernels<7>(observe(centred_pinhole(700), n, n % 2 == 0, random), 700, "focal");
    }
}

TEST(ViewEquations, OnePointOutsideIsEnoughForNone) {
  Random random(4);
  for (std::size_t n = 1; n <= 9; ++n)
    for (std::size_t bad = 0; bad < n; ++bad) {
      Observed o = observe(centred_pinhole(900), n, false, random);
      const Vector3d x = o.pose * o.points[bad];
      o.points[bad] = o.pose.inverse() * Vector3d(x.x(), x.y(), -x.z());
      NormalEquations<6> six;
      NormalEquations<7> seven;
      for (const ProjectKernels* kernels : all_kernels()) {
        EXPECT_FALSE(sums_by<6>(*kernels, o, 0, six)) << n << " " << bad;
        EXPECT_FALSE(sums_by<7>(*kernels, o, 900, seven)) << n << " " << bad;
      }
      ViewResiduals residual_lengths(o.lens, o.view());
      EXPECT_TRUE(std::isinf(residual_lengths.at(state_of(o.pose))[bad]));
    }
}

TEST(ViewEquations, ResidualsAddUpToTheCost) {
  Random random(5);
  for (const Lens& lens : every_lens()) {
    const Observed o = observe(lens, 7, true, random);
    ViewResiduals lengths(lens, o.view());
    const std::span<const double> squares = lengths.at(state_of(o.pose));
    const VectorXd r = residuals(o, o.pose, 0);
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_NEAR(squares[i], r.segment<2>(2 * static_cast<Eigen::Index>(i)).squaredNorm(),
                  1e-9 * r.squaredNorm());
  }
}

}  // namespace
}  // namespace tagcal
