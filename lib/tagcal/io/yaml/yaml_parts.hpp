#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/camera/camera.hpp"
#include "tagcal/camera/model.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// Private to io: parts that several kinds of files have. Readers throw Error.

namespace tagcal::internal {

Eigen::Vector3d read_vector(const YamlValue& value);       // [x, y, z]
Eigen::Quaterniond read_rotation(const YamlValue& value);  // [w, x, y, z], of unit length

Eigen::Matrix4d read_affine_matrix(const YamlValue& value);  // 4x4 by rows, the last [0, 0, 0, 1]

// {rotation: [w, x, y, z], translation_m: [x, y, z]}, both optional, or a 4x4 matrix by rows.
Pose read_pose(const YamlValue& value);
std::string pose_yaml(const Pose& pose);

std::string list_yaml(std::span<const double> values);  // [a, b, c]
std::string text_yaml(std::string_view text);           // in double quotes

// The name of a picture, which is added to `names`: those of the list before it, from which it must
// differ, because pictures are found by name.
std::string read_image_name(const YamlValue& value, std::set<std::string>& names);

ImageSize read_image_size_value(const YamlValue& value);  // [width, height]

// The name of a model, but not `weak`, whose scale differs from view to view.
const Model& read_model(const YamlValue& value);

struct CameraNumbers {
  ImageSize image_size;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  std::vector<double> distortion;  // behind fx fy cx cy; as of the plain lens if not given
};

// Returns the camera. Throws if `model` cannot represent it; errors name `where`.
Camera make_camera(const CameraNumbers& numbers, const Model& model, const YamlValue& where);

// The coefficients behind fx fy cx cy, in OpenCV's order: of a perspective 8 if k4, k5 or k6 is not
// 0 or the model is opencv8, else 5; none for a parallel lens.
std::vector<double> distortion_of(const Lens& lens, std::string_view model);

}  // namespace tagcal::internal
