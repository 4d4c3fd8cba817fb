#include "watch/sessions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "job/input.hpp"
#include "job/interruption.hpp"
#include "job/messages.hpp"
#include "job/progress.hpp"
#include "job/terminal.hpp"
#include "report/rig_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/calibrate_rig.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/scene/rig_pairing.hpp"
#include "watch/watch_report.hpp"

namespace tagcal::tools {
namespace {

constexpr std::size_t kAll = static_cast<std::size_t>(-1);
// A session calibrates from at most so many instants while it watches, which bounds its time, and
// from all of them at the end.
constexpr std::size_t kMostWatched = 60;

// The part of a rig with `most` of its instants, evenly spread, and their views.
RigDataset part_of(const RigDataset& rig, std::size_t most) {
  if (rig.instants.size() <= most) return rig;
  RigDataset part;
  for (const RigCamera& camera : rig.cameras) {
    part.cameras.push_back({camera.name, camera.data, {}});
    part.cameras.back().data.views.clear();
  }
  for (const std::size_t t : internal::spread_indices(rig.instants.size(), most)) {
    Instant instant = rig.instants[t];
    for (std::size_t c = 0; c < instant.view.size(); ++c) {
      if (!instant.view[c]) continue;
      std::vector<View>& views = part.cameras[c].data.views;
      views.push_back(rig.cameras[c].data.views[*instant.view[c]]);
      instant.view[c] = views.size() - 1;
    }
    part.instants.push_back(std::move(instant));
  }
  return part;
}

class RigSession {
 public:
  RigSession(RigWatchOptions options, std::vector<WatchedCamera> cameras,
             std::vector<std::string> warnings)
      : options_(std::move(options)),
        cameras_(std::move(cameras)),
        warnings_(std::move(warnings)) {}

  ExitCode run() {
    const Interruption interruption;
    std::string text = fmt::format("watching the folders of {}; the rig goes to {}; Ctrl-C ends",
                                   counted(cameras_.size(), "camera"), options_.out.string());
    text = wrapped("", text, 2);
    for (const std::string& warning : warnings_) text += remark_lines(warning);
    tell(text);
    for (;;) {
      const End end = step();
      if (end != End::none) return finish(end);
      Interruption::sleep(pause_until_look(options_.every, options_.timeout_s, last_change_));
    }
  }

 private:
  enum class End { none, goal, gone, timeout, interrupted };

  void tell(const std::string& text) const { tools::tell(text, options_.json); }

  End step() {
    if (Interruption::requested()) return End::interrupted;
    bool has_changed = false;
    for (WatchedCamera& camera : cameras_) {
      const std::optional<FolderListing> listing = list_folder(camera.folder);
      if (!listing && ++camera.missed_looks >= kMissedLooks) return End::gone;
      if (!listing) continue;
      camera.missed_looks = 0;
      tell(notices_.of_unread_files(camera.folder, camera.name));
      has_changed |= take(camera, camera.follower.look(*listing));
      if (camera.follower.awaits()) last_change_ = std::chrono::steady_clock::now();
    }
    if (has_changed) {
      recalibrate();
      is_first_ = false;
      last_change_ = std::chrono::steady_clock::now();
    }
    if (options_.goal_px > 0 && is_answer(rig_.status) && what_lacks().empty()) return End::goal;
    if (Interruption::requested()) return End::interrupted;
    const std::chrono::duration<double> quiet = std::chrono::steady_clock::now() - last_change_;
    return options_.timeout_s > 0 && quiet.count() > options_.timeout_s ? End::timeout : End::none;
  }

  // Returns true if the views with corners changed.
  bool take(WatchedCamera& camera, const FolderFollower::Events& events) {
    if (events.ready.empty() && events.removed.empty()) return false;
    const int revision = camera.pictures->revision();
    std::size_t num_found = 0, num_corners = 0;
    bool is_renamed = false;  // then it may belong to another instant
    std::vector<PictureNews> news = camera.pictures->update({events.ready, events.removed});
    const std::string repeated = repeated_line(news, camera.name);
    tell(repeated);
    for (PictureNews& told : news) {
      if (told.fate == Fate::repeated && !repeated.empty()) continue;
      if (told.fate == Fate::unreadable &&
          (Interruption::requested() || !camera.follower.postpone(told.name)))
        continue;
      if (told.fate == Fate::wrong_size) camera.follower.set_aside(told.name);
      last_change_ = std::chrono::steady_clock::now();
      told.name = camera.name + "/" + told.name;
      is_renamed |= told.fate == Fate::renamed;
      if (told.fate == Fate::board_found) {
        ++num_found;
        num_corners += told.num_corners;
      }
      if (told.fate != Fate::board_found || !is_first_) tell(news_line(told));
      for (const std::string& warning : told.warnings)
        tell(remark_lines(fmt::format("{}: {}", told.name, warning)));
    }
    tell(notices_.of_warnings(camera.pictures->general_warnings(), camera.name));
    if (is_first_ && num_found > 0)
      tell(fmt::format("{}: {}, {}\n", camera.name, counted(num_found, "picture"),
                       counted(num_corners, "corner")));
    if (!camera.pictures->has_corners()) camera.follower.recall_set_aside();
    return is_renamed || camera.pictures->revision() != revision;
  }

  // The views of the pictures so far. Throws Error if their names do not pair.
  RigDataset data(std::size_t most_instants) {
    RigDataset rig;
    for (const WatchedCamera& camera : cameras_)
      rig.cameras.push_back({camera.name, camera.pictures->dataset(), {}});
    rig.instants = pair_by_name(rig.cameras);
    num_paired_ = rig.instants.size();
    return part_of(rig, most_instants);
  }

  // Returns true for an answer, which the file has then.
  bool calibrate_from(std::size_t most_instants) {
    rig_ = {};
    unpaired_.clear();
    for (const WatchedCamera& camera : cameras_) {
      if (!camera.pictures->has_corners())
        unpaired_ = camera.name + ": no picture with the board yet";
      else if (const std::optional<Finding> wrong = camera.pictures->wrong_target())
        unpaired_ = camera.name + ": " + wrong->sentence;
    }
    if (!unpaired_.empty()) return false;
    try {
      used_ = data(most_instants);
      check_different(used_);
      const Progress progress("calibrating");
      rig_ = calibrate_rig(used_, options_.calibration);
    } catch (const Error& error) {
      unpaired_ = error.what();
      return false;
    }
    if (!is_answer(rig_.status)) return false;
    write_whole(options_.out, rig_yaml(rig_));
    kept_data_ = used_;
    kept_ = rig_;
    return true;
  }

  void recalibrate() {
    const bool answered = calibrate_from(kMostWatched);
    std::string text = !unpaired_.empty() ? "not yet: " + unpaired_
                       : !answered        ? "not yet: " + rig_verdict(rig_)
                                          : rig_verdict(rig_);
    if (answered && num_paired_ > kMostWatched)
      text += fmt::format(", from {} of {} instants", kMostWatched, num_paired_);
    if (answered && rig_.next)
      text += fmt::format(", places known to {} px", two_digits(rig_.next->sigma_px));
    tell(wrapped(toned(answered ? Tone::good : Tone::caution, "rig") + "  ", text, 6));
    for (const RigCameraEstimate& camera : rig_.cameras)
      tell(notices_.of_urgent_findings(camera.own.findings, camera.name));
    tell_next();
  }

  // The reason why the goal is not met; "": it is. Precondition: there is an answer.
  std::string what_lacks() const {
    if (rig_.next && rig_.next->sigma_px > options_.goal_px)
      return fmt::format(
          "the places of {} and {} are known to {} px in the picture, {} px is the goal",
          rig_.cameras[rig_.next->a].name, rig_.cameras[rig_.next->b].name,
          two_digits(rig_.next->sigma_px), options_.goal_px);
    for (const RigCameraEstimate& camera : rig_.cameras) {
      const Standing standing = standing_of(camera.own);
      if (!meets(standing, options_.goal_px))
        return camera.name + ": " + tools::what_lacks(standing, options_.goal_px);
    }
    return "";
  }

  // The pair that needs the board, or the camera, once all pairs reach the goal.
  std::string next_words() const {
    const bool pairs_suffice = rig_.next && rig_.next->sigma_px <= options_.goal_px;
    for (std::size_t c = 0; pairs_suffice && c < rig_.cameras.size(); ++c) {
      const Calibration& own = rig_.cameras[c].own;
      const Standing standing = standing_of(own);
      if (meets(standing, options_.goal_px)) continue;
      const auto advice = advise(used_.cameras[c].data, own);
      return next_lines(advice, standing, options_.goal_px, rig_.cameras[c].name);
    }
    return rig_.next ? wrapped("  next: ", rig_.next->sentence, 8) : "";
  }

  // Nothing if only numbers differ from what was said last.
  void tell_next() {
    if (options_.goal_px > 0 && is_answer(rig_.status) && what_lacks().empty()) return;
    const std::string text = next_words();
    std::string words = without_numbers(text);
    if (words == next_) return;
    next_ = words;
    tell(text);
  }

  ExitCode finish(End end) {
    if (kept_data_ && is_answer(rig_.status) && num_paired_ > kMostWatched) calibrate_from(kAll);
    const bool is_met = end == End::goal;
    std::string text = end == End::gone ? "a folder is gone\n"
                       : end == End::timeout
                           ? "no new picture for " + duration_text(options_.timeout_s) + "\n"
                       : end == End::interrupted ? "interrupted\n"
                                                 : "";
    if (is_met)
      text += wrapped(toned(Tone::good, "GOAL MET:") + " ",
                      fmt::format("lenses and places are known to {} px", options_.goal_px), 2);
    else if (options_.goal_px > 0)
      text += wrapped(toned(Tone::caution, "GOAL NOT MET:") + " ",
                      is_answer(rig_.status) ? what_lacks() : "there is no calibration", 2);
    if (kept_data_ && !is_answer(rig_.status))
      text += wrapped("! ",
                      "the latest picture made the calibration fail; showing the previous one", 2);
    if (!kept_data_)
      text += wrapped(
          toned(Tone::bad, "NO ANSWER:") + " ",
          unpaired_.empty() ? "the pictures so far give no rig; no file was written" : unpaired_,
          2);
    tell(text);
    if (kept_data_) {
      const std::size_t reference = options_.calibration.reference;
      print_answer(
          options_.json ? rig_json(*kept_data_, kept_, reference) : rig_summary(kept_, reference),
          options_.json, options_.out);
      say_wrote(options_.out);
    }
    for (WatchedCamera& camera : cameras_) camera.pictures->save_cache();
    if (!kept_data_) return kNoAnswer;
    return options_.goal_px > 0 && !is_met ? kCheckFailed : kAnswer;
  }

  RigWatchOptions options_;
  std::vector<WatchedCamera> cameras_;
  std::vector<std::string> warnings_;  // of the target's file
  std::chrono::steady_clock::time_point last_change_ = std::chrono::steady_clock::now();
  bool is_first_ = true;  // the pictures that were there before
  std::size_t num_paired_ = 0;
  std::string unpaired_;  // why there are no instants
  RigDataset used_;       // from which `rig_` is
  RigCalibration rig_;
  std::optional<RigDataset> kept_data_;  // of the last answer, as it stands in the file
  RigCalibration kept_;
  Notices notices_;
  std::string next_;  // the last `next:`, without numbers
};

}  // namespace

ExitCode watch_rig(RigWatchOptions options, std::vector<WatchedCamera> cameras,
                   std::vector<std::string> warnings) {
  return RigSession(std::move(options), std::move(cameras), std::move(warnings)).run();
}

}  // namespace tagcal::tools
