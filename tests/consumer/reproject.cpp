// Undistorts a picture, and projects a point with the camera's uncertainty.
#include <iostream>
#include <tagcal/reproject/cameras.hpp>
#include <tagcal/reproject/resampling.hpp>
#include <tagcal/uncertainty/uncertain_camera.hpp>

int main() {
  const tagcal::Camera camera{
      tagcal::Perspective({600, 600, 319.5, 239.5, -0.2, 0.05, 0, 0, 0, 0, 0, 0}), {640, 480}};
  const tagcal::Image8 picture(camera.image_size, 200);  // or an ImageView of a cv::Mat's memory

  const tagcal::Camera flat = tagcal::pinhole_of_valid_pixels(camera, {640, 480});
  const tagcal::Reprojection chain{camera, flat, tagcal::Pose()};
  const auto [image, seen] = tagcal::reproject(picture, chain, {tagcal::Interpolation::lanczos4});
  std::cout << "f " << tagcal::parameters(flat.lens)[0] << ", corner " << int(image(0, 0))
            << ", seen " << int(seen(0, 0)) << "\n";

  // Variances of fx and fy, cx, cy: those of a calibration (Calibration::covariance).
  tagcal::UncertainCamera known{&tagcal::Model::named("f+c"), camera,
                                tagcal::MatrixX::Zero(3, 3)};
  known.covariance.diagonal() << 0.25, 0.01, 0.01;
  const auto pixel = tagcal::project(known, {{0.2, 0.1, 1}, 1e-6 * Eigen::Matrix3d::Identity()});
  if (pixel)
    std::cout << "pixel " << pixel->pixel.transpose() << ", variances "
              << pixel->covariance_px2.diagonal().transpose() << " px2\n";
}
