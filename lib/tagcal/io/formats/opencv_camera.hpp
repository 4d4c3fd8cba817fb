#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/types.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"

// One camera by OpenCV's keys and tagcal's own.

namespace tagcal::internal {

// {rows, cols, data}, with or without OpenCV's tag.
Eigen::MatrixXd read_matrix(const YamlValue& value);

// The same with one row or one column.
std::vector<double> read_row(const YamlValue& value);

// The key `fixed`: lens parameters that were held.
std::map<std::string, double> fixed_values(const YamlValue& top);

// The keys of a file: those of the sample program, of the same before OpenCV 3, and of people who
// name them after OpenCV's arguments.
struct OpencvKeys {
  std::string_view width = "image_width";
  std::string_view height = "image_height";
  std::string_view matrix = "camera_matrix";
  std::string_view distortion = "distortion_coefficients";
};

OpencvKeys opencv_keys_of(const YamlValue& top);

// Reads the camera; appends a sentence to `notes` for each number that it drops or changes.
CalibrationFile read_opencv_camera(const YamlValue& top, const OpencvKeys& keys,
                                   std::vector<std::string>& notes);

// Reads tagcal's own keys about the uncertainty of a camera that was read: sigmas, covariance,
// claim, findings, the seen region. Files of other programs have none of them.
void read_uncertainty(const YamlValue& top, CalibrationFile& file);

// The findings of a file of tagcal.
std::vector<Finding> read_findings(const YamlValue& top);

}  // namespace tagcal::internal
