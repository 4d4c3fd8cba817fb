#include "tagcal/io/formats/formats.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "tagcal/error.hpp"
#include "tagcal/io/formats/number_format.hpp"
#include "tagcal/io/formats/opencv_format.hpp"
#include "tagcal/io/formats/text_lines.hpp"
#include "tagcal/io/text/limits.hpp"

namespace tagcal::internal {
namespace {

constexpr std::size_t kMostCoefficients = 14;  // of any lens of OpenCV

// What all texts of ROS say of a camera.
struct RosCamera {
  ImageSize size;
  std::string name;
  std::string model = "plumb_bob";  // of the distortion
  std::vector<double> matrix;       // 3 x 3, by rows
  std::vector<double> distortion;
};

// The camera by the keys of camera_info YAML, which have one reader.
CameraFile read_by_keys(const RosCamera& camera, const std::string& file) {
  const std::string text = fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\ndistortion_model: {}\n"
      "camera_matrix: {{rows: 3, cols: 3, data: {}}}\n"
      "distortion_coefficients: {{rows: 1, cols: {}, data: {}}}\n",
      camera.size.width, camera.size.height, camera.name.empty() ? "camera" : camera.name,
      camera.model, dotted_list(camera.matrix), camera.distortion.size(),
      dotted_list(camera.distortion));
  return read_opencv(YamlValue::parse(text, file));
}

bool has_line(std::string_view text, std::string_view begin) {
  for (std::size_t at = 0; at != std::string_view::npos; at = text.find(begin, at + 1))
    if (text.substr(at).starts_with(begin) && (at == 0 || text[at - 1] == '\n')) return true;
  return false;
}

// The numbers of a message. One that no driver filled in has zeros, or what was in the memory.
std::vector<double> numbers_of(const YamlValue& value, std::size_t least, std::size_t most) {
  std::vector<double> numbers = value.numbers(least, most);
  for (const double number : numbers)
    if (number != 0 && !std::isnormal(number))
      value.fail_plainly(fmt::format(
          "has the number {}, which no camera has: the message was not filled in", number));
  return numbers;
}

// The key in lower case, as ROS 2 has it, or in upper case.
YamlValue either(const YamlValue& top, const char* lower, const char* upper) {
  const auto found = top.find(lower);
  return found ? *found : top.at(upper);
}

}  // namespace

bool is_ros_ini(std::string_view text) {
  return has_line(text, "[image]") && has_line(text, "camera matrix");
}

CameraFile read_ros_ini(const CameraText& ini) {
  const std::string file = ini.path.string();
  TextLines lines(file, ini.text);
  RosCamera camera;
  const auto next_numbers = [&](std::string_view what, std::vector<double>& numbers) {
    if (!lines.next()) lines.fail(fmt::format("{}: numbers must follow", what));
    for (std::size_t i = 0; i < lines.words().size(); ++i) numbers.push_back(lines.number(i, what));
  };
  const auto next_side = [&](std::string_view what) {
    if (!lines.next()) lines.fail(fmt::format("{}: a number must follow", what));
    return lines.whole(0, what, 1, limits::kMaxSidePx);
  };
  while (lines.next()) {
    const std::string line(lines.line());
    if (line.starts_with("width")) camera.size.width = next_side("width");
    if (line.starts_with("height")) camera.size.height = next_side("height");
    if (line.starts_with("distortion")) next_numbers("distortion", camera.distortion);
    if (line.starts_with("[") && !line.starts_with("[image]"))
      camera.name = line.substr(1, line.find(']') - 1);
    if (!line.starts_with("camera matrix")) continue;
    for (int row = 0; row < 3; ++row) next_numbers("camera matrix", camera.matrix);
  }
  if (camera.matrix.size() != 9)
    throw Error(file + ": camera matrix: must have 3 rows of 3 numbers");
  if (camera.distortion.size() > 5) camera.model = "rational_polynomial";
  return read_by_keys(camera, file);
}

bool is_ros_message(std::string_view text) {
  return has_line(text, "distortion_model:") && (has_line(text, "k:") || has_line(text, "K:")) &&
         (has_line(text, "d:") || has_line(text, "D:"));
}

CameraFile read_ros_message(const CameraText& message) {
  const std::string &text = message.text, file = message.path.string();
  const std::size_t begin = text.starts_with("---") ? text.find('\n') + 1 : 0;
  const std::size_t end = text.find("\n---", begin);
  const YamlValue top = YamlValue::parse(text.substr(begin, end - begin), file);
  RosCamera camera;
  camera.size = {top.at("width").whole(1, limits::kMaxSidePx),
                 top.at("height").whole(1, limits::kMaxSidePx)};
  if (const auto header = top.find("header"); header && header->is_map())
    if (const auto frame = header->find("frame_id"); frame && frame->is_scalar())
      camera.name = json_text(frame->text());
  camera.model = top.at("distortion_model").text();
  const YamlValue matrix = either(top, "k", "K");
  camera.matrix = numbers_of(matrix, 9, 9);
  if (camera.matrix[0] == 0 && camera.matrix[4] == 0)
    matrix.fail_plainly("has no focal length: this camera was not calibrated");
  camera.distortion = numbers_of(either(top, "d", "D"), 0, kMostCoefficients);
  CameraFile result = read_by_keys(camera, file);
  if (end != std::string::npos && text.find_first_not_of("- \r\n", end) != std::string::npos)
    result.notes.emplace_back("dropped: the messages after the first one");
  note_sent_part(top, camera.size, result.notes);
  return result;
}

}  // namespace tagcal::internal
