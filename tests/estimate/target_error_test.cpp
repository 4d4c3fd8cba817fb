// Targets that are wrong in every view, and right ones.

#include "tagcal/estimate/checks/target_error.hpp"
#include "calibrations.hpp"

#include <gtest/gtest.h>

#include "spoiled_worlds.hpp"
#include "tagcal/estimate/calibrate.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr char kSaid[] = "the target is not as its file says";

std::string said(const Calibration& c) {
  for (const std::string& warning : sentences(c.findings))
    if (warning.find(kSaid) != std::string::npos) return warning;
  return "";
}

Dataset with_moved_tag(std::uint64_t seed, int tag_id, double by_m) {
  WorldOptions options;
  options.num_views = 12;
  return seen_otherwise(make_world(opencv5_lens(), seed, options), options, [=](TargetPoint& p) {
    if (p.id.tag_id == tag_id) p.position.x() += by_m;
  });
}

Dataset bent(std::uint64_t seed, double by_m) {
  WorldOptions options;
  options.num_views = 12;
  options.sigma_px = 0.1;
  return seen_otherwise(make_world(opencv5_lens(), seed, options), options, [=](TargetPoint& p) {
    p.position.z() += by_m * (1 - std::pow(p.position.x() / 0.33 - 1, 2));
  });
}

TEST(TargetError, ATurnedCornerOrderIsNoAnswer) {
  for (const int turns : {1, 2, 3}) {
    SpoiledWorld world = untouched(make_world(opencv5_lens(), 3));
    for (std::size_t v = 0; v < world.dataset.views.size(); ++v)
      permute(world, v, rotating(-1, turns));
    for (const char* model : {"", "opencv5", "f"}) {
      const Calibration c = calibrate(world.dataset, with_model(model));
      EXPECT_FALSE(is_answer(c.status)) << turns << model;
      EXPECT_TRUE(c.projection.empty()) << turns << model;
    }
  }
}

TEST(TargetError, AMisplacedTagIsNamed) {
  for (const double by_mm : {0.7, 1.5, 5.0, 20.0}) {
    const Calibration c = calibrate(with_moved_tag(5, 17, 1e-3 * by_mm), with_model("opencv5"));
    ASSERT_EQ(c.status, Status::ok) << by_mm;
    double mm = 0;
    std::string expected = kSaid;
    expected += ": tag 17 is displaced by %lf";
    ASSERT_EQ(std::sscanf(said(c).c_str(), expected.c_str(), &mm), 1) << by_mm << ": " << said(c);
    EXPECT_NEAR(mm / by_mm, 1, 0.2);
    EXPECT_EQ(said(c).find("more tags"), std::string::npos) << said(c);
    EXPECT_NEAR(parameters(c.camera->lens)[0], 900, 4 * c.sigmas[0]) << by_mm;
  }
}

// A little off, it bends the answer, and that is said; more, and the boards take part one by one.
TEST(TargetError, ABoardThatHangsElsewhereInEveryView) {
  for (const double by_mm : {1.0, 2.0, 5.0, 50.0}) {
    const Pose by(Eigen::Quaterniond::Identity(), {1e-3 * by_mm, 0.5e-3 * by_mm, 0});
    const SpoiledWorld world = moved_board(opencv5_lens(), 3, 15, 0, 15, by);
    for (const char* model : {"", "opencv5"}) {
      const Calibration c = calibrate(world.dataset, with_model(model));
      if (is_answer(c.status) && said(c).empty()) {
        EXPECT_NE(c.findings.at(0).sentence.find("only its largest board is used"),
                  std::string::npos)
            << by_mm;
        EXPECT_NEAR(parameters(c.camera->lens)[0], 900, 4 * c.sigmas[0]) << by_mm << model;
      } else {
        EXPECT_NE(said(c), "") << by_mm << model;
        EXPECT_LT(by_mm, 5) << model;
      }
    }
  }
}

TEST(TargetError, GoodTargetsAreNotBlamed) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    WorldOptions options;
    options.num_views = 2 + static_cast<int>(seed);
    options.sigma_px = seed % 3 == 0 ? 1e-4 : 0.1 * static_cast<double>(seed);
    options.outlier_share = seed % 2 == 0 ? 0.05 : 0;
    const Dataset world = make_world(opencv5_lens(), seed, options);
    for (const char* model : {"f", "radial1", "opencv5", "opencv8"})
      EXPECT_EQ(said(calibrate(world, with_model(model))), "") << seed << model;
  }
  EXPECT_EQ(said(calibrate(make_world(fisheye_lens(), 3), with_model("fisheye4"))), "");
  EXPECT_EQ(said(calibrate(make_world(fisheye_lens(), 3), with_model("opencv5"))), "");
}

// Out of its plane: the warning of a bent board says more.
TEST(TargetError, ABentBoardIsNotMisprinted) {
  for (const double by_m : {0.5e-3, 1e-3, 2e-3}) {
    const Calibration c = calibrate(bent(4, by_m), with_model("opencv5"));
    EXPECT_EQ(c.status, Status::ok);
    EXPECT_EQ(said(c), "") << by_m;
  }
}

}  // namespace
}  // namespace tagcal
