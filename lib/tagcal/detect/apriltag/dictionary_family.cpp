#include "tagcal/detect/apriltag/dictionary_family.hpp"

#include <optional>
#include <string>
#include <vector>

#include "tagcal/detect/opencv/marker_dictionary.hpp"

namespace tagcal::internal {
namespace {

// A family that owns its arrays.
struct OwnedFamily {
  apriltag_family_t family{};  // first: the handle points to it
  std::string name;
  std::vector<std::uint64_t> codes;
  std::vector<std::uint32_t> x, y;
};

void destroy(apriltag_family_t* family) { delete reinterpret_cast<OwnedFamily*>(family); }

// Cells in the order in which AprilTag turns codes: those of the first quarter row by row, then the
// same cells of the second quarter, turned clockwise, and so on; the middle last.
void set_cells(OwnedFamily& owned, int side) {
  const auto add = [&](int x, int y) {
    owned.x.push_back(static_cast<std::uint32_t>(x));
    owned.y.push_back(static_cast<std::uint32_t>(y));
  };
  for (int quarter = 0; quarter < 4; ++quarter) {
    for (int row = 0; row < side / 2; ++row) {
      for (int column = row; column < side - 1 - row; ++column) {
        int x = column, y = row;
        for (int i = 0; i < quarter; ++i) {
          const int turned = side - 1 - y;
          y = x;
          x = turned;
        }
        add(x, y);
      }
    }
  }
  if (side % 2 == 1) add(side / 2, side / 2);
}

std::uint64_t reordered(std::uint64_t code, const OwnedFamily& owned, int side) {
  std::uint64_t result = 0;
  for (std::size_t i = 0; i < owned.x.size(); ++i) {
    const int bit = static_cast<int>(owned.y[i]) * side + static_cast<int>(owned.x[i]);
    result = result << 1 | (code >> (side * side - 1 - bit) & 1U);
  }
  return result;
}

}  // namespace

FamilyHandle create_dictionary_family(std::string_view name) {
  const std::optional<MarkerDictionary> dictionary = marker_dictionary(name);
  if (!dictionary) return FamilyHandle(nullptr, FamilyDeleter{destroy});
  const int side = dictionary->side;
  auto* owned = new OwnedFamily;
  FamilyHandle handle(&owned->family, FamilyDeleter{destroy});
  owned->name = name;
  set_cells(*owned, side);
  for (const std::uint64_t code : dictionary->codes)
    owned->codes.push_back(reordered(code, *owned, side));
  for (auto* places : {&owned->x, &owned->y})
    for (std::uint32_t& at : *places) ++at;  // the border
  handle->ncodes = static_cast<std::uint32_t>(owned->codes.size());
  handle->codes = owned->codes.data();
  handle->width_at_border = side + 2;
  handle->total_width = side + 4;
  handle->nbits = static_cast<std::uint32_t>(owned->x.size());
  handle->bit_x = owned->x.data();
  handle->bit_y = owned->y.data();
  handle->h = static_cast<std::uint32_t>(dictionary->min_distance);
  handle->name = owned->name.data();
  return handle;
}

}  // namespace tagcal::internal
