#include "tagcal/io/dataset_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "tagcal/error.hpp"
#include "tagcal/internal/text.hpp"
#include "tagcal/io/dataset/dataset_parts.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_boards.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr const char* kStatedSize = "image_size in dataset.yaml";

// Throws, naming the folder of a camera if there is one.
[[noreturn]] void fail_for_rig(const fs::path& folder, const YamlValue& rig) {
  std::string camera;
  for (const YamlValue& item : rig.at("cameras").items(1, limits::kMaxRigCameras)) {
    const fs::path of_camera = folder / item.at("name").text();
    if (fs::exists(of_camera / "dataset.yaml"))
      camera = fmt::format(", or one of its cameras, {}", of_camera.string());
    if (!camera.empty()) break;
  }
  throw Error(fmt::format("{}: is the data set of a rig: use tagcal rig {}{}", folder.string(),
                          folder.string(), camera));
}

}  // namespace

DatasetFolder read_dataset(const fs::path& folder,
                           const std::function<bool(const fs::path&)>& leave_out) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw Error(folder.string() + ": must be the folder of a data set, with dataset.yaml in it");
  }
  const YamlValue top = YamlValue::read(folder / "dataset.yaml");
  if (const auto rig = top.find("rig")) fail_for_rig(folder, *rig);
  top.allow_only({"image_size", "target", "observations", "images", "depth", "truth"});
  DatasetFolder read;
  Dataset& dataset = read.dataset;
  dataset.image_size = read_image_size_value(top.at("image_size"));
  TargetFiles targets;
  dataset.boards = read_dataset_boards(top.at("target"), targets, &read.warnings);
  read.texts = targets.names();
  read.texts.push_back(folder / "dataset.yaml");
  const auto observations = top.find("observations");
  const auto images = top.find("images");
  if (!observations && !images) top.fail_plainly("needs observations: FILE or images: FOLDER");
  if (observations) {
    read.observations = folder / observations->text();
    read.texts.push_back(read.observations);
    dataset.views =
        read_observations(read.observations, dataset.boards, &read.warnings, &read.times_s);
  }
  if (images) {
    read.images = list_dataset_images(folder / images->text(), *images);
    if (leave_out) std::erase_if(read.images, leave_out);
    read.unreadable = check_image_sizes(read.images, dataset.image_size, kStatedSize);
  }
  if (const auto depth = top.find("depth")) {
    depth->allow_only({"folder", "unit_m"});
    read.depth_unit_m = depth->at("unit_m").positive();
    read.depths = list_dataset_images(folder / depth->at("folder").text(), depth->at("folder"));
    const auto unreadable = check_image_sizes(read.depths, dataset.image_size, kStatedSize);
    if (!unreadable.empty()) throw Error(unreadable.front());
  }
  if (const auto truth = top.find("truth")) {
    read.texts.push_back(folder / truth->text());
    dataset.truth = read_truth(read.texts.back());
    check_truth_size(*dataset.truth, read.texts.back(), dataset.image_size);
  }
  return read;
}

void write_dataset(const fs::path& folder, const Dataset& dataset, const std::string& images,
                   const std::string& observations, const std::optional<DepthFolder>& depth) {
  assert(!dataset.boards.empty() && !(images.empty() && observations.empty()));
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Error(folder.string() + ": cannot make the folder: " + error.message());
  std::string text =
      fmt::format("image_size: [{}, {}]\n", dataset.image_size.width, dataset.image_size.height) +
      write_dataset_boards(folder, dataset.boards);
  if (!images.empty()) text += "images: " + text_yaml(images) + "\n";
  if (depth)
    text +=
        fmt::format("depth: {{folder: {}, unit_m: {}}}\n", text_yaml(depth->folder), depth->unit_m);
  if (!observations.empty()) text += "observations: " + text_yaml(observations) + "\n";
  if (dataset.truth) {
    write_truth(folder / "truth.yaml", *dataset.truth);
    text += "truth: truth.yaml\n";
  }
  write_whole(folder / "dataset.yaml", text);
}

}  // namespace tagcal
