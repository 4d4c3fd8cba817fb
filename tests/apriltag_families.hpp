#pragma once

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>

#include "tagcal/scene/board.hpp"

namespace tagcal {

// AprilTag's own patterns, read without the library under test.
struct AprilTagFamily {
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};
inline constexpr AprilTagFamily kAprilTagFamilies[] = {
    {tag36h11_create, tag36h11_destroy},
    {tag16h5_create, tag16h5_destroy},
    {tag25h9_create, tag25h9_destroy},
    {tagStandard41h12_create, tagStandard41h12_destroy},
    {tagStandard52h13_create, tagStandard52h13_destroy},
    {tagCircle21h7_create, tagCircle21h7_destroy},
    {tagCircle49h12_create, tagCircle49h12_destroy},
    {tagCustom48h12_create, tagCustom48h12_destroy}};

inline TagFamily as_tag_family(const apriltag_family_t& family) {
  TagFamily result{family.name,
                   family.width_at_border,
                   family.total_width,
                   family.reversed_border,
                   {},
                   {family.codes, family.codes + family.ncodes}};
  for (std::uint32_t i = 0; i < family.nbits; ++i)
    result.bits.push_back({static_cast<int>(family.bit_x[i]), static_cast<int>(family.bit_y[i])});
  return result;
}

inline TagFamily tag36h11_family() {
  apriltag_family_t* family = tag36h11_create();
  TagFamily result = as_tag_family(*family);
  tag36h11_destroy(family);
  return result;
}

}  // namespace tagcal
