#include "tagcal/io/formats/number_format.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tagcal/internal/text.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {

std::string dotted_number(double value) {
  if (!std::isfinite(value)) return number_yaml(value);
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (text.find('.') == std::string::npos)
    text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
  return text;
}

std::string dotted_list(std::span<const double> values) {
  return "[" + joined(values, ", ", dotted_number) + "]";
}

std::string json_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += byte < 0x20 || byte == 0x7f ? fmt::format("\\u{:04x}", byte) : std::string(1, c);
  }
  return quoted + '"';
}

std::string rows_text(const Eigen::MatrixXd& matrix) {
  std::string text;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    const Eigen::RowVectorXd values = matrix.row(row);
    text += (row == 0 ? "" : ", ") +
            dotted_list({values.data(), static_cast<std::size_t>(values.size())});
  }
  return "[" + text + "]";
}

std::string number_yaml(double value) {
  if (std::isnan(value)) return ".Nan";
  if (std::isinf(value)) return value > 0 ? ".Inf" : "-.Inf";
  return fmt::format("{}", value);
}

std::string matrix_yaml(std::string_view key, const Eigen::MatrixXd& matrix, int indent,
                        bool is_of_pixels) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  std::string data;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    data += row == 0 ? " " : ",\n" + margin + "      ";
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      data += (column == 0 ? "" : ", ") + number_yaml(matrix(row, column));
  }
  return fmt::format(
      "{0}: !!opencv-matrix\n{1}   rows: {2}\n{1}   cols: {3}\n{1}   dt: {4}\n{1}   data: [{5} ]\n",
      key, margin, matrix.rows(), matrix.cols() / (is_of_pixels ? 2 : 1),
      is_of_pixels ? "\"2d\"" : "d", data);
}

std::string texts_yaml(std::string_view key, std::span<const std::string_view> texts) {
  std::string list;
  for (const std::string_view text : texts) list += "\n   - " + text_yaml(text);
  return list.empty() ? fmt::format("{}: []\n", key) : fmt::format("{}:{}\n", key, list);
}

std::string texts_yaml(std::string_view key, const std::vector<std::string>& texts) {
  const std::vector<std::string_view> views(texts.begin(), texts.end());
  return texts_yaml(key, std::span<const std::string_view>(views));
}

}  // namespace tagcal::internal
