#include "tagcal/io/dataset_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/text/number_text.hpp"
#include "tagcal/io/text_file.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"
#include "tagcal/io/yaml/yaml_placed_boards.hpp"

namespace tagcal {
using namespace internal;
namespace {

namespace fs = std::filesystem;

std::vector<PlacedBoard> read_boards(const YamlValue& target, TargetFiles& targets,
                                     std::vector<std::string>* warnings) {
  std::vector<PlacedBoard> boards;
  if (target.is_list()) {
    std::size_t num_parts = 0;
    for (const YamlValue& item : target.items(1, limits::kMaxBoards)) {
      boards.push_back(read_placed_board(item, false, targets, warnings));
      count_parts(boards.back().board, target, num_parts);
    }
  } else {
    boards.push_back(read_placed_board(target, false, targets, warnings));
  }
  check_unique_ids(boards, target);
  return boards;
}

std::vector<fs::path> list_images(const fs::path& folder, const YamlValue& images) {
  std::error_code error;
  const fs::directory_iterator can_be_read(folder, error);
  if (error) images.fail("must be a folder of pictures (" + error.message() + ")");
  std::vector<fs::path> files = list_pictures(folder);
  if (files.empty())
    images.fail("must be a folder with pictures (png, jpg, tif, bmp, webp, pgm or ppm)");
  return files;
}

// Removes the pictures that cannot be opened, and returns why.
std::vector<std::string> check_sizes(std::vector<fs::path>& images, const ImageSize& size) {
  std::vector<std::string> unreadable;
  std::erase_if(images, [&](const fs::path& image) {
    ImageSize found;
    try {
      found = read_image_size(image);
    } catch (const Error& error) {
      unreadable.emplace_back(error.what());
      return true;
    }
    if (found == size) return false;
    throw Error(fmt::format("{}: is {}x{} pixels, but image_size in dataset.yaml is [{}, {}]",
                            image.string(), found.width, found.height, size.width, size.height));
  });
  return unreadable;
}

Truth read_truth_of(const fs::path& file, const ImageSize& size) {
  Truth truth = read_truth(file);
  const ImageSize& found = truth.camera.image_size;
  if (found != size) {
    throw Error(
        fmt::format("{}: camera: is for {}x{} pixels, but image_size in dataset.yaml is "
                    "[{}, {}]",
                    file.string(), found.width, found.height, size.width, size.height));
  }
  return truth;
}

bool is_identity(const Pose& pose) {
  return pose.rotation().coeffs() == Eigen::Quaterniond::Identity().coeffs() &&
         pose.translation() == Eigen::Vector3d::Zero();
}

// Writes the target files, and returns the value of the key `target`.
std::string write_boards(const fs::path& folder, const std::vector<PlacedBoard>& boards) {
  if (boards.size() == 1 && is_identity(boards[0].world_from_board)) {
    write_target(folder / "target.yaml", boards[0].board);
    return "target: target.yaml\n";
  }
  std::string text = "target:\n";
  for (std::size_t i = 0; i < boards.size(); ++i) {
    const std::string name = boards.size() == 1 ? "target.yaml" : fmt::format("target-{}.yaml", i);
    write_target(folder / name, boards[i].board);
    text += fmt::format("  - {{file: {}, world_from_board: {}}}\n", name,
                        pose_yaml(boards[i].world_from_board));
  }
  return text;
}

}  // namespace

DatasetFolder read_dataset(const fs::path& folder,
                           const std::function<bool(const fs::path&)>& leave_out) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw Error(folder.string() + ": must be the folder of a data set, with dataset.yaml in it");
  }
  const YamlValue top = YamlValue::read(folder / "dataset.yaml");
  top.allow_only({"image_size", "target", "observations", "images", "depth", "truth"});
  DatasetFolder read;
  Dataset& dataset = read.dataset;
  dataset.image_size = read_image_size_value(top.at("image_size"));
  TargetFiles targets;
  dataset.boards = read_boards(top.at("target"), targets, &read.warnings);
  read.texts = targets.names();
  read.texts.push_back(folder / "dataset.yaml");
  const auto observations = top.find("observations");
  const auto images = top.find("images");
  if (!observations && !images) top.fail_plainly("needs observations: FILE or images: FOLDER");
  if (observations) {
    read.observations = folder / observations->text();
    read.texts.push_back(read.observations);
    dataset.views = read_observations(read.observations, dataset.boards, &read.warnings);
  }
  if (images) {
    read.images = list_images(folder / images->text(), *images);
    if (leave_out) std::erase_if(read.images, leave_out);
    read.unreadable = check_sizes(read.images, dataset.image_size);
  }
  if (const auto depth = top.find("depth")) {
    depth->allow_only({"folder", "unit_m"});
    read.depth_unit_m = depth->at("unit_m").positive();
    read.depths = list_images(folder / depth->at("folder").text(), depth->at("folder"));
    const auto unreadable = check_sizes(read.depths, dataset.image_size);
    if (!unreadable.empty()) throw Error(unreadable.front());
  }
  if (const auto truth = top.find("truth")) {
    read.texts.push_back(folder / truth->text());
    dataset.truth = read_truth_of(read.texts.back(), dataset.image_size);
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
      write_boards(folder, dataset.boards);
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
