#include "job/camera_input.hpp"

#include "job/messages.hpp"
#include "tagcal/io/camera_file.hpp"

namespace tagcal::tools {

CalibrationFile read_camera(const std::string& file_and_name) {
  const CameraFile file = read_one_camera(file_and_name);
  CalibrationFile camera = usable_camera(file, file_and_name);
  print_notes(file_and_name, file.notes);
  return camera;
}

void print_notes(const std::string& name, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) print_to_stderr("{}: {}\n", name, note);
}

}  // namespace tagcal::tools
