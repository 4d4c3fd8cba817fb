#include <fmt/format.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "commands/commands.hpp"
#include "job/arguments.hpp"
#include "job/digest.hpp"
#include "job/find_corners.hpp"
#include "job/messages.hpp"
#include "job/output_folder.hpp"
#include "job/progress.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/error.hpp"
#include "tagcal/internal/parallel.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/rig_file.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/scene/render.hpp"
#include "tagcal/version.hpp"

namespace tagcal::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* kImages = "images";
constexpr const char* kDepths = "depth";
constexpr const char* kCorners = "observations_exact.csv";
constexpr const char* kNothingSeen =
    "no corner of a board is visible in any picture: see tagcal view SCENE.yaml --svg";

struct RenderArguments {
  std::string scene;
  std::string out;
  int views = 0;  // 0: the scene's
  int seed = 0;
  int threads = 0;
  bool force = false;
  bool resume = false;
  bool depth = false;
  double depth_unit_m = 0;  // 0: a millimetre
};

// What a camera of the scene makes of it.
struct SeenByCamera {
  std::string folder;  // in that of the command; "": itself, for a scene with one camera
  MovingScene scene;
  std::vector<Pose> camera_from_world;
  Dataset dataset;
  std::uint64_t noise_seed = 0;
};

struct Work {
  std::vector<SeenByCamera> cameras;
  std::optional<RigDataset> rig;
};

void check_pixels(const RenderArguments& arguments, const ImageSize& size) {
  if (std::int64_t{size.width} * size.height > scene_limits().pixels)
    throw Error(fmt::format("{}: camera: a picture must have at most {} pixels, got {}x{}",
                            arguments.scene, scene_limits().pixels, size.width, size.height));
}

// Replaces the scene's number of views by that of the arguments.
void set_views(const RenderArguments& arguments, MovingScene& scene) {
  if (arguments.views == 0) return;
  if (auto* path = std::get_if<ExplicitPath>(&scene.settings.path)) {
    const int poses = static_cast<int>(path->camera_from_world.size());
    if (arguments.views > poses) {
      throw Error(fmt::format("--views: must be {} at most, the poses in {}, got {}", poses,
                              arguments.scene, arguments.views));
    }
    path->camera_from_world.resize(arguments.views);
  }
  scene.settings.num_views = arguments.views;
}

Work work_with_camera(const RenderArguments& arguments, MovingScene scene,
                      std::vector<std::string>* warnings) {
  const auto seed = static_cast<std::uint64_t>(arguments.seed);
  const std::vector<Pose> poses = camera_poses(scene, seed);
  Dataset dataset = exact_dataset(scene, poses, warnings);
  if (num_corners(dataset.views) == 0) warnings->emplace_back(kNothingSeen);
  return {{{"", std::move(scene), poses, std::move(dataset), seed}}, {}};
}

Work work_with_rig(const RenderArguments& arguments, const RigScene& rig,
                   std::vector<std::string>* warnings) {
  const auto seed = static_cast<std::uint64_t>(arguments.seed);
  Work work;
  work.rig = exact_rig_dataset(rig, seed, warnings);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    MovingScene scene = scene_of_camera(rig, c, seed);
    const std::vector<Pose> poses = camera_poses(scene, seed);
    const Dataset& dataset = work.rig->cameras[c].data;
    if (num_corners(dataset.views) == 0)
      warnings->push_back(fmt::format("no corner of a board is visible in any picture of camera {}",
                                      rig.cameras[c].name));
    work.cameras.push_back(
        {rig.cameras[c].name, std::move(scene), poses, dataset, camera_seed(seed, c)});
  }
  return work;
}

Work work_to_do(const RenderArguments& arguments, std::vector<std::string>* warnings) {
  if (arguments.views > scene_limits().views)
    throw Error(
        fmt::format("--views: must be {} at most, got {}", scene_limits().views, arguments.views));
  AnyScene scene = read_any_scene(arguments.scene, warnings);
  auto* rig = std::get_if<RigScene>(&scene);
  MovingScene& moving = rig ? rig->scene : std::get<MovingScene>(scene);
  check_pixels(arguments, moving.settings.camera.image_size);
  if (rig)
    for (const RigSceneCamera& camera : rig->cameras)
      check_pixels(arguments, camera.camera.image_size);
  set_views(arguments, moving);
  return naming(arguments.scene, [&] {
    return rig ? work_with_rig(arguments, *rig, warnings)
               : work_with_camera(arguments, std::move(moving), warnings);
  });
}

std::optional<DepthFolder> depth_folder(const RenderArguments& arguments) {
  if (!arguments.depth && arguments.depth_unit_m > 0)
    throw Error("--depth-unit-m: belongs to --depth");
  if (!arguments.depth) return std::nullopt;
  DepthFolder depth{kDepths};
  if (arguments.depth_unit_m > 0) depth.unit_m = arguments.depth_unit_m;
  return depth;
}

// `picture_by` takes the function that exposes the light, whose memory is free again when the
// picture is written.
template <typename PictureBy>
void write_picture(const fs::path& file, int bits, const PictureBy& picture_by) {
  if (bits == 16)
    write_png(file, picture_by(expose16));
  else
    write_png(file, picture_by(expose));
}

// Writes the depths of a view, and returns the number of pixels whose depth is beyond the range.
std::size_t write_depth(const fs::path& file, const Scene& scene, const Pose& camera_from_world,
                        double unit_m) {
  std::size_t num_beyond = 0;
  write_png(file, depth_levels(render_depth(scene, camera_from_world), unit_m, &num_beyond));
  return num_beyond;
}

void warn_of_depths(std::size_t num_beyond, double unit_m, std::vector<std::string>& warnings) {
  if (num_beyond == 0) return;
  warnings.push_back(
      fmt::format("the depth of {} pixels is not between {:g} and {:g} m and is written as 0: take "
                  "another --depth-unit-m",
                  num_beyond, unit_m, 65535 * unit_m));
}

// What a resumed render must have in common with the one that it goes on with: the version, the
// scene, all files that were read for it, and the options that change a picture.
std::string text_of(const Work& work, const RenderArguments& arguments,
                    const std::optional<DepthFolder>& depth) {
  if (!fs::is_regular_file(arguments.scene))
    throw Error(fmt::format("--resume: needs the scene in a file, got {}", arguments.scene));
  std::string boards, corners;
  for (const PlacedBoard& placed : scene_in_view(work.cameras.front().scene, 0).boards)
    boards += target_yaml(placed.board);
  for (const SeenByCamera& camera : work.cameras) corners += observations_csv(camera.dataset.views);
  return fmt::format("tagcal {}\nscene {}\nboards {}\ncorners {}\nviews {}\nseed {}\ndepth {}\n",
                     TAGCAL_VERSION, digest_of_file(arguments.scene), digest_of(boards),
                     digest_of(corners), work.cameras.front().camera_from_world.size(),
                     arguments.seed, depth ? depth->unit_m : 0);
}

// Writes the pictures that are not there yet, and the depths of all. Returns the number of pixels
// whose depth is beyond the range.
std::size_t write_pictures(const fs::path& folder, const SeenByCamera& camera,
                           const RenderArguments& arguments,
                           const std::optional<DepthFolder>& depth) {
  const std::vector<Pose>& poses = camera.camera_from_world;
  const TagFamilies families =
      naming(arguments.scene, [&] { return tag_families(scene_in_view(camera.scene, 0).boards); });
  fs::create_directories(folder / kImages);
  if (depth) fs::create_directory(folder / kDepths);
  std::atomic<std::size_t> num_beyond = 0;
  Progress progress(camera.folder.empty() ? "rendering" : "rendering " + camera.folder,
                    static_cast<int>(poses.size()));
  parallel_for(
      poses.size(), arguments.threads,
      [&](std::size_t i) {
        const int view = static_cast<int>(i);
        const std::string name = image_name(view);
        const Scene in_view = scene_in_view(camera.scene, view);
        const auto picture_by = [&](auto expose_light) {
          return naming(arguments.scene, [&] {
            return expose_light(render_light(in_view, families, poses[i]), in_view.sensor,
                                noise_seed(camera.noise_seed, view));
          });
        };
        if (!fs::exists(folder / kImages / name))
          write_picture(folder / kImages / name, in_view.sensor.bits, picture_by);
        if (depth)
          num_beyond += write_depth(folder / kDepths / name, in_view, poses[i], depth->unit_m);
      },
      [&](int done, int) { progress.update(done); });
  return num_beyond;
}

// Writes the data set of each camera, and that of the rig. Returns as write_pictures.
std::size_t write_all(const fs::path& out, const Work& work, const RenderArguments& arguments,
                      const std::optional<DepthFolder>& depth) {
  std::size_t num_beyond = 0;
  for (const SeenByCamera& camera : work.cameras) {
    const fs::path folder = camera.folder.empty() ? out : out / camera.folder;
    num_beyond += write_pictures(folder, camera, arguments, depth);
    write_dataset(folder, camera.dataset, kImages, "", depth);
    write_whole(folder / kCorners, observations_csv(camera.dataset.views));
  }
  if (work.rig) write_rig_dataset(out, *work.rig, {kImages, kCorners, "truth.yaml"});
  return num_beyond;
}

std::string amount_of(const Work& work) {
  std::size_t corners = 0;
  for (const SeenByCamera& camera : work.cameras) corners += num_corners(camera.dataset.views);
  const std::size_t images = work.cameras.front().camera_from_world.size();
  if (!work.rig) return fmt::format("{} images, {} exact corners", images, corners);
  return fmt::format("{} images of each of {} cameras, {} exact corners", images,
                     work.cameras.size(), corners);
}

int run(const RenderArguments& arguments) {
  const std::optional<DepthFolder> depth = depth_folder(arguments);
  std::vector<std::string> warnings;
  const Work work = work_to_do(arguments, &warnings);
  using Taken = OutputFolder::Taken;
  const Taken taken = arguments.force ? Taken::by_earlier_render : Taken::by_nothing;
  OutputFolder folder = arguments.resume
                            ? OutputFolder(arguments.out, taken, text_of(work, arguments, depth))
                            : OutputFolder(arguments.out, taken);
  const std::size_t num_beyond = write_all(folder.path(), work, arguments, depth);
  folder.publish();
  if (depth) warn_of_depths(num_beyond, depth->unit_m, warnings);
  print_warnings(warnings);
  say_wrote(arguments.out, amount_of(work));
  return kAnswer;
}

}  // namespace

Command add_render(CLI::App& app) {
  CLI::App* command =
      add_command(app, "render", "images and exact corners of a scene, as a data set");
  const auto arguments = std::make_shared<RenderArguments>();
  add_option(*command, "SCENE.yaml", arguments->scene, "the scene").required();
  add_option(
      *command, "--out", arguments->out,
      "folder to write: images, dataset.yaml, targets, truth.yaml; of a rig, a folder of these for "
      "each camera")
      .text("DIR")
      .required();
  add_flag(*command, "--force", arguments->force, "replace an earlier render in that folder");
  add_flag(
      *command, "--resume", arguments->resume,
      "keep what is rendered, in DIR.partial, when the run is interrupted, and go on from there");
  add_integer(*command, "--views", arguments->views, 1, "number of views, instead of the scene's");
  add_integer(*command, "--seed", arguments->seed, 0, "seed of path jitter and sensor noise (0)");
  add_flag(*command, "--depth", arguments->depth,
           "also write depth/: z in the camera as 16-bit pictures, millimetres, 0 for nothing");
  add_length(*command, "--depth-unit-m", arguments->depth_unit_m,
             "unit of --depth in metres (0.001)");
  add_threads(*command, arguments->threads);
  add_footer(*command,
             "Example: tagcal render data-synthetic/scenes/desk.yaml --out desk --seed 7");
  return {command, [arguments] { return run(*arguments); }, true};
}

}  // namespace tagcal::tools
