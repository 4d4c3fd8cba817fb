#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "defects.hpp"
#include "study/harness/study.hpp"

// A world and its result.

namespace tagcal {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Record : WorldId {
  // The world.
  std::string model;
  int width = 0, height = 0;
  double field_of_view_deg = 0;
  int views = 0, tags_on_board = 0, border_bits = 0;
  double tag_px = 0, coverage = 0, most_tilt_deg = 0, blur_px = 0, noise_levels = 0;
  double ink_spread_px = 0, gamma = 1;
  int occluders = 0;
  std::string pictures;                                            // as in World
  std::string defects;                                             // names_of(Defects)
  double bend_x = 0, bend_y = 0, twist = 0, aspect = 0, skew = 0;  // shares, as in Defects
  double rows_px = 0;
  int uneven_light = 0;
  double noise_px = kNone;  // of corner mode, typical of the world
  int covariances = 1;

  // Corners, against exact ones. Beside the numbers of corners only pixel mode has values.
  int tags_visible = 0;  // with four visible corners
  int tags = 0;          // reported with four corners
  int tags_fitted = 0;   // each of which has a covariance
  int corners = 0, corners_without_covariance = 0;
  int corners_hidden = 0;      // reported, but not visible
  int corners_beyond = 0;      // of those with covariance: Mahalanobis distance above kFiveSigma2
  double corner_squares = 0;   // sum of squared Mahalanobis distances: two a corner, if right
  double corner_worst = 0;     // the largest Mahalanobis distance
  double corner_worst_px = 0;  // the largest distance to the truth, with or without covariance
  int gross = 0;               // grossly wrong corners

  // The answer of `auto`. Ratios are |error| / sd, NaN where nothing is claimed.
  std::string status, answer;
  int inliers = 0, left_out = 0;
  double model_error_px = kNone;
  int right_rejected = 0, gross_kept = 0;  // corners
  double f_px = kNone, f_sd_px = kNone, f_error_px = kNone, f_ratio = kNone;
  double region_px = kNone;                               // claimed, at the median distance
  double region_error_px = kNone;                         // RMS per coordinate
  double region_ratio = kNone, region_far_ratio = kNone;  // at the median distance, at infinity
  double image_px = kNone;          // claimed at worst over the image, of both distances
  double image_error_px = kNone;    // the largest where a number is printed, per coordinate
  double image_ratio = kNone;       // largest over nodes and distances, |d| / (sqrt(2) sd)
  double image_axis_ratio = kNone;  // the same of one coordinate, max(|du|, |dv|) / sd
  int nodes_silent = 0;             // nodes with a ray of the truth and without a claim

  // The same of the model that made the data, asked for by name.
  std::string own_status;
  double own_f_sd_px = kNone, own_f_ratio = kNone;
  double own_region_px = kNone, own_region_ratio = kNone, own_region_far_ratio = kNone;
  double own_image_px = kNone, own_image_ratio = kNone;

  double render_s = 0, detect_s = 0, calibrate_s = 0, own_s = 0;  // processor time
  std::string findings;  // "code: sentence | code: sentence"
};

// Mahalanobis distance in two dimensions of the probability p = 5.73e-7 with which one coordinate
// exceeds five standard deviations: sqrt(-2 ln p).
inline constexpr double kFiveSigma2 = 5.3613;

// A record as a row of a study, whose trial is the index of the world.
std::vector<std::string> record_columns();
study::Values record_values(const Record& record);
Record record_of(const study::Row& row);  // throws Error for text in the place of a number

}  // namespace tagcal
