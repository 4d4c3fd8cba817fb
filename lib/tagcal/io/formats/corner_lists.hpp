#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/dataset.hpp"

namespace tagcal::internal {

// The corners of a board in the order of other programs' lists: those of a checkerboard row by row
// from the upper left (ids go row by row from the lower left), those of a `points` target by id.
// Throws Error, beginning with `where`, unless there is one board, of these two kinds.
std::vector<CornerId> listed_corners(const std::vector<PlacedBoard>& boards,
                                     const std::string& where);

// Name of a view in a list that has none: view0000, ..
std::string view_name(std::size_t index);

// mrcal's corners.vnl: a legend `# filename x y level`, then as many lines per picture as the board
// has corners; `-` for a corner that was not found, or one line of them for the picture.
bool is_vnl(std::string_view text);
std::vector<View> read_vnl(const std::string& text, const std::string& file,
                           const std::vector<PlacedBoard>& boards, std::vector<std::string>* notes);
std::string vnl_text(const std::vector<View>& views, const std::vector<PlacedBoard>& boards);

// OpenCV's calibration sample: the matrix image_points of cv::FileStorage (YAML, XML or JSON), a
// row per picture and a point (x, y) per corner. `image_names`, a list of texts, is tagcal's own.
bool is_image_points(std::string_view text);
std::vector<View> read_image_points(const std::string& text, const std::string& file,
                                    const std::vector<PlacedBoard>& boards,
                                    std::vector<std::string>* notes);
// Views with all corners only; adds a note on the others.
std::string image_points_text(const std::vector<View>& views,
                              const std::vector<PlacedBoard>& boards, std::string_view extension,
                              std::vector<std::string>& notes);

}  // namespace tagcal::internal
