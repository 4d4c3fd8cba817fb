#pragma once

#include "file_fixture.hpp"
#include "tagcal/io/target_file.hpp"

// Target files of all kinds as texts, and reading them.

namespace tagcal {

inline const std::string kGrid =
    "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\ntagSpacing: 0.3\n";
inline const std::string kTags =
    "target_type: tags\nfamily: tag25h9\ntags:\n"
    "  - {id: 3, size: 0.1, pose: {translation_m: [1, 2, 3]}}\n"
    "  - {id: 8, size: 0.2, pose: {rotation: [0, 0, 0, 1]}}\n";
inline const std::string kPoints =
    "target_type: points\npoints:\n  - {id: 4, x: 1.5, y: -2e-3, z: .25}\n  - [7, 1, 2, 3]\n";
inline const std::string kChecker =
    "target_type: 'checkerboard'\ntargetCols: 7\ntargetRows: 6\nrowSpacingMeters: 0.06\n"
    "colSpacingMeters: 0.05\n";
inline const std::string kCircles =
    "target_type: 'circlegrid'\ntargetCols: 4\ntargetRows: 11\nspacingMeters: 0.02\n"
    "asymmetricGrid: True\n";
inline const std::string kCharuco =
    "target_type: charuco\nsquareCols: 5\nsquareRows: 4\nsquareSize: 0.04\nmarkerSize: 0.03\n"
    "dictionary: DICT_5X5_100\n";

class TargetFile : public FileTest {
 protected:
  Board read(const std::string& text, std::optional<int> first_id = {}) {
    return read_target(write("target.yaml", text), first_id, &warnings_);
  }

  template <typename Kind>
  Kind read_kind(const std::string& text, std::optional<int> first_id = {}) {
    return std::get<Kind>(read(text, first_id).pattern);
  }
  std::string error(const std::string& text) {
    return error_about((folder_ / "target.yaml").string(), [&] { read(text); });
  }
  void expect_bad(const std::string& good, const std::vector<BadFile>& table) {
    for (const BadFile& bad : table)
      expect_line(error(replaced(good, bad.from, bad.to)), bad.message);
  }

  std::vector<std::string> warnings_;
};

}  // namespace tagcal
