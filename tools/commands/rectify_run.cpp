#include "commands/reproject_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "commands/rig_input.hpp"
#include "draw/rectified_sheet.hpp"
#include "job/camera_input.hpp"
#include "job/command.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/outputs.hpp"
#include "job/picture_files.hpp"
#include "job/progress.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/internal/spread_indices.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/camera_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/rig_calibration_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/reproject/maps.hpp"
#include "tagcal/reproject/rectify.hpp"
#include "tagcal/reproject/resampling.hpp"
#include "tagcal/scene/rig_pairing.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostSheets = 5;  // pictures with lines across both views
constexpr int kSheetWidth = 2000;       // px at most
// A disparity that is this many times what the claims expect is worth a warning: pictures of
// different instants, or a camera that moved, are far beyond it.
constexpr double kMuchLarger = 3;

// The corners of a target in all pairs.
struct DisparityOfCorners {
  int num_corners = 0, num_pairs = 0;
  double sum = 0, expected = 0, of_rig = 0;  // squared, px^2

  static double rms(double sum, int count) { return std::sqrt(sum / count); }
};

class RectifyRun {
 public:
  explicit RectifyRun(const ReprojectArguments& arguments) : arguments_(arguments) {}

  int run() {
    check_usage();
    read_rig();
    rectify_pair();
    read_pictures();
    check_new_files(arguments_.task.rectify, files(), inputs(), arguments_.force);
    find_corners();
    OutputFolder folder(arguments_.task.rectify, OutputFolder::Taken::by_any_folder);
    write(folder.path());
    folder.publish();
    say_report();
    return kAnswer;
  }

 private:
  void check_usage() const {
    const std::size_t n = arguments_.images.size();
    if (!arguments_.out.empty()) throw Error("--out: --rectify names the folder");
    if (arguments_.task.rectify == "-")
      throw Error("--rectify: - is standard output, which takes text only: take ./-");
    if (!arguments_.view.empty()) throw Error("--view: belongs to --plane");
    if (arguments_.mask) throw Error("--mask: not with --rectify");
    if (n != 2 && !(n == 0 && arguments_.maps))
      throw Error(
          fmt::format("--rectify: needs the pictures of two cameras, a folder or picture "
                      "each, got {}{}",
                      n, n == 0 ? " (or --maps without pictures)" : ""));
    if (n == 0 && !arguments_.target.empty()) throw Error("--target: needs pictures");
    const std::vector<std::string>& cameras = arguments_.task.cameras;
    if (!cameras.empty() && cameras.size() != 2)
      throw Error(fmt::format("--cameras: must be two names, got {}", cameras.size()));
  }

  void read_rig() {
    const CameraFile file = read_camera_file(arguments_.camera);
    hold_notes(arguments_.camera, file.notes);
    rig_ = known_rig(file, arguments_.camera);
  }

  std::optional<std::size_t> camera_of(const std::string& name) const {
    const auto found = std::ranges::find(rig_.cameras, name, &KnownRig::Member::name);
    if (found == rig_.cameras.end()) return std::nullopt;
    return static_cast<std::size_t>(found - rig_.cameras.begin());
  }

  // By --cameras or the names of the folders; of a rig of two cameras whose names are others, in
  // their order.
  std::array<std::size_t, 2> cameras() const {
    std::vector<std::string> names = arguments_.task.cameras;
    const bool by_option = !names.empty();
    if (names.empty() && !arguments_.images.empty()) names = camera_names(arguments_.images);
    std::vector<std::optional<std::size_t>> found;
    for (const std::string& name : names) found.push_back(camera_of(name));
    const bool by_order = !by_option && rig_.cameras.size() == 2 &&
                          std::ranges::none_of(found, [](const auto& c) { return c.has_value(); });
    if (by_order) return {0, 1};
    const std::string known = internal::joined(rig_.cameras, ", ", &KnownRig::Member::name);
    if (found.empty()) throw Error(fmt::format("--rectify: needs --cameras, two of {}", known));
    for (std::size_t k = 0; k < 2; ++k)
      if (!found[k])
        throw Error(
            fmt::format("{}: has no camera {}, only {}: folders must have the cameras' "
                        "names, or give --cameras",
                        arguments_.camera, names[k], known));
    return {*found[0], *found[1]};
  }

  void rectify_pair() {
    RectifyOptions options;
    options.longlat = arguments_.task.longlat;
    if (!arguments_.task.alpha.empty()) {
      options.alpha = numbers_argument("--alpha", {arguments_.task.alpha}, 1).front();
      if (!(*options.alpha >= 0 && *options.alpha <= 1))
        throw Error(fmt::format("--alpha: must be from 0 to 1, got {}", arguments_.task.alpha));
      if (options.longlat) throw Error("--alpha: not with --longlat");
    }
    const auto [first, second] = cameras();
    pair_ = naming(arguments_.camera, [&] { return rectify(rig_, first, second, options); });
    for (std::size_t k = 0; k < 2; ++k) names_[k] = rig_.cameras[pair_.cameras[k]].name;
  }

  const Camera& camera(std::size_t k) const { return rig_.cameras[pair_.cameras[k]].camera.camera; }

  // The pictures of both cameras, and which belong together.
  void read_pictures() {
    if (arguments_.images.empty()) return;
    std::vector<RigCamera> cameras(2);
    for (std::size_t k = 0; k < 2; ++k) {
      pictures_[k] = new_pictures(picture_files({arguments_.images[k]}, frame_choice("evenly")),
                                  camera(k), arguments_.camera);
      cameras[k].name = names_[k];
      for (const fs::path& file : pictures_[k].files)
        cameras[k].data.views.push_back({picture_name(file), {}});
    }
    const bool are_single = pictures_[0].files.size() == 1 && pictures_[1].files.size() == 1;
    for (const Instant& instant : are_single ? pair_by_index(cameras) : pair_by_name(cameras))
      if (instant.view[0] && instant.view[1])
        pairs_.push_back({*instant.view[0], *instant.view[1]});
    for (std::size_t k = 0; k < 2; ++k)
      if (const auto alone = pictures_[k].files.size() - pairs_.size(); alone > 0)
        print_warnings({fmt::format("{} of {} pictures of {} have no picture of {}: left out",
                                    alone, pictures_[k].files.size(), names_[k], names_[1 - k])});
  }

  fs::path picture_of(std::size_t i, std::size_t k) const {
    return fs::path(names_[k]) / pictures_[k].names[pairs_[i][k]];
  }

  fs::path sheet_of(std::size_t i) const {
    return fs::path("lines") / pictures_[0].names[pairs_[i][0]];
  }

  fs::path target_of(std::size_t k) const {
    return fs::path(names_[k]) / target_file_name(pair_.targets[k]);
  }

  fs::path map_of(std::size_t k) const { return fs::path(names_[k]) / "map.npy"; }

  std::vector<fs::path> files() const {
    std::vector<fs::path> files = {"rectified.yaml"};
    for (std::size_t k = 0; k < 2; ++k) {
      files.push_back(target_of(k));
      if (arguments_.maps) files.push_back(map_of(k));
      for (std::size_t i = 0; i < pairs_.size(); ++i) files.push_back(picture_of(i, k));
    }
    for (const std::size_t i : spread_indices(pairs_.size(), kMostSheets))
      files.push_back(sheet_of(i));
    return files;
  }

  std::vector<fs::path> inputs() const {
    std::vector<fs::path> inputs = {arguments_.camera, arguments_.target};
    for (const NewPictures& pictures : pictures_)
      inputs.insert(inputs.end(), pictures.files.begin(), pictures.files.end());
    return inputs;
  }

  // The disparities of the corners that both cameras see.
  void find_corners() {
    if (arguments_.target.empty()) return;
    std::array<std::map<std::string, View>, 2> views;
    for (std::size_t k = 0; k < 2; ++k) {
      Dataset dataset;
      std::vector<std::string> warnings;
      dataset.boards = {{read_target(arguments_.target, {}, &warnings), Pose()}};
      dataset.image_size = camera(k).image_size;
      std::vector<fs::path> files;
      for (const auto& pair : pairs_) files.push_back(pictures_[k].files[pair[k]]);
      Input input = input_of(arguments_.target, dataset, files);
      input.warnings = warnings;
      detect_views(input, arguments_.threads);
      print_warnings(input.warnings);
      for (View& view : input.dataset.views) views[k][view.image] = std::move(view);
    }
    DisparityOfCorners sum;
    for (const auto& pair : pairs_) {
      const View& first = views[0][picture_name(pictures_[0].files[pair[0]])];
      const View& second = views[1][picture_name(pictures_[1].files[pair[1]])];
      const int before = sum.num_corners;
      for (const Observation& a : first.observations)
        for (const Observation& b : second.observations)
          if (a.id == b.id) add(a, b, sum);
      sum.num_pairs += sum.num_corners > before;
    }
    disparity_ = sum;
  }

  void add(const Observation& a, const Observation& b, DisparityOfCorners& sum) const {
    const Matrix2 none = Matrix2::Zero();
    const auto found =
        vertical_disparity(rig_, pair_,
                           {UncertainPixel{a.pixel, a.covariance_px2.value_or(none)},
                            UncertainPixel{b.pixel, b.covariance_px2.value_or(none)}});
    if (!found) return;
    ++sum.num_corners;
    sum.sum += found->difference_px * found->difference_px;
    sum.expected += found->sigma_px * found->sigma_px;
    sum.of_rig += found->sigma_of_rig_px * found->sigma_of_rig_px;
  }

  void write(const fs::path& folder) const {
    for (std::size_t k = 0; k < 2; ++k) {
      fs::create_directories(folder / names_[k]);
      const Reprojection chain = rectification(rig_, pair_, k);
      write_whole(folder / target_of(k),
                  target_yaml(pair_.targets[k], {{"", chain.camera_from_target}},
                              arguments_.camera + ":" + names_[k]));
      if (arguments_.maps)
        write_whole(folder / map_of(k), map_npy(pixel_map(chain, arguments_.threads)));
    }
    write_whole(folder / "rectified.yaml", rectified_yaml(pair_, names_));
    Progress progress("rectifying", static_cast<int>(2 * pairs_.size()));
    const int own_threads = pairs_.size() == 1 ? arguments_.threads : 1;
    parallel_for(
        2 * pairs_.size(), static_cast<std::size_t>(arguments_.threads),
        [&](std::size_t i) { write_picture(folder, i / 2, i % 2, own_threads); },
        [&](int done, int) { progress.update(done); });
    if (!pairs_.empty()) fs::create_directories(folder / "lines");
    for (const std::size_t i : spread_indices(pairs_.size(), kMostSheets))
      write_png(folder / sheet_of(i),
                rectified_sheet(rig_, pair_,
                                {read_image(pictures_[0].files[pairs_[i][0]]),
                                 read_image(pictures_[1].files[pairs_[i][1]])},
                                kSheetWidth));
  }

  void write_picture(const fs::path& folder, std::size_t i, std::size_t k, int threads) const {
    write_reprojected(pictures_[k].files[pairs_[i][k]], rectification(rig_, pair_, k), arguments_,
                      threads, folder / picture_of(i, k));
  }

  void say_report() const {
    const fs::path folder = arguments_.task.rectify;
    say_wrote(folder,
              fmt::format("{} of {} and {}, rectified.yaml ({}, baseline {:.5g} m){}",
                          pairs_.size() == 1 ? "1 pair" : fmt::format("{} pairs", pairs_.size()),
                          names_[0], names_[1], described(pair_.targets[0]),
                          std::abs(pair_.translation_m), arguments_.maps ? ", map.npy" : ""));
    if (pair_.translation_m > 0)
      print_to_stderr(
          "tagcal: warning: {} is {} {}: disparities are negative; exchange the two for programs "
          "that expect positive ones\n",
          names_[1], pair_.is_vertical ? "above" : "left of", names_[0]);
    if (!disparity_) return;
    const DisparityOfCorners& d = *disparity_;
    if (d.num_corners == 0)
      return print_text("vertical disparity: no pair shows a corner in both pictures\n");
    const auto rms = [&](double sum) { return DisparityOfCorners::rms(sum, d.num_corners); };
    print_text(
        fmt::format("{} disparity of {} corners in {} pairs: rms {:.3g} px, expected {:.2g} px "
                    "({:.2g} px of it "
                    "by the rig)\n",
                    pair_.is_vertical ? "horizontal" : "vertical", d.num_corners, d.num_pairs,
                    rms(d.sum), rms(d.expected), rms(d.of_rig)));
    if (rms(d.sum) > kMuchLarger * rms(d.expected))
      print_to_stderr(
          "tagcal: warning: the rows differ by more than the claims explain: the pictures of a "
          "pair "
          "are not of one instant, a camera moved since the calibration, or the corners are worse "
          "than their covariances say\n");
  }

  const ReprojectArguments& arguments_;
  KnownRig rig_;
  RectifiedPair pair_;
  std::array<std::string, 2> names_;
  std::array<NewPictures, 2> pictures_;
  std::vector<std::array<std::size_t, 2>> pairs_;  // of pictures
  std::optional<DisparityOfCorners> disparity_;
};

}  // namespace

int run_rectify(const ReprojectArguments& arguments) { return RectifyRun(arguments).run(); }

}  // namespace tagcal::tools
