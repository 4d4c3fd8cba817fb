// Lists of corners: our CSV, mrcal's vnl, OpenCV's image_points, each written in all formats. The
// first byte chooses the board.
#include "fuzz/fuzz.hpp"
#include "tagcal/io/corners_file.hpp"
#include "tagcal/io/dataset_file.hpp"

namespace {

using namespace tagcal;

void check_views(const std::vector<View>& views) {
  for (const View& view : views) {
    for (const Observation& seen : view.observations) {
      fuzz::require(seen.pixel.allFinite(), "corners are finite");
      if (seen.covariance_px2)
        fuzz::require(seen.covariance_px2->determinant() >= 0, "covariances are not indefinite");
    }
  }
}

std::size_t num_corners(const std::vector<View>& views) {
  std::size_t count = 0;
  for (const View& view : views) count += view.observations.size();
  return count;
}

// Those of other programs have no tags, and OpenCV's no views that lack corners.
void check_other_formats(const fuzz::Scratch& scratch, const std::vector<View>& views,
                         const std::vector<PlacedBoard>& boards) {
  for (const char* const name : {"copy.vnl", "copy.yaml", "copy.xml", "copy.json"}) {
    const std::filesystem::path copy = scratch.folder() / name;
    const bool is_written = fuzz::is_accepted(
        [&] { write_corners(copy, views, boards, corners_format_of_name(copy)); });
    if (!is_written) continue;
    const bool is_read = fuzz::is_accepted([&] { check_views(read_observations(copy, boards)); });
    fuzz::require(is_read, "corners that were written for another program can be read");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Scratch scratch;
  static const std::vector<PlacedBoard> tags{{make_board(AprilGrid{2, 2, 0.1, 0.3}), Pose()}};
  static const std::vector<PlacedBoard> checkers{
      {make_board(Checkerboard{.columns = 3, .rows = 2, .column_spacing = 0.1, .row_spacing = 0.1}),
       Pose()}};
  if (size == 0) return 0;
  const std::vector<PlacedBoard>& boards = data[0] % 2 == 0 ? tags : checkers;
  const std::filesystem::path file = scratch.write("corners", fuzz::text_of(data, size).substr(1));
  fuzz::is_accepted([&] {
    std::vector<std::string> notes;
    const std::vector<View> views = read_observations(file, boards, &notes);
    check_views(views);

    std::size_t num_again = 0;
    const bool is_read = fuzz::is_accepted([&] {
      const auto copy = scratch.write("copy", observations_csv(views));
      num_again = num_corners(read_observations(copy, boards));
    });
    fuzz::require(is_read, "corners that were read can be written and read again");
    fuzz::require(num_again == num_corners(views), "and are as many");
    if (num_again > 0) check_other_formats(scratch, views, boards);
  });
  return 0;
}
