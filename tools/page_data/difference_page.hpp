#pragma once

#include <string>

#include "page_data/json_values.hpp"

namespace tagcal::tools {

// The data of the page that compares two calibrations, at infinity and about a distance.
PageJson difference_page(const std::string& a, const std::string& b, double near_m);

}  // namespace tagcal::tools
