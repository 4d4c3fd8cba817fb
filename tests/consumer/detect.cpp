// Finds the corners of a board in a picture.
#include <cmath>
#include <iostream>
#include <tagcal/detect/detector.hpp>
#include <tagcal/io/image_file.hpp>

int main() {
  const tagcal::AprilGrid grid{.columns = 4,
                               .rows = 3,
                               .tag_size = 0.06,
                               .tag_spacing = 0.3,
                               .border_bits = 1,
                               .corner_squares = false};
  const tagcal::PlacedBoard board{tagcal::make_board(grid), tagcal::Pose()};
  const tagcal::Image8 image = tagcal::read_image("board.png");

  const tagcal::DetectedPicture found = tagcal::detect(image, {board}, {}, "board.png");
  for (const std::string& warning : found.warnings) std::cerr << warning << "\n";
  for (const tagcal::Observation& seen : found.view.observations) {
    std::cout << seen.id.tag_id << ":" << seen.id.corner << " " << seen.pixel.transpose();
    if (seen.covariance_px2) std::cout << " sd " << std::sqrt(seen.covariance_px2->trace() / 2);
    std::cout << "\n";
  }
}
