// dataset.yaml, in a folder with the files that it may name: a target, corners, a truth and a
// picture. What follows a line `--8<--` is the truth. What was read is written and read again. With
// the key `rig` it is the data set of a rig.
#include <algorithm>

#include "fuzz/fuzz.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/io/rig_file.hpp"

namespace {

using namespace tagcal;

constexpr std::string_view kTruth =
    "model: pinhole\nimage_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, "
    "data: [50, 0, 31, 0, 50, 23, 0, 0, 1]}\nposes:\n  - {image: a.png, "
    "camera_from_world: {q_wxyz: [1, 0, 0, 0], t_m: [0, 0, 1]}}\n";

class Folder : public fuzz::Scratch {
 public:
  Folder() {
    write("board.yaml",
          "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.3\n");
    write("corners.csv", "image,tag_id,corner,x_px,y_px\na.png,0,0,10,12\na.png,0,1,30,12.5\n");
    write("times.csv", "image,time_s\na.png,0.5\n");
    std::filesystem::create_directories(folder() / "images");
    write_png(folder() / "images" / "a.png", Image8({64, 48}, 128));
  }
};

void check_rig(const RigFolder& read) {
  const auto& cameras = read.rig.cameras;
  fuzz::require(!cameras.empty() && read.files.size() == cameras.size(), "a rig has cameras");
  for (const Instant& instant : read.rig.instants) {
    fuzz::require(instant.view.size() == cameras.size(), "an instant has a place for each camera");
    for (std::size_t c = 0; c < cameras.size(); ++c)
      fuzz::require(!instant.view[c] || *instant.view[c] < cameras[c].data.views.size(),
                    "an instant has views of the cameras");
  }
  if (!read.rig.truth) return;
  for (const Pose& pose : read.rig.truth->camera_from_rig)
    fuzz::require(pose.matrix().allFinite(), "poses are finite");
}

// A data set that was read can be written and read again, and is the same.
void check_copy(const fuzz::Scratch& scratch, const Dataset& dataset) {
  const std::filesystem::path folder = scratch.folder() / "copy";
  std::filesystem::remove_all(folder);
  bool is_same = false;
  const bool is_read = fuzz::is_accepted([&] {
    write_dataset(folder, dataset, "", "corners.csv");
    scratch.write("copy/corners.csv", observations_csv(dataset.views));
    const Dataset again = read_dataset(folder).dataset;
    is_same = again.views.size() == dataset.views.size() &&
              again.boards.size() == dataset.boards.size() &&
              again.truth.has_value() == dataset.truth.has_value();
    if (!is_same || !dataset.truth) return;
    is_same = std::ranges::equal(parameters(again.truth->camera.lens),
                                 parameters(dataset.truth->camera.lens)) &&
              again.truth->camera_from_world.size() == dataset.truth->camera_from_world.size();
  });
  fuzz::require(is_read, "a data set that was read can be written and read again");
  fuzz::require(is_same, "and is the same");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder scratch;
  const auto [text, truth] = fuzz::two_files(fuzz::text_of(data, size));
  scratch.write("dataset.yaml", text);
  scratch.write("truth.yaml", truth.empty() ? kTruth : truth);
  if (is_rig_folder(scratch.folder())) {
    fuzz::is_accepted([&] { check_rig(read_rig_folder(scratch.folder())); });
    return 0;
  }
  fuzz::is_accepted([&] {
    const DatasetFolder read = read_dataset(scratch.folder());
    fuzz::require(!read.dataset.boards.empty(), "a data set has a board");
    fuzz::require(read.dataset.image_size.width > 0, "a data set has an image size");
    for (const PlacedBoard& placed : read.dataset.boards)
      fuzz::require(placed.world_from_board.matrix().allFinite(), "poses are finite");
    check_copy(scratch, read.dataset);
  });
  return 0;
}
