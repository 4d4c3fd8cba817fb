#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tagcal/random.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/scene/viewing.hpp"

namespace tagcal {
namespace {

using Eigen::Vector2d;

// The corners that OpenCV finds from their exact places on.
std::vector<cv::Point2f> fitted(const ImageF& light, const std::vector<Observation>& exact) {
  cv::Mat picture(light.height(), light.width(), CV_32F);
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) picture.at<float>(y, x) = light(x, y);
  std::vector<cv::Point2f> corners;
  for (const Observation& corner : exact)
    corners.emplace_back(static_cast<float>(corner.pixel.x()) + 0.3F,
                         static_cast<float>(corner.pixel.y()) - 0.2F);
  cv::cornerSubPix(picture, corners, {3, 3}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 200, 1e-4});
  return corners;
}

// Without noise, the crossings of a rendered checkerboard are where the exact corners are.
TEST(RenderCheckers, CrossingsAreTheExactCorners) {
  Random random(11);
  const Lens lenses[] = {Perspective({600, 598, 325, 196, -0.15, 0.05, 5e-4, -3e-4}),
                         Fisheye({400, 399, 316, 202, 0.02, -0.01})};
  for (const Lens& lens : lenses) {
    for (const bool with_markers : {false, true}) {
      const Checkerboard squares{
          .columns = 7, .rows = 5, .column_spacing = 0.04, .row_spacing = 0.04};
      Scene scene;
      scene.camera = {lens, {640, 400}};
      scene.sensor.blur_px = 0.8;
      // The family decides nothing here: all its cells are black.
      const TagFamily family{.name = "DICT_X",
                             .width_at_border = 6,
                             .total_width = 8,
                             .bits = {{1, 1}},
                             .codes = std::vector<std::uint64_t>(24)};
      scene.boards = {
          {with_markers ? make_board(Charuco{8, 6, 0.04, 0.02, family.name}) : make_board(squares),
           Pose(Eigen::Quaterniond::Identity(), {-0.12, -0.08, 0})}};
      const Pose upside(exp_rotation({random.uniform(2.7, 3.5), random.uniform(-0.3, 0.3), 0}),
                        {0, 0, 0.4});
      const auto exact = visible_corners(scene, upside);
      ASSERT_GE(exact.size(), 20U);
      const auto found = fitted(render_light(scene, {{family.name, family}}, upside), exact);
      Vector2d mean = Vector2d::Zero();
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const Vector2d error = Vector2d(found[i].x, found[i].y) - exact[i].pixel;
        EXPECT_LT(error.norm(), 0.06) << exact[i].id.tag_id;
        mean += error / static_cast<double>(exact.size());
      }
      EXPECT_LT(mean.norm(), 0.01);
    }
  }
}

}  // namespace
}  // namespace tagcal
