#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tagcal/io/formats/lens_numbers.hpp"

// Lenses by COLMAP's names and PARAMS, with the pixel centres moved.

namespace tagcal::internal {

// Throws Error, beginning with `where`.
Lens colmap_lens(const std::string& name, std::span<const double> values, const std::string& where);

struct ColmapLens {
  std::string_view name;
  std::vector<double> values;
};
ColmapLens lens_of_colmap(const FileCamera& camera);  // throws Error for those of others

}  // namespace tagcal::internal
