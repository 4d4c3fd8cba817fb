#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tagcal/io/formats/lens_numbers.hpp"
#include "tagcal/io/types.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// OpenCV's keys (camera_matrix, distortion_coefficients, ..), which files of tagcal and ROS have
// too: YAML and JSON of cv::FileStorage, and its XML.

namespace tagcal::internal {

bool has_opencv_keys(const YamlValue& top);

// The camera of tagcal, OpenCV or ROS; M1, D1, M2, D2 of a stereo pair; their views or
// extrinsic_parameters. `extrinsics`: the file with R and T of a pair, if it is another one.
CameraFile read_opencv(const YamlValue& top, const std::optional<YamlValue>& extrinsics = {});

// True for intrinsics of a stereo pair that need a file with R and T.
bool is_pair_without_place(const YamlValue& top);

// Adds the poses of the list `views`, of tagcal: image, rotation, translation_m. The camera is
// number 0.
void read_views(const YamlValue& views, CameraFile& file);

// ROS: the camera is that of the whole picture of a size. Notes the keys roi and binning_x,
// binning_y, by which the driver sends a part of it or bins its pixels. Throws Error if they are no
// numbers.
void note_sent_part(const YamlValue& top, const ImageSize& size, std::vector<std::string>& notes);

enum class StorageKind { yaml, xml, json };
StorageKind storage_kind(std::string_view extension);  // ".xml", ".json"; others are YAML

// Text as cv::FileStorage writes it, in one of its three forms.
class StorageText {
 public:
  explicit StorageText(StorageKind kind) : kind_(kind) {}

  void whole(std::string_view key, int value);
  void texts(std::string_view key, const std::vector<std::string>& texts);
  // Columns of pixels, OpenCV's type 2d, are x, y, x, y, ..
  void matrix(std::string_view key, const Eigen::MatrixXd& matrix, bool is_of_pixels = false);
  bool is_empty() const { return body_.empty(); }
  std::string text() const;

 private:
  void add(std::string_view key, const std::string& value);

  StorageKind kind_;
  std::string body_;
};

// One camera, or a stereo pair: in one file, or in a folder with intrinsics.yml and extrinsics.yml.
FormatOutput write_opencv(const CameraFile& file, StorageKind kind, bool as_folder = false);
FormatOutput write_ros(const CameraFile& file);

// The numbers of ROS' CameraInfo. Without a rectification its matrix is the identity, and the
// projection that of the camera.
struct CameraInfo {
  std::string model;  // plumb_bob, rational_polynomial or equidistant
  std::vector<double> distortion;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> camera, rectification;
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> projection;
};

// Throws Error, with the format's name, for lenses that it lacks.
CameraInfo camera_info(const FileCamera& camera, std::string_view format);

// The keys of YAML, JSON or the XML of cv::FileStorage. `file` is its name in messages. Throws
// Error.
YamlValue parse_storage(const std::string& text, const std::string& file);

// Sets the rectification of two placed cameras, as files of other programs have it beside the
// cameras: rectified pictures have pixels of both cameras only (`alpha` 0, as ROS' calibrator).
// A note says why if the pair cannot be rectified (rectify.hpp).
void set_rectification(CameraFile& file);

}  // namespace tagcal::internal
