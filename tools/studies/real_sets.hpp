#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"

// Data sets of real cameras, of which parts are calibrated (halves.cpp, single_views.cpp).

namespace tagcal {

struct RealSet {
  std::string name;  // of its folder
  Dataset dataset;
};

// Reads data sets with observations. Prints their warnings on stderr. Throws Error.
std::vector<RealSet> read_sets(const std::vector<std::string>& folders);

// The data set with some of its views.
Dataset part_of(const Dataset& set, const std::vector<std::size_t>& views);

// Calibrates some of the views, with the projection's uncertainty at infinity.
Calibration calibrate_views(const Dataset& set, const std::vector<std::size_t>& views,
                            const std::string& model);

// Returns true for an answer that has a focal length. (The answer `weak` has none.)
bool has_focal_length(const Calibration& calibration);

// The status, or the model if it is an answer with a focal length.
std::string outcome(const Calibration& calibration);

// A lens parameter with its standard deviation. The first four of all lenses are fx, fy, cx, cy.
struct Claim {
  double value = 0;
  double sd = 0;
};
Claim claim_of(const Calibration& calibration, std::size_t parameter);

// The difference of two claims in its standard deviations; 0 if both have the same held value.
double z_of(const Claim& a, const Claim& b);

// Two projections at infinity, less a rotation: root mean squares per coordinate over a region.
struct ProjectionTest {
  double difference_px = 0;
  double claim_px = 0;    // at the nodes of the grid in the region
  double printed_px = 0;  // ProjectionUncertainty::region_px, each over its own region
};

// The region of all corners of a data set.
SeenRegion region_of(const Dataset& set);

// Compares two calibrations, with the uncertainties that both print for the nodes of their grid.
// Nodes without an uncertainty are skipped. No value if the lenses cannot be compared.
std::optional<ProjectionTest> test_projection(const Calibration& a, const Calibration& b,
                                              const SeenRegion& region);

}  // namespace tagcal
