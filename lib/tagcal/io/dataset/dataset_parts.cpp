#include "tagcal/io/dataset/dataset_parts.hpp"

#include <fmt/format.h>

#include <system_error>

#include "tagcal/error.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/target_file.hpp"
#include "tagcal/io/text/limits.hpp"
#include "tagcal/io/yaml/yaml_parts.hpp"

namespace tagcal::internal {
namespace {

namespace fs = std::filesystem;

bool is_identity(const Pose& pose) {
  return pose.rotation().coeffs() == Eigen::Quaterniond::Identity().coeffs() &&
         pose.translation() == Eigen::Vector3d::Zero();
}

}  // namespace

std::vector<PlacedBoard> read_dataset_boards(const YamlValue& target, TargetFiles& targets,
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

std::vector<fs::path> list_dataset_images(const fs::path& folder, const YamlValue& images) {
  std::error_code error;
  const fs::directory_iterator can_be_read(folder, error);
  if (error) images.fail("must be a folder of pictures (" + error.message() + ")");
  std::vector<fs::path> files = list_pictures(folder);
  if (files.empty())
    images.fail(
        "must be a folder with pictures (png, jpg, tif, bmp, webp, heic, avif, pgm or ppm)");
  return files;
}

std::vector<std::string> check_image_sizes(std::vector<fs::path>& images, const ImageSize& size,
                                           const std::string& stated) {
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
    throw Error(fmt::format("{}: is {}x{} pixels, but {} is [{}, {}]", image.string(), found.width,
                            found.height, stated, size.width, size.height));
  });
  return unreadable;
}

void check_truth_size(const Truth& truth, const fs::path& file, const ImageSize& size) {
  const ImageSize& found = truth.camera.image_size;
  if (found == size) return;
  throw Error(
      fmt::format("{}: camera: is for {}x{} pixels, but image_size in dataset.yaml is [{}, {}]",
                  file.string(), found.width, found.height, size.width, size.height));
}

std::string write_dataset_boards(const fs::path& folder, const std::vector<PlacedBoard>& boards) {
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

}  // namespace tagcal::internal
