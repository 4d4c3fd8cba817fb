#include "tagcal/estimate/pose/pose_ransac.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "worlds.hpp"

namespace tagcal {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSigma = 0.3;
const Lens kCentredLens = centred_pinhole(900);

// A view with wrong corners.
struct Spoilt {
  std::vector<Vector3d> points;
  std::vector<Vector2d> pixels;
  std::vector<int> ids;
  std::vector<Matrix2> whitening = {};
  Pose pose;
  std::vector<std::size_t> good;

  RansacProblem robust(const Lens& lens, bool with_ids = false, std::uint64_t seed = 0) const {
    return {lens,
            {points, pixels, whitening},
            with_ids ? std::span<const int>(ids) : std::span<const int>(),
            whitening.empty() ? kSigma : 1,
            seed};
  }
};

enum class Wrong { corners, tags, swapped };

Vector2d anywhere(Random& random) { return {random.uniform(0, 1280), random.uniform(0, 800)}; }

Spoilt draw(const std::vector<Vector3d>& points, const Pose& pose, double share, Wrong wrong,
            Random& random) {
  Spoilt s{points, {}, {}, {}, pose, {}};
  const auto seen = seen_by(kCentredLens, points, pose, kSigma, random);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    s.pixels.push_back(seen[k].pixel);
    s.ids.push_back(static_cast<int>(k / 4));
  }
  const std::size_t count = wrong == Wrong::corners ? 1 : 4;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < seen.size(); k += count) order.push_back(k);
  for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random.index(k)]);
  order.resize(static_cast<std::size_t>(share * static_cast<double>(order.size())));
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < seen.size(); k += count) {
    const bool is_wrong = std::binary_search(order.begin(), order.end(), k);
    // A tag with a wrong id: its corners are at those of another tag.
    const std::size_t other = (k + 4 + 4 * random.index(seen.size() / 4 - 1)) % seen.size();
    const std::size_t turn = 1 + random.index(3);
    for (std::size_t i = k; i < k + count; ++i) {
      if (!is_wrong) s.good.push_back(i);
      if (!is_wrong) continue;
      if (wrong == Wrong::corners) s.pixels[i] = anywhere(random);
      if (wrong == Wrong::tags) s.pixels[i] = seen[other + i - k].pixel;
      if (wrong == Wrong::swapped) s.pixels[i] = seen[k + (i - k + turn) % 4].pixel;
    }
  }
  return s;
}

Pose some_view(Random& random) {
  return looking_at_board(Vector3d::Zero(), random.uniform(0.4, 0.9), 1.2, random);
}

// True if the consensus has nearly all correct corners and no clearly wrong one.
template <int N>
bool is_right(const std::optional<PoseConsensus>& consensus, const Spoilt& s) {
  if (!consensus) return false;
  std::vector<std::size_t> both;
  std::set_intersection(s.good.begin(), s.good.end(), consensus->inliers.begin(),
                        consensus->inliers.end(), std::back_inserter(both));
  const bool complete =
      static_cast<double>(both.size()) > 0.97 * static_cast<double>(s.good.size()) - 1;
  const bool clean = consensus->inliers.size() - both.size() <= 2;  // by chance within 1.2 px
  const bool focal = N == 6 || std::abs(std::log(consensus->model.focal_px / 900)) < 0.15;
  return complete && clean && focal &&
         std::is_sorted(consensus->inliers.begin(), consensus->inliers.end()) &&
         angle_between_rad(pose_of(consensus->model), s.pose) < (N == 6 ? 0.02 : 0.1);
}

template <int N>
void expect_found(const std::vector<Vector3d>& points, Wrong wrong, double share, bool with_ids) {
  Random random(1);
  int right = 0;
  constexpr int kTrials = 20;
  for (int i = 0; i < kTrials; ++i) {
    const Spoilt s = draw(points, some_view(random), share, wrong, random);
    right += is_right<N>(pose_ransac<N>(s.robust(kCentredLens, with_ids)), s);
  }
  EXPECT_EQ(right, kTrials) << N << " " << static_cast<int>(wrong) << " " << share << " "
                            << with_ids;
}

TEST(PoseRansac, FindsABoardAmongUpTo80PercentWrongCorners) {
  for (const double share : {0.0, 0.2, 0.5, 0.8})
    for (const Wrong wrong : {Wrong::corners, Wrong::tags, Wrong::swapped})
      for (const bool with_ids : {false, true}) {
        expect_found<6>(board_points(), wrong, share, with_ids);
        expect_found<7>(board_points(), wrong, share, with_ids);
      }
}

TEST(PoseRansac, FindsPointsInSpace) {
  Random random(2);
  const std::vector<Vector3d> points = points_in_box(60, 0.3, 1, random);
  for (const double share : {0.0, 0.3, 0.6}) {
    expect_found<6>(points, Wrong::corners, share, false);
    expect_found<7>(points, Wrong::corners, share, false);
  }
}

TEST(PoseRansac, RejectsPixelsWithoutARayAndPointsBehind) {
  Random random(3);
  const Lens lens = Perspective({900, 900, 640, 400, -0.3, 0, 0, 0, 0});
  std::vector<Vector3d> points = board_points();
  const Pose pose(exp_rotation({0.5, 0, 0}), {0, 0, 1.2});
  Spoilt s{points, {}, {}, {}, pose, {}};
  for (std::size_t k = 0; k < points.size(); ++k) {
    s.pixels.push_back(*project(lens, pose * points[k]));
    if (k % 3 == 0)
      s.pixels.back() = {5000, 5000};  // beyond the fold
    else if (k % 7 == 0)
      s.points[k] = pose.inverse() * Vector3d(0.1, 0.1, -1);
    else
      s.good.push_back(k);
  }
  const auto consensus = pose_ransac<6>(s.robust(lens));
  ASSERT_TRUE(consensus);
  EXPECT_EQ(consensus->inliers, s.good);
}

TEST(PoseRansac, TheToleranceFollowsTheCovariances) {
  Random random(4);
  Spoilt s = draw(board_points(), some_view(random), 0, Wrong::corners, random);
  for (std::size_t k = 0; k < s.pixels.size(); ++k) {
    const double sigma = k % 2 == 0 ? 0.3 : 5;
    s.whitening.push_back(Matrix2::Identity() / sigma);
    if (k % 2 == 1) s.pixels[k] += 5 * Vector2d(random.normal(), random.normal());
  }
  s.pixels[10].x() += 6;  // 20 of its sigma
  s.pixels[11].x() += 6;
  const auto consensus = pose_ransac<6>(s.robust(kCentredLens));
  ASSERT_TRUE(consensus);
  const auto& in = consensus->inliers;
  EXPECT_FALSE(std::binary_search(in.begin(), in.end(), 10u));
  EXPECT_TRUE(std::binary_search(in.begin(), in.end(), 11u));
  EXPECT_GT(in.size(), 138u);
}

template <int N>
void expect_repeatable() {
  Random random(5);
  for (int i = 0; i < 5; ++i) {
    const Spoilt s = draw(board_points(), some_view(random), 0.6, Wrong::corners, random);
    const auto a = pose_ransac<N>(s.robust(kCentredLens, true, 11));
    const auto b = pose_ransac<N>(s.robust(kCentredLens, true, 11));
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->model.rotation, b->model.rotation);
    EXPECT_EQ(a->model.translation, b->model.translation);
    EXPECT_EQ(a->model.focal_px, b->model.focal_px);
    EXPECT_EQ(a->inliers, b->inliers);
    EXPECT_EQ(a->num_samples, b->num_samples);
  }
}

TEST(PoseRansac, EqualSeedsGiveEqualResults) {
  expect_repeatable<6>();
  expect_repeatable<7>();
}

TEST(PoseRansac, SeedsChangeTheSamples) {
  Random random(6);
  const Spoilt s = draw(board_points(), some_view(random), 0.6, Wrong::corners, random);
  int different = 0;
  const auto first = pose_ransac<6>(s.robust(kCentredLens, false, 0));
  for (std::uint64_t seed = 1; seed < 6; ++seed)
    different +=  // in the last bits
        pose_ransac<6>(s.robust(kCentredLens, false, seed))->model.rotation !=
        first->model.rotation;
  EXPECT_GT(different, 0);
}

// If 3 of 100 tags are right, single points hardly ever make a correct sample.
TEST(PoseRansac, WholeTagsAreSampled) {
  Random random(7);
  std::vector<Vector3d> points;
  for (const TargetPoint& p : target_points(make_board(AprilGrid{10, 10, 0.05, 0.3, 0})))
    points.push_back(p.position - Vector3d(0.325, 0.325, 0));
  int with_ids = 0, without = 0;
  for (int i = 0; i < 3; ++i) {
    Spoilt s = draw(points, some_view(random), 0.97, Wrong::tags, random);
    ASSERT_EQ(s.good.size(), 12u);
    for (std::size_t k = 0; k < s.pixels.size(); ++k)  // three equal errors agree as well
      if (!std::binary_search(s.good.begin(), s.good.end(), k)) s.pixels[k] = anywhere(random);
    with_ids += is_right<7>(pose_ransac<7>(s.robust(kCentredLens, true)), s);
    without += is_right<7>(pose_ransac<7>(s.robust(kCentredLens, false)), s);
  }
  EXPECT_EQ(with_ids, 3);
  EXPECT_LT(without, 3);
}

TEST(PoseRansac, FewOutliersTakeFewSamples) {
  Random random(8);
  const Spoilt all = draw(board_points(), some_view(random), 0, Wrong::corners, random);
  EXPECT_LT(pose_ransac<6>(all.robust(kCentredLens))->num_samples, 20);
  const Spoilt half = draw(board_points(), some_view(random), 0.5, Wrong::corners, random);
  EXPECT_LT(pose_ransac<6>(half.robust(kCentredLens))->num_samples, 400);
}

template <int N>
void expect_none(std::size_t n, double far) {
  Random random(9);
  for (int i = 0; i < 3; ++i) {
    Spoilt s;
    s.points = board_points();
    std::rotate(s.points.begin(), s.points.begin() + 4 * i, s.points.end());
    s.points.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      s.pixels.push_back(anywhere(random));
      s.ids.push_back(static_cast<int>(k / 4));
    }
    if (far > 0) s.pixels[0].setConstant(far);
    EXPECT_FALSE(pose_ransac<N>(s.robust(kCentredLens, true))) << n << " " << far;
  }
}

TEST(PoseRansac, RandomDataHaveNoConsensus) {
  for (const std::size_t n : {4u, 5u, 8u, 40u, 144u}) {
    expect_none<6>(n, 0);
    if (n > 5) expect_none<7>(n, 0);
  }
}

// One distant pixel does not make the density of the others larger.
TEST(PoseRansac, RandomDataWithADistantPixelHaveNoConsensus) {
  for (const double far : {1e6, 1e12, 1e300}) {
    expect_none<6>(40, far);
    expect_none<7>(40, far);
  }
}

// Points near the plane of a mirror agree with a pose, but so do others nearly: the density of
// wrong corners around the tolerance counts (policy::kDensityTolerances).
TEST(PoseRansac, MirroredPointsHaveNoConsensus) {
  Random random(10);
  const Pose pose(exp_rotation({0.3, 0.2, 0.1}), {0, 0, 1.5});
  for (int i = 0; i < 20; ++i) {
    std::vector<Vector3d> points, mirrored;
    for (int k = 0; k < 40; ++k) {
      points.emplace_back(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3),
                          random.uniform(-0.3, 0.3));
      mirrored.push_back(points.back().cwiseProduct(Vector3d(1, 1, -1)));
    }
    std::vector<Vector2d> pixels;
    for (const Correspondence& c : seen_by(kCentredLens, mirrored, pose, 0.2, random))
      pixels.push_back(c.pixel);
    EXPECT_FALSE(pose_ransac<6>({kCentredLens, {points, pixels}, {}, kSigma})) << i;
  }
}

TEST(PoseRansac, NoPointsHaveNoConsensus) {
  EXPECT_FALSE(pose_ransac<6>({kCentredLens, {}, {}}));
  EXPECT_FALSE(pose_ransac<7>({kCentredLens, {}, {}}));
  const std::vector<Vector3d> points(20, Vector3d(0.1, 0, 0));
  const std::vector<Vector2d> pixels(20, Vector2d(500, 300));
  EXPECT_FALSE(pose_ransac<6>({kCentredLens, {points, pixels}, {}}));
  EXPECT_FALSE(pose_ransac<7>({kCentredLens, {points, pixels}, {}}));
}

}  // namespace
}  // namespace tagcal
