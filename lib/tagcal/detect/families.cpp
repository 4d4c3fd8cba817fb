#include "tagcal/detect/families.hpp"

#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/opencv/marker_dictionary.hpp"
#include "tagcal/error.hpp"
#include "tagcal/scene/print/printed_tag.hpp"

namespace tagcal {
using namespace internal;
namespace {

struct KnownFamily {
  std::string_view name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

constexpr std::array kFamilies = {
    KnownFamily{"tag36h11", tag36h11_create, tag36h11_destroy},
    KnownFamily{"tag36h10", tag36h10_create, tag36h10_destroy},
    KnownFamily{"tag25h9", tag25h9_create, tag25h9_destroy},
    KnownFamily{"tag16h5", tag16h5_create, tag16h5_destroy},
    KnownFamily{"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    KnownFamily{"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
    KnownFamily{"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    KnownFamily{"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy},
    KnownFamily{"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
};

// A family that owns its arrays.
struct OwnedFamily {
  apriltag_family_t family{};  // first: the handle points to it
  std::string name;
  std::vector<std::uint64_t> codes;
  std::vector<std::uint32_t> x, y;
};

void destroy_owned(apriltag_family_t* family) { delete reinterpret_cast<OwnedFamily*>(family); }

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

// The markers of OpenCV's dictionary as a family of the AprilTag library, with a border one cell
// wide: its detector then reads them. Empty if OpenCV has no dictionary of this name.
FamilyHandle create_dictionary_family(std::string_view name) {
  const std::optional<MarkerDictionary> dictionary = marker_dictionary(name);
  if (!dictionary) return FamilyHandle(nullptr, FamilyDeleter{destroy_owned});
  const int side = dictionary->side;
  auto* owned = new OwnedFamily;
  FamilyHandle handle(&owned->family, FamilyDeleter{destroy_owned});
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

FamilyHandle create_plain_family(std::string_view name) {
  const auto* const known = std::ranges::find(kFamilies, name, &KnownFamily::name);
  if (known != kFamilies.end()) return FamilyHandle(known->create(), FamilyDeleter{known->destroy});
  FamilyHandle family = create_dictionary_family(name);
  if (!family) {
    throw Error(
        fmt::format("family: must be one of {}, or a dictionary of OpenCV (DICT_4X4_50, "
                    "..), got {}",
                    fmt::join(tag_family_names(), ", "), name));
  }
  return family;
}

bool is_known(const std::string& name) {
  return std::ranges::count(kFamilies, name, &KnownFamily::name) > 0 ||
         std::ranges::count(tag_dictionary_names(), name) > 0;
}

}  // namespace

FamilyHandle internal::create_family(std::string_view name, int border_bits) {
  FamilyHandle family = create_plain_family(name);
  const int widest = family->reversed_border ? 1 : 2;
  if (border_bits < 1 || border_bits > widest) {
    throw Error(fmt::format("border_bits: must be {} for {}, got {}", widest == 1 ? "1" : "1 or 2",
                            name, border_bits));
  }
  if (border_bits == 2) {
    family->width_at_border += 2;
    family->total_width += 2;
    for (std::uint32_t i = 0; i < family->nbits; ++i) {
      ++family->bit_x[i];
      ++family->bit_y[i];
    }
  }
  return family;
}

std::shared_ptr<apriltag_family_t> internal::shared_family(const std::string& name, int border_bits,
                                                           int max_hamming) {
  static std::mutex mutex;
  static std::map<std::tuple<std::string, int, int>, std::weak_ptr<apriltag_family_t>> in_use;
  // A search of one picture after the other finds its table again: building it takes 2 ms for
  // tag36h11, 250 ms for tagCircle49h12.
  static std::array<std::shared_ptr<apriltag_family_t>, 2> latest;
  const std::scoped_lock lock(mutex);
  std::weak_ptr<apriltag_family_t>& known = in_use[{name, border_bits, max_hamming}];
  const auto remembered = [&](const std::shared_ptr<apriltag_family_t>& family) {
    if (latest[0] != family) latest = {family, latest[0]};
    return family;
  };
  if (const auto family = known.lock()) return remembered(family);
  std::shared_ptr<apriltag_family_t> family = create_family(name, border_bits);
  const DetectorHandle builder(apriltag_detector_create());
  apriltag_detector_add_family_bits(builder.get(), family.get(), max_hamming);
  known = family;
  return remembered(family);
}

std::vector<std::string> tag_family_names() {
  std::vector<std::string> names;
  for (const KnownFamily& family : kFamilies) names.emplace_back(family.name);
  return names;
}

std::vector<std::string> tag_dictionary_names() { return marker_dictionary_names(); }

TagFamily tag_family(std::string_view name, int border_bits) {
  const FamilyHandle handle = create_family(name, border_bits);
  TagFamily family;
  family.name = name;
  family.width_at_border = handle->width_at_border;
  family.total_width = handle->total_width;
  family.reversed_border = handle->reversed_border;
  for (std::uint32_t i = 0; i < handle->nbits; ++i) {
    // Bits outside of the border have negative coordinates, which AprilTag stores as unsigned.
    family.bits.push_back(
        {static_cast<std::int32_t>(handle->bit_x[i]), static_cast<std::int32_t>(handle->bit_y[i])});
  }
  family.codes.assign(handle->codes, handle->codes + handle->ncodes);
  return family;
}

TagFamilies tag_families(const std::vector<PlacedBoard>& boards) {
  TagFamilies families;  // each board gives them its own border when it is drawn
  for (const auto& [board, pose] : boards)
    if (const auto kind = tag_kind(board))
      families[kind->family] = tag_family(kind->family, kind->border_bits);
  return families;
}

void check_tags(const Board& board) {
  const auto kind = tag_kind(board);
  if (!kind) return;
  const bool has_markers = checkers(board).has_value();
  if (has_markers && !is_known(kind->family))
    throw Error(fmt::format("dictionary: must be one of {}, got {}",
                            fmt::join(tag_dictionary_names(), ", "), kind->family));
  const TagFamily family =
      internal::with_border(tag_family(kind->family, kind->border_bits), board);
  const std::vector<Tag> tags = tags_of(board);
  const int last = tags.empty() ? -1 : std::ranges::max(tags, {}, &Tag::id).id;
  if (has_markers && last >= std::ssize(family.codes))
    throw Error(
        fmt::format("dictionary: {} has {} markers, but those of the board are numbered up "
                    "to {}; choose a larger dictionary, or fewer squares",
                    family.name, family.codes.size(), last));
  for (const Tag& tag : tags) internal::check_tag_id(family, tag.id);
}

}  // namespace tagcal
