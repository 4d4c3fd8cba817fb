#pragma once

#include <filesystem>

#include "page_data/json_values.hpp"
#include "report/fleet_judgement.hpp"

namespace tagcal::tools {

// The data of the page of a fleet, whose calibrations are in `folder`. `out` is the page's file:
// the worst units link to their pages NAME.html in the folder, or else to their calibrations.
PageJson fleet_page(const Fleet& fleet, const std::filesystem::path& folder,
                    const std::filesystem::path& out);

}  // namespace tagcal::tools
