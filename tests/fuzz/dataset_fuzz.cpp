// dataset.yaml, in a folder with the files that it may name: a target, corners, a truth and a
// picture.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"

namespace {

using namespace tagcal;

class Folder : public fuzz::Scratch {
 public:
  Folder() {
    write("board.yaml",
          "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.3\n");
    write("corners.csv", "image,tag_id,corner,x_px,y_px\na.png,0,0,10,12\na.png,0,1,30,12.5\n");
    write("truth.yaml",
          "model: pinhole\nimage_width: 64\nimage_height: 48\ncamera_matrix: {rows: 3, cols: 3, "
          "data: [50, 0, 31, 0, 50, 23, 0, 0, 1]}\nposes:\n  - {image: a.png, "
          "camera_from_world: {q_wxyz: [1, 0, 0, 0], t_m: [0, 0, 1]}}\n");
    std::filesystem::create_directories(folder() / "images");
    write_png(folder() / "images" / "a.png", Image8({64, 48}, 128));
  }
};

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder scratch;
  scratch.write("dataset.yaml", fuzz::text_of(data, size));
  fuzz::is_accepted([&] {
    const DatasetFolder read = read_dataset(scratch.folder());
    fuzz::require(!read.dataset.boards.empty(), "a data set has a board");
    fuzz::require(read.dataset.image_size.width > 0, "a data set has an image size");
    for (const PlacedBoard& placed : read.dataset.boards)
      fuzz::require(placed.world_from_board.matrix().allFinite(), "poses are finite");
  });
  return 0;
}
