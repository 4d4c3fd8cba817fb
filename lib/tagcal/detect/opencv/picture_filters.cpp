#include "tagcal/detect/opencv/picture_filters.hpp"

#include <opencv2/imgproc.hpp>

#include "tagcal/detect/opencv/mat_of.hpp"

namespace tagcal::internal {

Image8 brightest(const ImageView8& image, int radius) {
  Image8 result(image.size());
  const int side = 2 * radius + 1;
  cv::dilate(mat_of(image), mat_of(result), cv::Mat::ones(side, side, CV_8U));
  return result;
}

ImageF smoothed(const ImageView8& image) {
  const cv::Matx<float, 1, 5> weights(1 / 16.F, 4 / 16.F, 6 / 16.F, 4 / 16.F, 1 / 16.F);
  ImageF result(image.size());
  cv::sepFilter2D(mat_of(image), cv::Mat(image.height(), image.width(), CV_32F, result.row(0)),
                  CV_32F, weights, weights, {-1, -1}, 0, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace tagcal::internal
