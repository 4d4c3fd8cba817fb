#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "commands/commands.hpp"
#include "commands/detect_tags_run.hpp"
#include "commands/rig_poses.hpp"
#include "draw/pose_drawing.hpp"
#include "job/arguments.hpp"
#include "job/camera_input.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/outputs.hpp"
#include "job/progress.hpp"
#include "job/terminal.hpp"
#include "report/pose_report.hpp"
#include "tagcal/error.hpp"
#include "tagcal/estimate/check_camera.hpp"
#include "tagcal/estimate/findings.hpp"
#include "tagcal/estimate/view_correspondences.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

struct PoseArguments {
  InputArguments input;
  int border_bits = 0;  // of --family; 0: not given
  std::string camera;
  std::string rig;
  std::string pair = "name";
  bool unknown_focal = false;
  bool exact_pinhole = false;
  double prior_focal_px = 0;
  double sigma_px = 0;
  double camera_error_px = 0;  // 0: what the camera's file says
  std::vector<std::string> views;
  std::string draw;
  std::string out;  // .csv, .json, .tum or .mcap
  int threads = 0;
  bool verbose = false;
  bool json = false;
};

void check_usage(const PoseArguments& arguments) {
  if (!arguments.camera.empty() + !arguments.rig.empty() + arguments.unknown_focal != 1)
    throw Error("--camera, --rig, --unknown-focal: one of them is needed, and only one");
  if (!arguments.rig.empty() && !(arguments.views.empty() && arguments.draw.empty()))
    throw Error("--view, --draw: not with --rig");
  if (!arguments.rig.empty() && !arguments.input.family.empty())
    throw Error("--family: not with --rig");
  if (arguments.rig.empty() && arguments.pair != "name") throw Error("--pair: needs --rig");
  if (arguments.prior_focal_px > 0 && !arguments.unknown_focal)
    throw Error("--prior-focal: needs --unknown-focal");
  if (arguments.exact_pinhole && !arguments.unknown_focal)
    throw Error("--exact-pinhole: needs --unknown-focal");
  if (!arguments.out.empty())
    check_pose_file(arguments.out, {!arguments.camera.empty(), !arguments.input.family.empty()});
  const InputArguments& input = arguments.input;
  if (arguments.border_bits > 0 && input.family.empty())
    throw Error("--border-bits: needs --family");
  if (input.family.empty()) return;
  if (!input.target.empty())
    throw Error("--family, --target: only one of the two is possible; the target has its family");
  if (!input.observations.empty())
    throw Error("--family: takes tags in pictures, not --observations");
  if (!(input.tag_size_m > 0)) throw Error("--family: needs --tag-size, the side of the tags");
}

struct KnownCamera {
  std::optional<UncertainCamera> camera;  // none: the focal length is estimated
  std::optional<double> camera_error_px;  // if known
};

KnownCamera known_camera(const PoseArguments& arguments, const Input& input) {
  KnownCamera known;
  if (!arguments.camera.empty()) {
    const CalibrationFile file = read_camera(arguments.camera);
    check_image_size(file.camera.image_size, arguments.camera, input);
    known = {uncertain_camera(file), file.camera_error_px};
  }
  if (arguments.camera_error_px > 0) known.camera_error_px = arguments.camera_error_px;
  return known;
}

using TargetPoints = std::map<CornerId, Vector3d>;

// A stated noise replaces the corners' covariances.
PoseAndFocalOptions options_for(const ViewCorrespondences& problem,
                                const PoseArguments& arguments) {
  PoseAndFocalOptions options;
  options.sigma_px = arguments.sigma_px;
  options.prior_focal_px = arguments.prior_focal_px;
  options.exact_pinhole = arguments.exact_pinhole;
  return problem.with_these(options);
}

PoseReport estimate(const ViewCorrespondences& problem, const PoseAndFocalOptions& options,
                    const std::optional<UncertainCamera>& camera, const ImageSize& image_size) {
  PoseReport report;
  if (problem.ids.empty())
    add(report.findings, code::target_unseen, "no corner of the target is seen");
  else if (camera)
    report = reported(estimate_pose(problem, *camera, options));
  else
    report = reported(estimate_pose_and_focal(problem, image_size, options), options);
  if (!options.covariance_px2.empty()) report.sigma_px.reset();
  report.corners = problem.ids;
  return report;
}

Camera camera_of(const PoseReport& report, const std::optional<UncertainCamera>& camera,
                 const ImageSize& image_size) {
  if (camera) return camera->camera;
  const Eigen::Vector2d centre = image_centre(image_size);
  return {pinhole(*report.focal_px, *report.focal_px, centre.x(), centre.y()), image_size};
}

Image8 picture_of(const View& view, const Input& input) {
  const auto source = std::ranges::find(input.images, view.image, &ImageSource::name);
  return source == input.images.end() ? Image8() : source->load();
}

// Estimates the poses of all views, and draws them if there is a folder.
class Poses {
 public:
  Poses(const PoseArguments& arguments, const Input& input, const KnownCamera& known)
      : arguments_(arguments),
        input_(input),
        camera_(known.camera),
        camera_error_px_(known.camera_error_px),
        points_(points_in_world(in_frame_of_poses(input.dataset.boards))) {}

  std::vector<PoseReport> run(const OutputFolder* folder) const {
    const std::vector<View>& views = input_.dataset.views;
    const std::vector<std::string> names = drawing_names(views);
    if (folder) check_drawings(names);
    std::vector<PoseReport> reports(views.size());
    Progress progress("poses", static_cast<int>(views.size()));
    const auto work = [&](std::size_t i) {
      const ViewCorrespondences problem = view_correspondences(views[i], points_, camera_error_px_);
      reports[i] =
          estimate(problem, options_for(problem, arguments_), camera_, input_.dataset.image_size);
      reports[i].image = views[i].image;
      reports[i].time_s = time_of(input_, views[i].image);
      if (camera_ && camera_->model)
        if (auto finding = contradiction_of_camera(views[i], input_.dataset.boards, *camera_))
          reports[i].findings.push_back(*std::move(finding));
      if (reports[i].focal_px) check_pinhole(views[i], reports[i]);
      report_mistakes(input_.mistakes, reports[i]);
      if (folder && is_answer(reports[i].status))
        write_png(folder->path() / names[i], drawn(views[i], problem, reports[i]));
    };
    parallel_for(views.size(), arguments_.threads, work,
                 [&](int done, int) { progress.update(done); });
    return reports;
  }

 private:
  // Adds a warning if the corners, by their own covariances, contradict the pinhole that was
  // fitted.
  void check_pinhole(const View& view, PoseReport& report) const {
    const UncertainCamera fitted{
        nullptr, camera_of(report, camera_, input_.dataset.image_size), {}};
    if (contradiction_of_camera(view, input_.dataset.boards, fitted))
      add(report.findings, code::residuals_correlated,
          arguments_.exact_pinhole
              ? "the corners show that the lens is no exact pinhole: the focal length may be wrong "
                "by many of its standard deviations; leave --exact-pinhole away"
              : "the corners show that the lens is no pinhole, which the standard deviations "
                "include: calibrate the lens");
  }

  void check_drawings(const std::vector<std::string>& names) const {
    std::vector<std::filesystem::path> drawings, pictures;
    for (const std::string& name : names)
      drawings.push_back(std::filesystem::path(arguments_.draw) / name);
    std::error_code none;
    for (const auto& [name, file] : input_.files) {
      pictures.push_back(file);
      if (std::filesystem::equivalent(file.parent_path(), arguments_.draw, none))
        throw Error(
            fmt::format("--draw: {} has the pictures, of which drawings would be taken for "
                        "more: name another folder",
                        arguments_.draw));
    }
    check_replaces_nothing(drawings, pictures);
  }

  ImageRgb drawn(const View& view, const ViewCorrespondences& problem,
                 const PoseReport& report) const {
    PoseDrawing drawing;
    drawing.camera = camera_of(report, camera_, input_.dataset.image_size);
    set_target(points_, drawing);
    drawing.corners = problem.correspondences;
    drawing.outliers = report.outliers;
    for (const PoseHypothesis& h : report.hypotheses)
      drawing.camera_from_target.push_back(h.camera_from_target);
    return draw_pose(drawing, picture_of(view, input_));
  }

  const PoseArguments& arguments_;
  const Input& input_;
  std::optional<UncertainCamera> camera_;
  std::optional<double> camera_error_px_;
  TargetPoints points_;
};

// Prints the reports, and keeps files and drawings of answers.
int finish(const PoseArguments& arguments, const std::vector<PoseReport>& reports,
           OutputFolder* drawings) {
  const auto answers =
      std::ranges::count_if(reports, [](const auto& r) { return is_answer(r.status); });
  if (drawings && answers > 0) {
    drawings->publish();
    say_wrote(arguments.draw);
  }
  print_answer(arguments.json ? pose_json(reports) : pose_text(reports, arguments.verbose),
               arguments.json);
  if (!arguments.out.empty() && answers > 0) write_poses(arguments.out, arguments.camera, reports);
  print_note("{} of {} with an answer\n", answers,
             counted(reports.size(), arguments.rig.empty() ? "view" : "instant"));
  return answers > 0 ? kAnswer : kNoAnswer;
}

InputArguments with_out(const PoseArguments& arguments) {
  InputArguments input = arguments.input;
  if (!arguments.out.empty()) input.other_outputs = {arguments.out};
  return input;
}

int run_rig(const PoseArguments& arguments) {
  const RigInputArguments rig =
      rig_arguments(with_out(arguments), arguments.pair, arguments.threads);
  return finish(arguments, poses_of_rig(rig, arguments.rig, arguments.sigma_px), nullptr);
}

int run(const PoseArguments& arguments) {
  check_usage(arguments);
  check_replaces_nothing(
      {arguments.out},
      {arguments.camera, arguments.rig, arguments.camera.substr(0, arguments.camera.rfind(':'))});
  if (!arguments.rig.empty()) return run_rig(arguments);
  Input input = read_input(with_out(arguments));
  if (!arguments.views.empty()) choose_views(input, arguments.views);
  const KnownCamera camera = known_camera(arguments, input);
  std::optional<OutputFolder> folder;
  if (!arguments.draw.empty()) folder.emplace(arguments.draw, OutputFolder::Taken::by_any_folder);
  const Camera* const lens = camera.camera ? &camera.camera->camera : nullptr;
  if (arguments.input.family.empty())
    find_views(input, arguments.threads, true, lens);
  else
    find_views_of_tags(
        {arguments.input, std::max(1, arguments.border_bits), "", "", "", arguments.threads, false},
        input, lens);
  if (input.dataset.views.empty() && !arguments.input.family.empty()) {
    print_warnings(input.warnings);
    print_result(fmt::format("NO ANSWER: no picture shows a tag of {}\n{}", arguments.input.family,
                             other_kind_text(input)));
    return kNoAnswer;
  }
  if (input.dataset.views.empty())
    throw Error(fmt::format("{}: has no corners of the pictures asked for", input.observations));
  OutputFolder* const drawings = folder ? &*folder : nullptr;
  const std::vector<PoseReport> reports = Poses(arguments, input, camera).run(drawings);
  print_warnings(input.warnings);
  if (camera.camera && !camera.camera->model)
    print_note("note: {} has no covariance: the lens is taken as exact\n", arguments.camera);
  return finish(arguments, reports, drawings);
}

// Pictures, and the camera or rig that took them.
void add_data(CLI::App& command, PoseArguments& arguments) {
  add_input(command, arguments.input);
  add_observations(command, arguments.input);
  add_family(command, arguments.input.family,
             "each tag of this family has its own pose, without a target; needs --tag-size");
  add_integer(
      command, "--border-bits", arguments.border_bits, 1,
      "width of these tags' black border in cells: 1 (the default), or 2 as on Kalibr's boards")
      .seldom()
      .text("N");
  add_option(command, "--camera", arguments.camera,
             "the camera's file, of any format (tagcal convert)")
      .text("CAMERA");
  add_option(command, "--rig", arguments.rig,
             "a rig's file, instead of --camera: one pose at each instant; a folder a camera")
      .text("RIG");
  add_pair(command, arguments.pair).seldom();
}

void add_estimate_and_outputs(CLI::App& command, PoseArguments& arguments) {
  add_flag(command, "--unknown-focal", arguments.unknown_focal,
           "estimate the focal length, too, of a centred pinhole; instead of --camera");
  add_flag(command, "--exact-pinhole", arguments.exact_pinhole,
           "with --unknown-focal: the lens is exactly that, as of rendered pictures; default: "
           "standard deviations include what lenses are instead")
      .seldom();
  add_positive(command, "--prior-focal", arguments.prior_focal_px,
               "px, for the pose where the view does not determine it");
  add_positive(
      command, "--sigma-px", arguments.sigma_px,
      "noise of the corners per coordinate; default: their covariances if the camera's error is "
      "known, else estimated from the residuals");
  add_positive(command, "--camera-error-px", arguments.camera_error_px,
               "error of lens and target per coordinate, in addition to the corners' own "
               "covariances; default: the value of the camera's file")
      .seldom();
  add_option(command, "--view", arguments.views,
             "only this picture, by its name; may be repeated")
      .text("NAME")
      .repeatable();  // the data set after it is none
  add_option(command, "--draw", arguments.draw,
             "folder for pictures with the target's axes and a box")
      .text("DIR");
  add_option(command, "--out", arguments.out,
             "file for the poses: .csv, .json, .tum, or .mcap for Foxglove and rerun")
      .text("FILE");
  add_flag(command, "--verbose", arguments.verbose, "also print the rotations and the noise");
  add_flag(command, "--json", arguments.json, "one JSON object on stdout");
  add_threads(command, arguments.threads);
}

}  // namespace

Command add_pose(CLI::App& app) {
  CLI::App* command =
      add_command(app, "pose", "the pose of each view, with a known or an unknown focal length");
  const auto arguments = std::make_shared<PoseArguments>();
  add_data(*command, *arguments);
  add_estimate_and_outputs(*command, *arguments);
  add_footer(*command,
             "Example: tagcal pose desk --camera camera.yaml --draw drawings\n"
             "         tagcal pose --target board.yaml photo.jpg --unknown-focal --json\n"
             "         tagcal pose --family tag36h11 --tag-size 0.08 photo.jpg --camera c.yaml\n"
             "         tagcal pose stereo --rig rig.yaml");
  return {command, [arguments] { return run(*arguments); }};
}

}  // namespace tagcal::tools
