// Tags printed from a drawing of few pixels, to which the borders of their cells are rounded: where
// these are is found, so that corners are as exact as they claim.

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "corner_tally.hpp"
#include "markers_of_opencv.hpp"
#include "rendered_tag.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/detect/tag_fit/picture_terms.hpp"

namespace tagcal {
using namespace internal;
namespace {

constexpr double kSide = 60, kMiddle = 89.3;
constexpr int kCount = 20;

struct PrintTrials {
  Trials corners;
  int num_found = 0;  // tags whose lines are not those of equal cells
};

// A tag with a side of 60 px, tilted by up to 60 degrees, drawn with some pixels along it (0:
// exactly).
TagView print_view(int pixels, int border_bits, double gamma, Random& random) {
  TagViewSpec spec{kSide, random.uniform(0, 60), 0.8, 2};
  spec.border_bits = border_bits;
  TagScene tag(spec, random);
  tag.scene.camera = {pinhole(900, 900, kMiddle, kMiddle), {180, 180}};
  tag.scene.sensor.gamma = gamma;
  if (pixels > 0) tag.scene.print_grid_m = 1.0 / pixels;
  return tag.view(
      tag_pose(Eigen::Vector3d::UnitZ(), 900 / kSide, random.uniform(0, 60), random_turns(random)),
      random);
}

// Fits such tags, each with the terms that its own picture shows.
PrintTrials trials(int pixels, int border_bits, double gamma) {
  const TagFamily family = tag_family("tag36h11", border_bits);
  Random random(79);
  Tally tally;
  PrintTrials result;
  for (int i = 0; i < kCount; ++i) {
    const TagView view = print_view(pixels, border_bits, gamma, random);
    const TagPattern equal = tag_pattern(family, view.id, border_bits);
    const Corners start = moved(view.corners, 0.2, random);
    const PictureTerms terms = terms_of_picture(view.image, {{&equal, start}});
    result.num_found += !terms.print.is_none();
    tally.add(fit_tag_with(terms, view.image, equal, start, {}).value_or(TagFit()), view.corners);
  }
  result.corners = tally.result();
  return result;
}

void expect_as_exact_as_of_equal_cells(int border_bits, double gamma) {
  const PrintTrials exact = trials(0, border_bits, gamma);
  EXPECT_EQ(exact.num_found, 0);
  const int cells = 6 + 2 * border_bits;
  for (const int pixels : {6 * cells + 5, 9 * cells + 3, 13 * cells + 5}) {
    const PrintTrials t = trials(pixels, border_bits, gamma);
    EXPECT_EQ(t.corners.failed, 0) << pixels;
    EXPECT_EQ(t.num_found, kCount) << pixels;
    EXPECT_LT(t.corners.rms, 1.1 * exact.corners.rms) << pixels;
    EXPECT_NEAR(t.corners.nees, exact.corners.nees, 0.2) << pixels;
  }
}

TEST(PrintedLines, CornersAreAsExactAsOfEqualCells) {
  expect_as_exact_as_of_equal_cells(1, 1);
  expect_as_exact_as_of_equal_cells(2, 1);
}

TEST(PrintedLines, GammaIsToldFromThem) { expect_as_exact_as_of_equal_cells(1, 0.5); }

// Another board in the picture may have another print.
TEST(PrintedLines, ATagKeepsItsOwn) {
  Random random(80);
  const TagFamily family = tag_family("tag36h11", 1);
  const PictureTerms terms{{}, {Eigen::VectorXd::LinSpaced(7, 1, 7) / 8.2}};
  for (int i = 0; i < 10; ++i) {
    const TagView view = print_view(0, 1, 1, random);
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    const auto exact = fit_tag_with({}, view.image, pattern, view.corners, {});
    const auto fit = fit_tag_with(terms, view.image, pattern, view.corners, {});
    ASSERT_TRUE(exact && fit);
    EXPECT_EQ(fit->corners, exact->corners);
  }
}

// A drawing as a lens shows it: seen askew and blurred, by the mean over 8 x 8 parts of each
// pixel, with noise of one level.
Image8 picture_of(const cv::Mat& drawing, const cv::Matx33d& picture_from_drawing) {
  constexpr int kParts = 8, kSize = 160;
  cv::Mat large, blurred, small;
  const double shift = (kParts - 1) / 2.0;
  const cv::Matx33d parts(kParts, 0, shift, 0, kParts, shift, 0, 0, 1);
  cv::warpPerspective(drawing, large, parts * picture_from_drawing,
                      {kSize * kParts, kSize * kParts}, cv::INTER_NEAREST, cv::BORDER_CONSTANT,
                      cv::Scalar(255));
  large.convertTo(large, CV_32F, 190.0 / 255, 30);
  cv::GaussianBlur(large, blurred, {}, 0.8 * kParts);
  cv::resize(blurred, small, {kSize, kSize}, 0, 0, cv::INTER_AREA);
  Random noise(3);
  Image8 image({kSize, kSize});
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      image(x, y) = cv::saturate_cast<std::uint8_t>(small.at<float>(y, x) + noise.normal());
  return image;
}

double largest_error(int marker_px) {
  // Four pixels are the corners of the marker's drawing: half a pixel outwards from their middles.
  const auto edge = static_cast<float>(marker_px) - 0.5F;
  const std::vector<cv::Point2f> drawn = {
      {-0.5F, -0.5F}, {edge, -0.5F}, {edge, edge}, {-0.5F, edge}};
  const std::vector<cv::Point2f> seen = {
      {41.3F, 37.8F}, {108.6F, 45.1F}, {112.2F, 113.7F}, {35.4F, 104.9F}};
  const Image8 image = picture_of(marker_of_opencv(cv::aruco::DICT_APRILTAG_36h11, 7, marker_px),
                                  cv::getPerspectiveTransform(drawn, seen));
  const auto tags = detect_tags(image, {"tag36h11", 1});
  if (tags.size() != 1) return 1e9;
  double largest = 0;
  for (const Eigen::Vector2d& corner : tags.front().corners) {
    double nearest = 1e9;
    for (const cv::Point2f& at : seen)
      nearest = std::min(nearest, std::hypot(corner.x() - at.x, corner.y() - at.y));
    largest = std::max(largest, nearest);
  }
  return largest;
}

TEST(PrintedLines, MarkersThatOpenCvDrew) {
  const double exact = largest_error(320);  // 40 pixels a cell
  EXPECT_LT(exact, 0.02);
  for (const int marker_px : {51, 53, 75, 100}) EXPECT_LT(largest_error(marker_px), 1.5 * exact);
}

}  // namespace
}  // namespace tagcal
