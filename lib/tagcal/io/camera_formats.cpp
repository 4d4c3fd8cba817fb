#include <array>

#include "tagcal/io/camera_file.hpp"

namespace tagcal {
namespace {

constexpr std::array<CameraFormat, 9> kFormats = {{
    {"tagcal", "tagcal's calibration; truth.yaml is read too", "all of tagcal", false},
    {"opencv", "cv::FileStorage: YAML, .xml, .json; intrinsics.yml of a stereo pair is read too",
     "4, 5 or 8 coefficients, fisheye (12 and 14 are read if the rest is 0)", false},
    {"kalibr", "camchain.yaml; sensor.yaml of EuRoC is read too",
     "pinhole with radtan or equidistant (ds, eucm, omni without distortion: read only)", true},
    {"ros", "camera_info YAML", "plumb_bob, rational_polynomial, equidistant", false},
    {"colmap", "a folder with cameras.txt, images.txt, points3D.txt; or cameras.txt",
     "PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE (SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL and "
     "their _FISHEYE are read too)",
     true},
    {"mrcal", "x.cameramodel", "PINHOLE, OPENCV4, 5, 8 (12 is read without thin prism)", false},
    {"nerfstudio", "transforms.json, of instant-ngp too", "OPENCV, OPENCV_FISHEYE", false},
    {"basalt", "calibration.json", "pinhole, pinhole-radtan8, kb4 (ds, eucm, ucm: read only)",
     true},
    {"tum", "a trajectory; written only", "none: poses only", false},
}};

}  // namespace

std::span<const CameraFormat> camera_formats() { return kFormats; }

std::string_view format_of_name(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  const std::string extension = file.extension().string();
  if (extension == ".cameramodel") return "mrcal";
  if (extension == ".tum") return "tum";
  if (extension == ".xml") return "opencv";
  if (name == "cameras.txt") return "colmap";
  if (name == "transforms.json") return "nerfstudio";
  if (name.ends_with("camchain.yaml")) return "kalibr";
  return "";
}

}  // namespace tagcal
