#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "job/input.hpp"
#include "page_data/json_values.hpp"
#include "page_data/page_content.hpp"
#include "report/fleet.hpp"
#include "report/handeye_report.hpp"
#include "tagcal/estimate/rig_types.hpp"
#include "tagcal/io/types.hpp"

namespace tagcal::tools {

// What a file says of a camera, as a calibration without views.
Calibration calibration_of(const CalibrationFile& file);

// The content of the page of a calibration file ("FILE" or "FILE:NAME", of any program). With
// `input` (not null) its views get poses and residuals under that camera; their corners are found
// in the pictures if the data set has none.
PageContent content_from_file(const std::string& file_and_name, Input* input, int threads);

// The data of the page of a calibration.
PageJson calibration_page(const PageContent& content);

// The data of the page that compares two calibrations, at infinity and about a distance.
PageJson difference_page(const std::string& a, const std::string& b, double near_m);

// The data of the page of a fleet, whose calibrations are in `folder`. `out` is the page's file:
// the worst units link to their pages NAME.html in the folder, or else to their calibrations.
PageJson fleet_page(const Fleet& fleet, const std::filesystem::path& folder,
                    const std::filesystem::path& out);

// An input beside the pictures, by the name of its option: "robot", "poses.csv".
struct InputRow {
  std::string name;
  std::string text;
};

// A hand-eye calibration, with or without an answer. `options`: of that calibration.
PageJson handeye_page(const HandeyeInput& input, const std::vector<InputRow>& inputs,
                      const HandeyeOptions& options, const HandeyeEstimate& answer);

struct PosesPageInput {
  std::filesystem::path poses;  // what tagcal pose --json printed
  std::string camera;           // for residuals; "": none
  Input* input = nullptr;       // corners, boards and pictures; null: none
  int threads = 0;
};

// True for a JSON file with the views of tagcal pose.
bool is_poses_file(const std::filesystem::path& file);

// The data of the page that shows the poses of views.
PageJson poses_page(const PosesPageInput& given);

// A rig that was just calibrated, with or without an answer. `options`: of that calibration;
// `pictures`: the files by camera and View::image.
PageJson rig_page(const RigDataset& data, const RigCalibration& answer, const RigOptions& options,
                  const std::vector<std::map<std::string, std::filesystem::path>>& pictures);

// The rig of a file, which knows nothing of instants.
PageJson rig_page(const CameraFile& file, const std::string& name);

// The cameras of a file ("rig.yaml"), if it has several with their places. None for others, and for
// files that cannot be read.
std::optional<CameraFile> rig_in_file(const std::string& name);

// Throws Error before any work if the page certainly cannot be written, or would replace one of the
// inputs.
void check_page(const std::filesystem::path& out, const std::vector<std::string>& inputs);

// Writes the page whole or not at all, and says so.
void write_page(const std::filesystem::path& out, const PageJson& data);

}  // namespace tagcal::tools
