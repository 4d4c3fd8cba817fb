#include "job/camera_input.hpp"

#include <fmt/format.h>

#include "job/messages.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {

CalibrationFile read_camera(const std::string& file_and_name, std::vector<std::string>& notes) {
  const CameraFile file = read_one_camera(file_and_name);
  CalibrationFile camera = usable_camera(file, file_and_name);
  for (const std::string& note : file.notes)
    notes.push_back(fmt::format("{}: {}", file_and_name, note));
  return camera;
}

CalibrationFile read_camera(const std::string& file_and_name) {
  std::vector<std::string> notes;
  CalibrationFile camera = read_camera(file_and_name, notes);
  for (const std::string& note : notes) print_to_stderr("{}\n", note);
  return camera;
}

void print_notes(const std::string& name, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) print_to_stderr("{}: {}\n", name, note);
}

}  // namespace tagcal::tools
