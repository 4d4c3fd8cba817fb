#include "watch/watch_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "job/messages.hpp"
#include "job/picture_files.hpp"
#include "job/shown_parameters.hpp"
#include "job/terminal.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNameColumns = 14;
constexpr std::size_t kIndent = 2;

// The end of a long name tells pictures apart.
std::string name_column(const std::string& name) {
  if (name.size() <= kNameColumns) return fmt::format("{:<{}}  ", name, kNameColumns);
  return ".." + name.substr(name.size() - (kNameColumns - 2)) + "  ";
}

std::string corners_text(std::size_t count) {
  return fmt::format("{:>4} corner{}", count, count == 1 ? "" : "s");
}

// A status without an answer, while pictures are still being taken.
std::string not_yet_text(Status status) {
  switch (status) {
    case Status::focal_not_observable:
      return "no calibration yet: the focal length is not determined";
    case Status::not_observable:
      return "no calibration yet: not all parameters are determined";
    case Status::no_consensus:
      return "no calibration: the pictures contradict one another or the target";
    case Status::not_converged:
      return "no calibration: the solver found no minimum";
    default:
      return "no calibration yet: too few corners";
  }
}

std::string pixels(double sigma_px, const ImageSize& size) {
  return has_bound(sigma_px, size) ? two_digits(sigma_px) + " px" : "no bound";
}

std::string standing_text(const Standing& now, const ImageSize& size) {
  return fmt::format("coverage {:>3.0f} %  sd of f {}, image {}", 100 * now.coverage,
                     pixels(now.focal_sigma_px, size), pixels(now.largest_px, size));
}

// Why less is known than before; "" if that is not so.
std::string why_worse(const Standing& now, const Standing& before) {
  constexpr double kWorse = 1.1;  // smaller changes are the accuracy of a standard deviation
  if (!before.has_answer) return "";
  if (now.model != before.model)
    return fmt::format("the pictures need {} instead of {}", now.model, before.model);
  const bool is_worse = now.focal_sigma_px > kWorse * before.focal_sigma_px ||
                        now.largest_px > kWorse * before.largest_px;
  if (!is_worse) return "";
  if (now.num_pictures < before.num_pictures) return "fewer pictures take part";
  if (now.rms_px > kWorse * before.rms_px)
    return fmt::format("the residuals rose from {} to {} px rms", two_digits(before.rms_px),
                       two_digits(now.rms_px));
  if (now.other_models > before.other_models + 0.01)
    return fmt::format("lens models other than {} explain the pictures as well (weight {:.0f} %)",
                       now.model, 100 * now.other_models);
  return "the pictures differ from one another by more than before";
}

constexpr std::size_t kMostRepeated = 5;  // pictures that are listed, each in its line

bool is_one_of(const Finding& finding, std::initializer_list<FindingCode> codes) {
  return std::ranges::any_of(codes, [&](const FindingCode& c) { return c.name == finding.code; });
}

// Tells a warning to act on before more pictures are taken from all others, many of which go away
// with more pictures: those about one picture by their sentence, those about the target and the way
// the pictures are taken, whose numbers change, by their code. "": not urgent.
std::string key_of_urgent(const Finding& finding) {
  if (is_one_of(finding, {code::view_rejected, code::view_repeated, code::view_unusable,
                          code::view_mirrored, code::board_moved}))
    return finding.sentence;
  const bool is_of_all =
      is_one_of(finding, {code::tags_misplaced, code::tag_scale, code::flatness_exceeded,
                          code::print_exceeded, code::board_bend_impossible, code::rows_displaced,
                          code::rolling_shutter});
  return is_of_all ? finding.code : "";
}

// A line's or sentence's beginning, of several cameras.
std::string start_of(const std::string& camera, const char* separator) {
  return camera.empty() ? "" : camera + separator;
}

}  // namespace

Standing standing_of(const Calibration& calibration) {
  Standing standing;
  if (!is_answer(calibration.status) || !calibration.camera) return standing;
  standing.has_answer = true;
  standing.coverage = calibration.seen.share();
  standing.missing = calibration.seen.missing_parts();
  standing.num_pictures = calibration.views.size();
  standing.model = calibration.model;
  standing.rms_px = calibration.rms_px;
  for (const ModelStep& step : calibration.steps)
    if (step.model != calibration.model) standing.other_models += step.weight;
  for (const Shown& parameter : shown_parameters(calibration))
    if (parameter.name == "fx" || parameter.name == "fy")
      standing.focal_sigma_px = std::max(standing.focal_sigma_px, parameter.sigma);
  for (const ProjectionUncertainty& projection : calibration.projection) {
    if (!std::isinf(projection.distance_m)) continue;
    standing.largest_px = largest_px(projection);
    standing.has_ray_everywhere = nodes_without_ray(projection) == 0;
  }
  return standing;
}

bool meets(const Standing& standing, double goal_px) {
  return standing.has_answer && standing.largest_px > 0 && standing.largest_px <= goal_px &&
         standing.has_ray_everywhere && standing.missing.empty() && standing.coverage > 0 &&
         standing.num_pictures >= kFewestPictures;
}

std::string what_lacks(const Standing& standing, double goal_px) {
  if (!standing.has_answer) return "there is no calibration";
  if (!(standing.largest_px <= goal_px))
    return fmt::format("the projection is known to {} px over the image, {} px is the goal",
                       two_digits(standing.largest_px), goal_px);
  if (!standing.missing.empty())
    return fmt::format(
        "there are no corners in the {}, where the standard deviation assumes the "
        "model",
        fmt::join(standing.missing, ", "));
  if (standing.num_pictures < kFewestPictures)
    return fmt::format("{} pictures are too few, the goal needs {}: halves of them are compared",
                       standing.num_pictures, kFewestPictures);
  return "the lens has no ray in a part of the image";
}

std::string news_line(const PictureNews& news) {
  const std::string name = name_column(news.name);
  const auto line = [&](const std::string& first, const std::string& text) {
    return wrapped(name + first + " ", text, kNameColumns + 2);
  };
  switch (news.fate) {
    case Fate::board_found:
      return name + toned(Tone::good, corners_text(news.num_corners)) + "\n";
    case Fate::no_board:
      return line(toned(Tone::caution, "no board:"), news.why);
    case Fate::repeated:
      return line("same picture as", news.other + ", counts once");
    case Fate::renamed:
      return line("was", news.other + ", has a new name");
    case Fate::wrong_size:
      return line(toned(Tone::bad, "refused:"), news.why);
    case Fate::unreadable:
      return line(toned(Tone::bad, "not readable:"),
                  news.why + "; it is tried again once it changes");
    case Fate::removed:
      return line("removed,",
                  news.num_corners == 0
                      ? "it had no board"
                      : fmt::format("its {} corners do not count any more", news.num_corners));
  }
  return "";
}

std::string repeated_line(const std::vector<PictureNews>& news, const std::string& camera) {
  const auto repeated =
      static_cast<std::size_t>(std::ranges::count(news, Fate::repeated, &PictureNews::fate));
  if (repeated <= kMostRepeated) return "";
  return fmt::format("{}{} pictures have the same bytes as others, and do not count again\n",
                     start_of(camera, ": "), repeated);
}

std::string Notices::of_unread_files(const fs::path& folder, const std::string& camera) {
  std::string text;
  for (const fs::path& file : files_not_read(folder)) {
    const std::string name = start_of(camera, "/") + file.filename().string();
    if (!told_.insert("not read: " + name).second) continue;
    try {
      read_image_size(file);
    } catch (const Error& error) {
      const std::string message = error.what(), path = file.string() + ": ";
      text += wrapped(name_column(name) + toned(Tone::caution, "not read:") + " ",
                      message.starts_with(path) ? message.substr(path.size()) : message,
                      kNameColumns + 2);
    }
  }
  return text;
}

std::string Notices::of_warnings(const std::set<std::string>& warnings, const std::string& camera) {
  std::string text;
  for (const std::string& warning : warnings)
    if (const std::string told = start_of(camera, ": ") + warning; told_.insert(told).second)
      text += remark_lines(told);
  return text;
}

std::string Notices::of_urgent_findings(const std::vector<Finding>& findings,
                                        const std::string& camera) {
  std::string text;
  for (const Finding& finding : findings) {
    const std::string key = key_of_urgent(finding), start = start_of(camera, ": ");
    if (!key.empty() && told_.insert(start + key).second)
      text += remark_lines(start + finding.sentence);
  }
  return text;
}

std::string step_line(const Step& step, const Calibration& calibration) {
  const std::string start = name_column(step.name) +
                            toned(Tone::good, corners_text(step.num_corners)) +
                            (step.num_corners == 1 ? "   " : "  ");
  if (!is_answer(calibration.status))
    return wrapped(start, not_yet_text(calibration.status), kNameColumns + 2);
  const Standing now = standing_of(calibration);
  const std::string why = why_worse(now, step.before);
  return wrapped(start + standing_text(now, calibration.camera->image_size),
                 why.empty() ? "" : ": " + why, kNameColumns + 2);
}

std::string next_lines(const std::optional<AdvisedView>& advice, const Standing& standing,
                       double goal_px, const std::string& camera) {
  std::string text = advice ? advice->instruction
                            : "show the board in another part of the image, tilted by 30 degrees";
  const bool is_precise = standing.has_answer && standing.largest_px <= goal_px;
  if (is_precise && !standing.missing.empty())
    text = fmt::format("show the board in the {}: without corners there, the goal is not sure",
                       fmt::join(standing.missing, ", "));
  else if (is_precise && standing.num_pictures < kFewestPictures)
    text += fmt::format("; the goal needs {} pictures, so that halves of them can be compared",
                        kFewestPictures);
  return wrapped("  next: ", (camera.empty() ? "" : camera + ": ") + text, 8);
}

std::string remark_lines(const std::string& sentence) {
  return wrapped("  " + toned(Tone::caution, "!") + " ", sentence, kIndent + 2);
}

void tell(const std::string& text, bool json) {
  if (text.empty()) return;
  if (json)
    print_note("{}", without_colours(text));
  else if (!is_quiet())
    print_text(text);
}

std::string without_numbers(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isdigit(c) || c == '.' || c == '\n'; });
  return text;
}

std::chrono::milliseconds pause_until_look(std::chrono::milliseconds every, double timeout_s,
                                           std::chrono::steady_clock::time_point last_change) {
  const std::chrono::duration<double> quiet = std::chrono::steady_clock::now() - last_change;
  const double left_s = timeout_s - quiet.count();
  if (timeout_s <= 0 || left_s > std::chrono::duration<double>(every).count()) return every;
  return std::chrono::milliseconds(std::max(1L, std::lround(1000 * left_s) + 1));
}

}  // namespace tagcal::tools
