// Where is the camera? A picture in the memory of OpenCV, a board, and any tags.
#include <algorithm>
#include <iostream>
#include <opencv2/core.hpp>
#include <tagcal/tagcal.hpp>

int main() {
  const tagcal::Image8 file = tagcal::read_image("board.png");
  cv::Mat grey(file.height(), file.width(), CV_8UC1);  // as a camera's driver gives it
  for (int y = 0; y < grey.rows; ++y) std::copy_n(file.row(y), grey.cols, grey.ptr(y));

  // The memory of the cv::Mat, not a copy.
  const tagcal::ImageView8 image(grey.ptr(), {grey.cols, grey.rows},
                                 static_cast<std::ptrdiff_t>(grey.step1()));
  const tagcal::Camera camera{tagcal::pinhole(600, 600, 319.5, 239.5), {640, 480}};
  const double camera_error_px = 0.02;  // of a calibration: CalibrationFile::camera_error_px
  const tagcal::AprilGrid grid{.columns = 4,
                               .rows = 3,
                               .tag_size = 0.06,
                               .tag_spacing = 0.3,
                               .border_bits = 1,
                               .corner_squares = false};
  const std::vector<tagcal::PlacedBoard> boards = {{tagcal::make_board(grid), tagcal::Pose()}};

  const tagcal::View view = tagcal::detect(image, boards).view;
  const tagcal::PoseEstimate pose =
      tagcal::estimate_pose(tagcal::view_correspondences(view, boards, camera_error_px), camera);
  if (!tagcal::is_answer(pose.status)) return 1;
  const tagcal::CameraInTarget robot = tagcal::camera_in_target(pose.hypotheses.front());
  std::cout << "camera at " << robot.position_m.transpose() << " m, azimuth " << robot.azimuth_rad
            << ", elevation " << robot.elevation_rad << " rad\n";
  // detect/detector.hpp: no board, ids may repeat
  for (const tagcal::DetectedTag& tag : tagcal::detect_tags(image, {.family = "tag36h11"}))
    std::cout << "tag " << tag.id << " at " << tag.corners[0].transpose() << "\n";
  std::cout << "tagcal " << TAGCAL_VERSION << "\n";
}
