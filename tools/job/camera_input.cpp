#include "job/camera_input.hpp"

#include <fmt/format.h>

#include "job/messages.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {

CalibrationFile read_camera(const std::string& file_and_name) {
  const CameraFile file = read_one_camera(file_and_name);
  CalibrationFile camera = usable_camera(file, file_and_name);
  hold_notes(file_and_name, file.notes);
  return camera;
}

void hold_notes(const std::string& name, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) hold_note(fmt::format("{}: {}", name, note));
}

}  // namespace tagcal::tools
