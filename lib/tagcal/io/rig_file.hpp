#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tagcal/scene/rig.hpp"

// The data set of a rig on disk: a folder whose dataset.yaml has the key `rig`
// (docs/reference/formats.md).

namespace tagcal {

// What belongs to a camera beside its RigCamera.
struct RigCameraFiles {
  std::filesystem::path observations;         // the file with the views; empty: none
  std::vector<std::filesystem::path> images;  // sorted by name
  std::vector<std::string> unreadable;        // pictures that are not in `images`: file and reason
  std::filesystem::path times;                // the file with the stamps; empty: none
  std::map<std::string, double> times_s;      // by the name of the picture, without folder
};

struct RigFolder {
  RigDataset rig;                            // a camera with images alone has no views
  std::vector<RigCameraFiles> files;         // by camera
  std::vector<std::filesystem::path> texts;  // all other files that were read
  std::vector<std::string> warnings;
};

// Reads and checks dataset.yaml, targets, observations, stamps and truth. The instants are paired
// by name; there are none if a camera has images alone, whose views the caller has to detect.
// Throws Error: see read_dataset, and no camera or more than 64, a name or a folder of pictures
// that two cameras share, a camera without observations and images, or without image_size and
// images, and rows of times.csv that are no picture and stamp. `leave_out`: pictures for which it
// is true are not opened, and not in the result.
RigFolder read_rig_folder(
    const std::filesystem::path& folder,
    const std::function<bool(const std::filesystem::path& picture)>& leave_out = {});

// The same without the files, for a data set with observations.
RigDataset read_rig_dataset(const std::filesystem::path& folder);

// True if the folder has a dataset.yaml with the key `rig`. False for a file that cannot be read.
bool is_rig_folder(const std::filesystem::path& folder);

// The times of pictures, by their names without folder, from a table with the columns image,time_s.
// Throws Error for another header, a time that is not finite, and a picture with two times.
std::map<std::string, double> read_picture_times(const std::filesystem::path& file);

// The stamps of views, by the names of their pictures. Throws Error for a view without a stamp.
std::vector<double> times_of(const std::vector<View>& views, const RigCameraFiles& files);

// The instants of a table of pictures: the header has the names of all cameras, in any order, and a
// row the pictures of an instant, with or without folders; no name for a camera without a picture.
// Views that are not in the table are in no instant.
// A name that no view has counts as none, because nothing may have been seen in that picture, and
// goes to `notes` (may be null). Throws Error: a camera that is missing, unknown or named twice, a
// picture in two rows, a camera none of whose names is a view.
std::vector<Instant> pair_by_file(const std::filesystem::path& file,
                                  const std::vector<RigCamera>& cameras,
                                  std::vector<std::string>* notes = nullptr);

// truth.yaml of a rig: `cameras: [{name, camera_from_rig, time_offset_s}]`. Throws Error unless the
// names are those of the cameras.
RigTruth read_rig_truth(const std::filesystem::path& file, const std::vector<RigCamera>& cameras);

// The names of the cameras in the truth of a rig; empty if the file is no truth of a rig.
std::vector<std::string> cameras_of_rig_truth(const std::filesystem::path& file);

// Names of the files in the folder FOLDER/NAME of each camera, "" for none.
struct RigFileNames {
  std::string images = "images";  // a folder
  std::string observations = "observations_exact.csv";
  std::string truth = "truth.yaml";
};

// Writes dataset.yaml, the target files and truth.yaml of a rig, and NAME/times.csv of each camera
// whose stamps are known. Those of RigFileNames are the caller's to write.
void write_rig_dataset(const std::filesystem::path& folder, const RigDataset& rig,
                       const RigFileNames& names = {});

}  // namespace tagcal
