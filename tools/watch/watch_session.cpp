#include "watch/sessions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "job/find_corners.hpp"
#include "job/interruption.hpp"
#include "job/messages.hpp"
#include "job/progress.hpp"
#include "job/terminal.hpp"
#include "report/calibration_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "watch/watch_report.hpp"

namespace tagcal::tools {
namespace {

// After the end of a video: its last picture is ready after two looks (FolderFollower).
constexpr int kQuietLooks = 2;

class WatchSession {
 public:
  WatchSession(WatchOptions options, WatchedPictures& pictures, std::vector<std::string> warnings)
      : options_(std::move(options)), pictures_(pictures), warnings_(std::move(warnings)) {}

  ExitCode run() {
    const Interruption interruption;  // from the first word on, Ctrl-C leaves a calibration
    greet();
    for (;;) {
      const End end = step();
      if (end != End::none) return finish(end);
      Interruption::sleep(pause_until_look(options_.every, options_.timeout_s, last_change_));
    }
  }

 private:
  enum class End { none, goal, gone, timeout, ended, interrupted };

  void tell(const std::string& text) const { tools::tell(text, options_.json); }

  void greet() const {
    std::string text = wrapped("",
                               fmt::format("watching {}; the calibration goes to {}; Ctrl-C ends",
                                           options_.name, options_.out.string()),
                               2);
    text +=
        wrapped("",
                "For each picture: the corners found, the share of the image inside the hull of "
                "all corners, the standard deviations (sd) of the focal length and of the "
                "projection at infinity where it is largest in the image.",
                2);
    for (const std::string& warning : warnings_) text += remark_lines(warning);
    tell(text);
  }

  End step() {
    if (Interruption::requested()) return End::interrupted;
    const std::optional<FolderListing> listing = list_folder(options_.folder);
    if (listing) {
      missed_looks_ = 0;
      tell(notices_.of_unread_files(options_.folder));
      const bool has_changed = take(follower_.look(*listing));
      if (has_changed || follower_.awaits()) last_change_ = std::chrono::steady_clock::now();
      quiet_looks_ = has_changed || !has_video_ended() ? 0 : quiet_looks_ + 1;
    } else if (++missed_looks_ >= kMissedLooks) {
      return End::gone;
    }
    if (options_.goal_px > 0 && meets(standing_, options_.goal_px)) return End::goal;
    if (Interruption::requested()) return End::interrupted;
    const std::chrono::duration<double> quiet = std::chrono::steady_clock::now() - last_change_;
    if (options_.timeout_s > 0 && quiet.count() > options_.timeout_s) return End::timeout;
    return quiet_looks_ > kQuietLooks ? End::ended : End::none;
  }

  bool has_video_ended() { return options_.has_ended && options_.has_ended(video_why_); }

  // Returns true if the pictures changed.
  bool take(const FolderFollower::Events& events) {
    if (events.ready.empty() && events.removed.empty()) return false;
    const int revision = pictures_.revision();
    const std::vector<PictureNews> news = pictures_.update({events.ready, events.removed});
    std::vector<const PictureNews*> found;
    for (const PictureNews& told : news)
      if (told.fate == Fate::board_found) found.push_back(&told);
    tell(news, found.size() > 1 && !is_first_);
    if (!pictures_.has_corners()) follower_.recall_set_aside();
    is_first_ = is_first_ && news.empty();
    if (pictures_.revision() == revision) return !news.empty();
    Step step{"the others", 0, standing_};
    if (found.size() == 1) step.name = found.front()->name;
    if (found.size() > 1) step.name = counted(found.size(), "picture");
    for (const PictureNews* picture : found) step.num_corners += picture->num_corners;
    if (found.empty())
      for (const View& view : pictures_.dataset().views)
        step.num_corners += view.observations.size();
    recalibrate(std::move(step));
    return true;
  }

  void tell(const std::vector<PictureNews>& news, bool lists_boards) {
    const std::string repeated = repeated_line(news);
    tell(repeated);
    for (const PictureNews& told : news) {
      const bool is_interrupted = told.fate == Fate::unreadable && Interruption::requested();
      if (is_interrupted || (told.fate == Fate::repeated && !repeated.empty())) continue;
      if (told.fate == Fate::unreadable && !follower_.postpone(told.name)) continue;
      if (told.fate == Fate::wrong_size) follower_.set_aside(told.name);
      std::string text;
      if (told.fate != Fate::board_found || lists_boards) text += news_line(told);
      for (const std::string& warning : told.warnings)
        text += remark_lines(fmt::format("{}: {}", told.name, warning));
      tell(text);
    }
    tell(notices_.of_warnings(pictures_.general_warnings()));
  }

  void recalibrate(Step step) {
    if (!pictures_.has_corners()) {
      calibration_ = {};
      standing_ = {};
      tell("no picture with the board is left\n");
      return;
    }
    const Dataset dataset = pictures_.dataset();
    {
      const Progress progress("calibrating");
      calibration_ = calibrate(dataset, options_.calibration);
    }
    std::vector<Finding> findings;
    for (const std::string& warning : warnings_) add(findings, code::input, warning);
    for (const std::string& warning : pictures_.warnings()) add(findings, code::input, warning);
    calibration_.findings.insert(calibration_.findings.begin(), findings.begin(), findings.end());
    const std::optional<Finding> wrong = pictures_.wrong_target();
    refuse(wrong, calibration_);
    standing_ = standing_of(calibration_);
    if (standing_.has_answer) {
      write_whole(options_.out, calibration_yaml(calibration_));
      kept_ = calibration_;
    }
    tell(step_line(step, calibration_));
    tell(notices_.of_urgent_findings(calibration_.findings));
    if (!wrong && !meets(standing_, options_.goal_px)) tell_next(advise(dataset, calibration_));
  }

  // Nothing if it is what was said last: a distance that changes a little is no other view.
  void tell_next(const std::optional<AdvisedView>& advice) {
    constexpr double kOtherDistance = 1.25;
    const std::string text = next_lines(advice, standing_, options_.goal_px);
    std::string words = without_numbers(text);
    const double distance_m = advice ? advice->distance_m : 0;
    const bool is_same = words == next_words_ && distance_m < kOtherDistance * next_distance_m_ &&
                         next_distance_m_ < kOtherDistance * distance_m;
    if (is_same || (words == next_words_ && !advice)) return;
    next_words_ = std::move(words);
    next_distance_m_ = distance_m;
    tell(text);
  }

  std::string end_text(End end) const {
    if (end == End::goal)
      return wrapped(
          toned(Tone::good, "GOAL MET:") + " ",
          fmt::format("the projection is known to {} px over the image, {} px is the goal",
                      two_digits(standing_.largest_px), options_.goal_px),
          2);
    std::string text;
    if (end == End::gone)
      text = fmt::format("{}: the folder is gone\n", options_.name);
    else if (end == End::ended)
      text = video_why_.empty() ? "the video has ended\n" : video_why_ + "\n";
    else if (end == End::timeout)
      text = fmt::format("no new picture for {}\n", duration_text(options_.timeout_s));
    else
      text = "interrupted\n";
    if (options_.goal_px > 0)
      text += wrapped(toned(Tone::caution, "GOAL NOT MET:") + " ",
                      what_lacks(standing_, options_.goal_px), 2);
    return text;
  }

  ExitCode finish(End end) {
    if (end == End::ended && !video_why_.empty() && pictures_.size() == 0) throw Error(video_why_);
    std::string text = end_text(end);
    if (!kept_) {
      const bool is_live = options_.has_ended != nullptr;
      text +=
          wrapped(toned(Tone::bad, "NO ANSWER:") + " ",
                  pictures_.size() > 0 ? "the pictures so far give no calibration; no file was "
                                         "written. tagcal detect --explain tells what a picture "
                                         "shows"
                  : is_live ? "no picture was taken; no file was written: hold the board still "
                              "after each move, until its line appears"
                            : "no picture came; no file was written",
                  2);
      tell(text);
    } else {
      if (!standing_.has_answer)
        text += wrapped(
            "! ", "the latest picture made the calibration fail; showing the previous one", 2);
      CalibrationAnswer answer;
      answer.calibration = *kept_;
      const std::string& model = options_.calibration.model;
      tell(text);
      const std::string summary =
          options_.json ? calibration_json(answer)
                        : calibration_summary(answer, {model.empty() || model == "auto", false});
      print_answer(summary, options_.json, options_.out);
      say_wrote(options_.out);
    }
    pictures_.save_cache();
    if (!kept_) return kNoAnswer;
    return options_.goal_px > 0 && end != End::goal ? kCheckFailed : kAnswer;
  }

  WatchOptions options_;
  WatchedPictures& pictures_;
  std::vector<std::string> warnings_;  // of the target's file
  FolderFollower follower_;
  std::chrono::steady_clock::time_point last_change_ = std::chrono::steady_clock::now();
  int missed_looks_ = 0;
  int quiet_looks_ = 0;    // since the video ended
  std::string video_why_;  // it ended
  bool is_first_ = true;   // the pictures that were there before
  Calibration calibration_;
  Standing standing_;
  std::optional<Calibration> kept_;  // the last answer, as it stands in the file
  Notices notices_;
  std::string next_words_;  // of the last `next:`, without numbers
  double next_distance_m_ = 0;
};

}  // namespace

ExitCode watch_folder(WatchOptions options, WatchedPictures& pictures,
                      std::vector<std::string> warnings) {
  return WatchSession(std::move(options), pictures, std::move(warnings)).run();
}

}  // namespace tagcal::tools
