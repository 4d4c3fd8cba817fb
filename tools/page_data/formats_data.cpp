#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "page_data/page_parts.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/text_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

// A folder that is removed with its files.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "tagcal-report-XXXXXX").string()) {
    if (!mkdtemp(path_.data())) throw Error(path_ + ": cannot be made");
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  fs::path path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

PageJson formats_json(const Calibration& calibration, std::vector<std::string>& notes) {
  if (!is_answer(calibration.status) || !calibration.camera || calibration.model == "weak")
    return PageJson::array();
  CameraFile camera;
  CalibrationFile known = calibration_file(calibration);
  if (calibration.projection.empty()) known.camera_error_px.reset();  // read from a file
  camera.cameras.push_back({"camera", std::move(known)});
  return formats_json(camera, notes);
}

PageJson formats_json(const CameraFile& cameras, std::vector<std::string>& notes) {
  PageJson list = PageJson::array();
  try {
    const TemporaryFolder folder;
    for (const CameraFormat& format : camera_formats()) {
      if (format.only_poses || (cameras.cameras.size() > 1 && !format.several)) continue;
      const fs::path file = folder.path() / format.file;
      const std::string title = fmt::format("{} ({})", format.name, format.file);
      try {
        write_camera_file(file, cameras, format.name);
        list.push_back({{"name", title}, {"text", read_text(file)}});
      } catch (const Error& error) {
        std::string reason = error.what();
        if (const std::size_t at = reason.find(file.string() + ": "); at == 0)
          reason.erase(0, file.string().size() + 2);
        notes.push_back(fmt::format("Not among the formats to copy: {}: {}.", title, reason));
      }
    }
  } catch (const Error& error) {
    notes.push_back(fmt::format("There are no formats to copy: {}.", error.what()));
  }
  return list;
}

}  // namespace tagcal::tools
