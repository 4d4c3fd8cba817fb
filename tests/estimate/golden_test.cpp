#include <gtest/gtest.h>

#include <filesystem>

#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/dataset_file.hpp"

namespace tagcal {
namespace {

const std::filesystem::path kDesk =
    std::filesystem::path(TAGCAL_SOURCE_DIR) / "data-synthetic/golden/desk";

TEST(Golden, DeskCalibratesToItsTruth) {
  const DatasetFolder folder = read_dataset(kDesk);
  ASSERT_TRUE(folder.dataset.truth.has_value());
  const Calibration c = calibrate(folder.dataset);
  ASSERT_EQ(c.status, Status::ok);
  EXPECT_EQ(c.model, "opencv4");
  const auto exact = parameters(folder.dataset.truth->camera.lens);
  for (std::size_t i = 0; i < exact.size(); ++i)
    EXPECT_LE(std::abs(parameters(c.camera->lens)[i] - exact[i]), 4 * c.sigmas[i]) << i;
  EXPECT_LT(c.sigma_px, 0.01);
}

TEST(Golden, TruthProjectsToTheExactCorners) {
  const DatasetFolder folder = read_dataset(kDesk);
  const Truth& truth = *folder.dataset.truth;
  const auto points = points_in_world(folder.dataset.boards);
  int count = 0;
  for (const View& view :
       read_observations(kDesk / "observations_exact.csv", folder.dataset.boards)) {
    for (const Observation& o : view.observations) {
      const auto pixel =
          project(truth.camera.lens, truth.camera_from_world.at(view.image) * points.at(o.id));
      ASSERT_TRUE(pixel.has_value());
      EXPECT_LT((*pixel - o.pixel).norm(), 1e-9);
      ++count;
    }
  }
  EXPECT_GT(count, 1400);
}

}  // namespace
}  // namespace tagcal
