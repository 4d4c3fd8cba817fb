#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tagcal/io/yaml/yaml_boards.hpp"
#include "tagcal/io/yaml/yaml_reader.hpp"
#include "tagcal/scene/dataset.hpp"

// Private to io: what the data sets of a camera and of a rig have in common
// (docs/reference/formats.md). Readers throw Error.

namespace tagcal::internal {

// The boards under `target`: a file, or a list of files and placed boards.
std::vector<PlacedBoard> read_dataset_boards(const YamlValue& target, TargetFiles& targets,
                                             std::vector<std::string>* warnings);

// Writes the target files, and returns the line or lines of the key `target`.
std::string write_dataset_boards(const std::filesystem::path& folder,
                                 const std::vector<PlacedBoard>& boards);

// The pictures of a folder, by name; throws, naming the key `images`, if there is none.
std::vector<std::filesystem::path> list_dataset_images(const std::filesystem::path& folder,
                                                       const YamlValue& images);

// Removes the pictures that cannot be opened, and returns why. Throws for a picture of another
// size; `stated` says in the message where the size comes from: "image_size in dataset.yaml".
std::vector<std::string> check_image_sizes(std::vector<std::filesystem::path>& images,
                                           const ImageSize& size, const std::string& stated);

// Throws, with the file's name, if the truth is that of another image size.
void check_truth_size(const Truth& truth, const std::filesystem::path& file, const ImageSize& size);

}  // namespace tagcal::internal
