// A floor that passes below the eye, a segment in a window, and the front of a face.
#include <array>
#include <bitset>
#include <iostream>
#include <tagcal/viewing/clip.hpp>
#include <tagcal/viewing/projection.hpp>

int main() {
  // A frustum of 90 degrees, near 1 m, far 10 m; the floor is 0.5 m below the eye, from 4 m ahead
  // of it to 2 m behind it.
  const Eigen::Matrix4d clip_from_eye =
      tagcal::clip_from_eye({tagcal::Projection::perspective, {-1, 1, -1, 1}, 1, 10});
  std::vector<Eigen::Vector4d> floor;
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(-0.5, -0.5, -4), Eigen::Vector3d(0.5, -0.5, -4),
        Eigen::Vector3d(0.5, -0.5, 2), Eigen::Vector3d(-0.5, -0.5, 2)})
    floor.push_back(clip_from_eye * corner.homogeneous());
  for (const Eigen::Vector4d& x : floor)
    std::cout << "w " << x.w() << ": x/w " << x.x() / x.w() << ", y/w " << x.y() / x.w() << "\n";
  for (const Eigen::Vector4d& x : tagcal::clip_polygon_to_volume(floor))
    std::cout << "clipped: w " << x.w() << ", x/w " << x.x() / x.w() << ", y/w " << x.y() / x.w()
              << "\n";

  const tagcal::Window window{-1, 1, -1, 1};
  const tagcal::Segment2 segment{{-3, -0.75}, {1.5, 1.5}};
  std::cout << "codes " << std::bitset<4>(tagcal::outcode(window, segment.from)) << " "
            << std::bitset<4>(tagcal::outcode(window, segment.to)) << "\n";
  const auto part = tagcal::clip_line_cohen_sutherland(window, segment);
  if (!part) return 1;
  std::cout << "inside: from " << part->from.transpose() << " to " << part->to.transpose() << "\n";

  const std::array<Eigen::Vector3d, 3> face{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  std::cout << "back face from above: " << tagcal::is_back_face(face, {0, 0, 1})
            << ", from below: " << tagcal::is_back_face(face, {0, 0, -1}) << "\n";
}
