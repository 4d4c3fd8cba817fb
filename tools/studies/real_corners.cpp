// Calibrates real data sets and compares the answers with those of others: the published one
// (published.yaml) and mrcal's on the same corners (mrcal.yaml), which stand in the sets' folders.
// Compared are the projections at infinity after removing a rotation, as by `tagcal diff`: over the
// region of the answer's corners, for answers of others over that of all corners of the set.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <opencv2/core/persistence.hpp>

#include "real_sets.hpp"
#include "studies/studies.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal {
using namespace study;
namespace {

struct Run {
  const char* name;
  const char* model;
  bool flat = false;      // the board has no bend, twist or aspect
  bool keep_all = false;  // no corner is rejected
};

constexpr std::array<Run, 4> kRuns = {{{"opencv5", "opencv5"},
                                       {"opencv5, flat board", "opencv5", true},
                                       {"opencv5, all corners", "opencv5", false, true},
                                       {"auto", "auto"}}};
constexpr double kFlat = 1e-6;  // numeric: share of the board's size, far below what corners show

constexpr std::size_t kNumSetColumns = 10;

struct Folder {
  RealSet set;
  CalibrationFile published, mrcal;
  double mrcal_sd_px = 0;  // its own standard deviation of the projection, per coordinate
};

Calibration calibrate_run(Dataset set, const Run& run) {
  if (run.flat) set.boards.at(0).board.substrate = {kFlat, kFlat};
  CalibrateOptions options;
  options.model = run.model;
  options.reject_outliers = !run.keep_all;
  return calibrate(set, options);
}

double difference_px(const CalibrationFile& theirs, const CalibrationFile& ours) {
  const auto samples = common_samples(ours.camera.image_size, theirs.seen, ours.seen);
  const auto d = lens_difference(theirs.camera, ours.camera, samples, kInfinitelyFar);
  return d ? d->rms_px : std::nan("");
}

std::string parameters_text(const Camera& camera) {
  const auto p = parameters(camera.lens);
  return fmt::format("{:.2f}, {:.2f}, {:.2f}, {:.2f}", p[0], p[1], p[2], p[3]);
}

std::string bends_text(const Calibration& c) {
  if (!c.board_warp) return "";
  const Eigen::Vector2d &bend = c.board_warp->bend_mm, &sd = c.board_warp->sigma_mm;
  return fmt::format("{:.2f} +- {:.2f}, {:.2f} +- {:.2f}", bend.x(), sd.x(), bend.y(), sd.y());
}

std::string warnings_text(const Calibration& c) {
  std::string text;
  for (const Finding& f : c.findings)
    if (f.severity != Severity::note) text += (text.empty() ? "" : ", ") + f.code;
  return text;
}

Values row_of_run(const Folder& folder, const Run& run) {
  const Calibration c = calibrate_run(folder.set.dataset, run);
  Values row = {run.name, outcome(c), static_cast<double>(c.views.size()),
                static_cast<double>(c.num_corners)};
  if (has_focal_length(c) && !c.projection.empty()) {
    const CalibrationFile ours = calibration_file(c);
    const Values more = {parameters_text(*c.camera), c.projection[0].region_px,
                         difference_px(folder.published, ours), difference_px(folder.mrcal, ours),
                         run.flat ? "" : bends_text(c)};
    row.insert(row.end(), more.begin(), more.end());
  }
  row.resize(kNumSetColumns - 1, "");
  row.emplace_back(warnings_text(c));
  return row;
}

// The trials are the answers: the published one, mrcal's, and those of the runs.
std::vector<Values> measure(const Folder& folder, std::uint64_t answer) {
  if (answer >= 2) return {row_of_run(folder, kRuns.at(answer - 2))};
  if (answer == 0)
    return {
        {"published", "", "", "", parameters_text(folder.published.camera), "", "", "", "", ""}};
  CalibrationFile mrcal = folder.mrcal;
  mrcal.seen = region_of(folder.set.dataset);
  return {{"mrcal", "", "", "", parameters_text(mrcal.camera), folder.mrcal_sd_px,
           difference_px(folder.published, mrcal), "", "", ""}};
}

std::vector<Task> real_corners_tasks(const StudyOptions& options) {
  std::vector<Task> tasks;
  std::vector<RealSet> sets = read_sets(options.inputs);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const std::string path = options.inputs[i] + "/";
    cv::FileStorage file(path + "mrcal.yaml", cv::FileStorage::READ);
    const auto folder = std::make_shared<const Folder>(
        Folder{std::move(sets[i]), read_calibration(path + "published.yaml"),
               read_calibration(path + "mrcal.yaml"), file["projection_sd_px"].real()});
    tasks.push_back({folder->set.name, [=](std::uint64_t trial) { return measure(*folder, trial); },
                     static_cast<int>(kRuns.size()) + 2});
  }
  return tasks;
}

// The text of the one row of a line.
Figure text_of(const std::string& heading, const std::string& column) {
  return {heading, [=](const Sample& sample) { return sample.texts(column).front(); }};
}

}  // namespace

Study real_corners_study() {
  return {
      .name = "real_corners",
      .summary = "calibrations of real data sets against those of others",
      .inputs = "folders of data sets, with published.yaml and mrcal.yaml",
      .count = 0,
      .first = 0,
      .columns = {"answer", "model", "views", "corners", "parameters", "sd_px", "published_px",
                  "mrcal_px", "bends", "warnings"},
      .tasks = real_corners_tasks,
      .tables = {{{"task", "answer"},
                  {text_of("model", "model"), sum_of("views", "views"),
                   sum_of("corners", "corners"), text_of("fx, fy, cx, cy", "parameters"),
                   sum_of("sd, px", "sd_px", 3), sum_of("to the published, px", "published_px", 3),
                   sum_of("to mrcal, px", "mrcal_px", 3), text_of("bends, mm", "bends"),
                   text_of("warnings", "warnings")}}}};
}

}  // namespace tagcal
