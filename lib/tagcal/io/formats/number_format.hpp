#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Numbers, texts and matrices as files of other programs write them. Every number reads back as the
// same double.

namespace tagcal::internal {

// With a point, or .Nan, .Inf: YAML 1.1 takes 1e-05 for a text.
std::string dotted_number(double value);
std::string dotted_list(std::span<const double> values);  // [1.0, 2.5]

std::string json_text(std::string_view text);  // in double quotes

// 3 x 3 or 4 x 4 as a list of rows, [[..], [..]].
std::string rows_text(const Eigen::MatrixXd& matrix);

// A matrix of doubles as cv::FileStorage writes it to YAML, one row per line; `indent` is that of
// the key. Columns of pixels, OpenCV's type 2d, are x, y, x, y, ..
std::string number_yaml(double value);
std::string matrix_yaml(std::string_view key, const Eigen::MatrixXd& matrix, int indent = 0,
                        bool is_of_pixels = false);

// A list of texts below a key.
std::string texts_yaml(std::string_view key, std::span<const std::string_view> texts);
std::string texts_yaml(std::string_view key, const std::vector<std::string>& texts);

}  // namespace tagcal::internal
