#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <cmath>
#include <filesystem>
#include <map>

#include "spoiled_worlds.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/dataset_file.hpp"

// Errors of a board's print that all views share.

namespace tagcal {
namespace {

const Lens kBarrel = Perspective({900, 900, 651, 392, -0.1});

// Views of an upright board whose points are displaced by sigma_m along each axis.
Dataset misprinted_world(std::uint64_t seed, double sigma_m, const WorldOptions& options) {
  Dataset world = make_world(kBarrel, seed, options);
  std::erase_if(world.views, [&](const View& view) {
    const Eigen::Matrix3d r = world.truth->camera_from_world.at(view.image).rotation_matrix();
    return std::abs(std::atan2(r(1, 0), r(0, 0))) > 0.3;
  });
  Random random(seed, 5);
  const auto displace = [&](TargetPoint& p) {
    for (double& x : p.position) x += sigma_m * random.normal();
  };
  return seen_otherwise(world, options, displace, seed);
}

// The mean of z^2 of the focal length and the principal point.
double mean_nees(double sigma_m) {
  WorldOptions options;
  options.num_views = 400;
  options.sigma_px = 0.05;
  options.max_tilt_deg = 30;
  CalibrateOptions named;
  named.model = "radial1";
  double nees = 0;
  constexpr int kWorlds = 20;
  for (int seed = 1; seed <= kWorlds; ++seed) {
    const Calibration c = calibrate(misprinted_world(seed, sigma_m, options), named);
    EXPECT_EQ(c.status, Status::ok) << seed;
    const auto values = parameters(c.camera->lens), truth = parameters(kBarrel);
    const Eigen::Vector3d e(values[0] - truth[0], values[2] - truth[2], values[3] - truth[3]);
    const Eigen::Matrix3d covariance = c.covariance.topLeftCorner<3, 3>();  // of f, cx, cy
    nees += e.dot(covariance.ldlt().solve(e)) / 3 / kWorlds;
  }
  return nees;
}

TEST(PointErrors, ArePartOfTheClaim) {
  const double of_print = mean_nees(0.12e-3);  // 0.1 px
  EXPECT_GT(of_print, 0.3);
  EXPECT_LT(of_print, 1.5);
  const double of_noise = mean_nees(0);
  EXPECT_GT(of_noise, 0.5);
  EXPECT_LT(of_noise, 1.5);
}

// The mean residual of each point over the views, turned into the axes of the board.
std::map<CornerId, Eigen::Vector2d> mean_residuals(const char* set) {
  const auto folder = std::filesystem::path(TAGCAL_SOURCE_DIR) / "tests/data/real_corners" / set;
  const Dataset dataset = read_dataset(folder).dataset;
  std::map<CornerId, Eigen::Vector2d> sums;
  const Calibration c = calibrate(dataset);
  for (const CalibratedView& view : c.views) {
    const auto& seen = dataset.views[view.view].observations;
    if (seen.size() != view.residuals_px.size()) continue;  // with outliers
    const Eigen::Matrix2d axes = view.camera_from_world.rotation_matrix().topLeftCorner<2, 2>();
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix2d turn = svd.matrixV() * svd.matrixU().transpose();
    for (std::size_t i = 0; i < seen.size(); ++i)
      sums.try_emplace(seen[i].id, Eigen::Vector2d::Zero()).first->second +=
          turn * view.residuals_px[i];
  }
  return sums;
}

// Two cameras that saw one print, each calibrated by its own pictures.
TEST(PointErrors, AreThoseOfThePrint) {
  const auto left = mean_residuals("bouguet_left"), right = mean_residuals("bouguet_right");
  ASSERT_EQ(left.size(), 54u);
  double product = 0, of_left = 0, of_right = 0;
  for (const auto& [id, a] : left) {
    product += a.dot(right.at(id));
    of_left += a.squaredNorm();
    of_right += right.at(id).squaredNorm();
  }
  EXPECT_GT(product / std::sqrt(of_left * of_right), 0.7);
}

}  // namespace
}  // namespace tagcal
