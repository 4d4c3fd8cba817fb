#pragma once

#include <filesystem>
#include <string>

#include "job/input.hpp"
#include "page_data/json_values.hpp"

namespace tagcal::tools {

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

}  // namespace tagcal::tools
