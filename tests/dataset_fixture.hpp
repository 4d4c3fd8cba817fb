#pragma once

#include <map>
#include <string>

#include "file_fixture.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"

// A folder with a small data set, for the tests of its files.

namespace tagcal {

inline const std::string kTarget =
    "target_type: aprilgrid\ntagCols: 2\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.25\n";
inline const std::string kDataset =
    "image_size: [64, 48]\ntarget: target.yaml\nobservations: seen.csv\nimages: images\n"
    "truth: truth.yaml\n";
inline const std::string kTruth =
    "camera:\n  image_width: 64\n  image_height: 48\n  model: opencv5\n  fx: 60\n  fy: 61\n"
    "  cx: 31.5\n  cy: 23\n  distortion: [-0.1, 0.01, 0, 0, 0]\nposes:\n"
    "  - {image: a.png, camera_from_world: {translation_m: [0, 0, 1]}}\n"
    "  - {image: b.png, camera_from_world: {rotation: [0, 1, 0, 0]}}\n";
inline const std::string kSeen =
    "image,tag_id,corner,x_px,y_px\n"
    "a.png,0,0,1,2\na.png,0,1,3,4\na.png,0,2,5,6\na.png,0,3,7,8\na.png,1,0,1.5,2\na.png,1,1,2,2\n"
    "b.png,0,0,1,2\nb.png,0,1,3,4\nb.png,0,2,5,6\nb.png,0,3,7,8\nb.png,1,0,1.5,2\nb.png,1,1,2,2\n";

class DatasetFile : public FileTest {
 protected:
  DatasetFile() {
    write("target.yaml", kTarget);
    write("truth.yaml", kTruth);
    write("seen.csv", kSeen);
    write("dataset.yaml", kDataset);
    fs::create_directory(folder_ / "images");
    write("images/b.png", picture());
    write("images/a.png", picture());
    write("images/notes.txt", "no picture");
    const Board points = make_board(Points{{{{50, 0}, {1, 2, 3}}}});
    boards_ = {{make_board(AprilGrid{2, 2, 0.1, 0.25, 0}), {}}, {points, {}}};
  }

  // The bytes of a PNG of 64 x 48 pixels, made once.
  std::string picture() const {
    static const std::string bytes = [this] {
      write_png(folder_ / "p.png", Image8(ImageSize{64, 48}));
      return read_text(folder_ / "p.png");
    }();
    return bytes;
  }

  std::string error() const {
    return error_about(folder_.string() + "/", [&] { read_dataset(folder_); });
  }
  std::vector<View> read_csv(const std::string& text) const {
    return read_observations(write("t.csv", text), boards_);
  }
  std::string csv_error(const std::string& text) const {
    return error_about(folder_.string() + "/", [&] { read_csv(text); });
  }
  // Each change of a file of the good data set.
  void expect_bad(const std::string& file, const std::string& good,
                  const std::vector<BadFile>& table) const {
    for (const BadFile& bad : table) {
      write(file, replaced(good, bad.from, bad.to));
      expect_line(error(), bad.message);
    }
    write(file, good);
    EXPECT_NO_THROW(read_dataset(folder_));
  }

  std::vector<PlacedBoard> boards_;
};

}  // namespace tagcal
