#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/estimate/types.hpp"
#include "tagcal/random.hpp"

// Data sets of real cameras, of which parts are calibrated (halves.cpp, single_views.cpp).

namespace tagcal {

struct RealOptions {
  std::vector<std::string> folders;
  std::string model = "auto";
  std::uint64_t seed = 1;
  int threads = 2;
  std::string csv;
};

void add_options(CLI::App& app, RealOptions& options);

struct RealSet {
  std::string name;  // of its folder
  Dataset dataset;
};

// Reads data sets with observations. Prints their warnings on stderr. Throws Error.
std::vector<RealSet> read_sets(const std::vector<std::string>& folders);

// `count` different indices below n, ascending.
std::vector<std::size_t> random_subset(std::size_t n, std::size_t count, Random& random);

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

// Differences in units of their standard deviations.
class Scores {
 public:
  void add(double z) { z_.push_back(z); }
  void add(const Scores& other) { z_.insert(z_.end(), other.z_.begin(), other.z_.end()); }

  int count() const { return static_cast<int>(z_.size()); }
  int beyond() const;  // |z| > 3
  double rms() const;
  double worst() const;
  std::string text() const;  // rms, share beyond 3 in %, worst; in 21 characters

 private:
  std::vector<double> z_;
};

double percent(double part, double whole);  // 0 of nothing
double rms_of(const std::vector<double>& values);

}  // namespace tagcal
