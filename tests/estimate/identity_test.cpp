#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

// A view is which it is by its number: names are for people, and decide nothing.

namespace tagcal {
namespace {

using Corners = std::set<std::pair<std::size_t, std::size_t>>;

Corners rejected(const Calibration& c) {
  Corners corners;
  for (const Outlier& o : c.outliers) corners.emplace(o.view, o.corner);
  return corners;
}

template <typename Name>
Dataset named(Dataset dataset, Name name) {
  for (std::size_t i = 0; i < dataset.views.size(); ++i) dataset.views[i].image = name(i);
  return dataset;
}

// Bit for bit.
void expect_same(const Calibration& a, const Calibration& b) {
  ASSERT_EQ(a.status, b.status);
  EXPECT_EQ(a.model, b.model);
  EXPECT_TRUE(std::ranges::equal(parameters(a.camera->lens), parameters(b.camera->lens)));
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(rejected(a), rejected(b));
  EXPECT_EQ(a.rms_px, b.rms_px);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].view, b.views[i].view);
    const Pose &p = a.views[i].camera_from_world, &q = b.views[i].camera_from_world;
    EXPECT_EQ(p.rotation().coeffs(), q.rotation().coeffs());
    EXPECT_EQ(p.translation(), q.translation());
    // Model weak has none of some.
    EXPECT_EQ(std::memcmp(&a.views[i].covariance, &b.views[i].covariance, sizeof(Matrix6)), 0);
  }
}

Dataset with_wrong_corners(const Lens& lens, int num_views, double share) {
  WorldOptions options;
  options.num_views = num_views;
  options.outlier_share = share;
  return make_world(lens, 4711, options);
}

// Two views that were taken in motion, one with two corners only.
Dataset with_wrong_views(Dataset dataset) {
  for (const std::size_t moved : {3U, 8U})
    for (Observation& o : dataset.views[moved].observations)
      o.pixel += 2.5e-5 * o.pixel.squaredNorm() * Eigen::Vector2d(1, 0.3);
  dataset.views[7].observations.resize(2);
  return dataset;
}

std::vector<Dataset> sets() {
  return {with_wrong_corners(opencv5_lens(), 12, 0), with_wrong_corners(opencv5_lens(), 12, 0.05),
          with_wrong_views(with_wrong_corners(opencv5_lens(), 12, 0.02)),
          with_wrong_corners(fisheye_lens(), 12, 0.03)};
}

class Identity : public testing::TestWithParam<const char*> {};

TEST_P(Identity, NamesDecideNothing) {
  CalibrateOptions options;
  options.model = GetParam();
  for (const Dataset& set : sets()) {
    const Calibration usual = calibrate(set, options);
    ASSERT_TRUE(usual.camera);
    expect_same(usual, calibrate(named(set, [](std::size_t) { return ""; }), options));
    expect_same(usual, calibrate(named(set, [](std::size_t) { return "a.png"; }), options));
    const auto turned = [](std::size_t i) { return std::to_string(100 - i); };
    expect_same(usual, calibrate(named(set, turned), options));
  }
}

INSTANTIATE_TEST_SUITE_P(Models, Identity, testing::Values("auto", "opencv5", "weak"));

// The order of the views makes other sums, and other halves.
TEST(IdentityOfViews, TheirOrderDecidesNothing) {
  for (const Dataset& set : sets()) {
    Dataset other = set;
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < set.views.size(); ++i)
      order.push_back((7 * i + 3) % set.views.size());
    for (std::size_t i = 0; i < order.size(); ++i) other.views[i] = set.views[order[i]];
    const Calibration a = calibrate(set), b = calibrate(other);
    ASSERT_EQ(a.status, b.status);
    EXPECT_EQ(a.model, b.model);
    Corners back;
    for (const auto& [view, corner] : rejected(b)) back.emplace(order[view], corner);
    EXPECT_EQ(rejected(a), back);
    const auto p = parameters(a.camera->lens), q = parameters(b.camera->lens);
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(p[i], q[i], 1e-3 * a.sigmas[i]) << i;
  }
}

TEST(IdentityOfViews, OutliersAndViewsSayWhich) {
  const Dataset set = with_wrong_corners(opencv5_lens(), 12, 0.05);
  const Calibration c = calibrate(set);
  ASSERT_FALSE(c.outliers.empty());
  for (const Outlier& o : c.outliers) {
    EXPECT_EQ(set.views.at(o.view).image, o.image);
    EXPECT_EQ(set.views.at(o.view).observations.at(o.corner).id, o.id);
  }
  for (const CalibratedView& view : c.views) EXPECT_EQ(set.views.at(view.view).image, view.image);
}

TEST(IdentityOfViews, TwoThreadsAtOnceGetTheAnswersOfOne) {
  const std::vector<Dataset> both = {with_wrong_corners(opencv5_lens(), 12, 0.03),
                                     with_wrong_corners(fisheye_lens(), 12, 0.03)};
  std::vector<Calibration> alone, together(2);
  for (const Dataset& set : both) alone.push_back(calibrate(set));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 2; ++i)
    threads.emplace_back([&, i] { together[i] = calibrate(both[i]); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < 2; ++i) expect_same(alone[i], together[i]);
}

}  // namespace
}  // namespace tagcal
