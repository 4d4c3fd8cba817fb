#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal {

// A data set on disk (DATASET is a folder with dataset.yaml; docs/reference/formats.md).
struct DatasetFolder {
  Dataset dataset;                            // without views if there are only images
  std::filesystem::path observations;         // the file with the views; empty: none
  std::map<std::string, double> times_s;      // of the views, by image name, where they have one
  std::vector<std::filesystem::path> images;  // of `images: FOLDER`, sorted by name
  std::vector<std::string> unreadable;        // pictures that are not in `images`: file and reason
  std::vector<std::filesystem::path> depths;  // of `depth`, sorted by name
  double depth_unit_m = 0;                    // of their values; 0: no depths
  std::vector<std::filesystem::path> texts;   // all other files that were read
  std::vector<std::string> warnings;
};

// Reads and checks dataset.yaml, its targets, observations and truth. Throws Error: see the
// functions below, and image_size that is not positive, ids that two boards share, pictures of
// another size. Pictures that cannot be opened are left out and named.
// `leave_out`: pictures for which it is true are not opened, and not in the result.
DatasetFolder read_dataset(
    const std::filesystem::path& folder,
    const std::function<bool(const std::filesystem::path& picture)>& leave_out = {});

// Observations as CSV: `image,tag_id,corner,x_px,y_px[,sxx_px2,sxy_px2,syy_px2][,time_s]`. Views
// are in the order in which their images first occur in the file. `times_s` (may be null) becomes
// the times of the images that have one. Throws Error, naming file, line and column: a wrong
// header, a wrong number of fields, a value that is no finite number, a corner that is not on the
// boards, a corner given twice in an image, a covariance that is not positive definite. Also reads,
// by their content, mrcal's corners.vnl and OpenCV's image_points (corners_file.hpp), for one board
// that is a checkerboard or points; remarks on them go to `notes` (may be null).
std::vector<View> read_observations(const std::filesystem::path& file,
                                    const std::vector<PlacedBoard>& boards,
                                    std::vector<std::string>* notes = nullptr,
                                    std::map<std::string, double>* times_s = nullptr);
// `times_s`: of frames of videos and bags, by image name; empty: no such column.
std::string observations_csv(const std::vector<View>& views,
                             const std::map<std::string, double>& times_s = {});

// The smallest model that contains the camera, or kParallelModel.
std::string smallest_model(const Camera& camera);

// truth.yaml: the camera (docs/reference/formats.md) and `poses: [{image, camera_from_world}]`. An
// empty model stands for the smallest one.
Truth read_truth(const std::filesystem::path& file);
void write_truth(const std::filesystem::path& file, const Truth& truth);

struct DepthFolder {
  std::string folder;  // of 16-bit pictures of z in the camera, with the names of the images
  double unit_m = 0.001;
};
// Writes the files of `tagcal render` beside the images: dataset.yaml, target files, truth.yaml.
// `dataset.views` are not written; `images` and `observations` are the keys' values, "" for none.
void write_dataset(const std::filesystem::path& folder, const Dataset& dataset,
                   const std::string& images, const std::string& observations,
                   const std::optional<DepthFolder>& depth = {});

}  // namespace tagcal
