#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/types.hpp"
#include "watch/watched_pictures.hpp"

namespace tagcal::tools {

// How far a calibration is. All zero without an answer.
struct Standing {
  bool has_answer = false;
  double coverage = 0;               // share of the image inside the hull of the corners
  double focal_sigma_px = 0;         // the larger of fx and fy
  double largest_px = 0;             // sd of the projection at infinity over the image
  std::vector<std::string> missing;  // parts of the image without corners
  std::size_t num_pictures = 0;      // that take part
  std::string model;
  double rms_px = 0;
  double other_models = 0;  // their weight in the standard deviations
  bool has_ray_everywhere = false;
};
Standing standing_of(const Calibration& calibration);

// Fewest pictures behind a goal that is met: the check by halves needs them (HalvesCheck).
inline constexpr std::size_t kFewestPictures = 6;

// True if the projection is known to `goal_px` over all the image. The standard deviation alone is
// not enough: a small model claims a small one where no corners were.
bool meets(const Standing& standing, double goal_px);

// Why it does not. Precondition: !meets(standing, goal_px).
std::string what_lacks(const Standing& standing, double goal_px);

// The line of a picture that did not change the calibration.
std::string news_line(const PictureNews& news);

// One line for many pictures that repeat others, which then have no lines of their own; "" for few.
std::string repeated_line(const std::vector<PictureNews>& news, const std::string& camera = "");

// Says each notice of a session once. `camera`: its name among several; "" for the only one.
class Notices {
 public:
  // Files that people put beside pictures and that are not read, with what to do.
  std::string of_unread_files(const std::filesystem::path& folder, const std::string& camera = "");
  // Warnings about no picture alone.
  std::string of_warnings(const std::set<std::string>& warnings, const std::string& camera = "");
  // Findings to act on before more pictures are taken.
  std::string of_urgent_findings(const std::vector<Finding>& findings,
                                 const std::string& camera = "");

 private:
  std::set<std::string> told_;  // sentences, or codes of findings
};

// What changed a calibration: one picture, or several at once.
struct Step {
  std::string name;  // "007.png", or "5 pictures"
  std::size_t num_corners = 0;
  Standing before;
};
// A number that got worse has its reason behind it.
std::string step_line(const Step& step, const Calibration& calibration);

// "  next: .." : the view to take, or what the goal still lacks.
// `camera`: of several; "": the only one.
std::string next_lines(const std::optional<AdvisedView>& advice, const Standing& standing,
                       double goal_px, const std::string& camera = "");

// A warning below a picture's line.
std::string remark_lines(const std::string& sentence);

// Prints what a session says before its end; `json`: on stderr, because stdout has the JSON of the
// calibration alone.
void tell(const std::string& text, bool json);

// The words of `text` without numbers, by which advice is said once.
std::string without_numbers(std::string text);

// Until the next look: `every`, or less if a session ends before (`timeout_s` > 0) for want of
// pictures since `last_change`.
std::chrono::milliseconds pause_until_look(std::chrono::milliseconds every, double timeout_s,
                                           std::chrono::steady_clock::time_point last_change);

}  // namespace tagcal::tools
