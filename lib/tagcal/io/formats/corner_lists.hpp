#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tagcal/scene/dataset.hpp"

// Corners as other programs list them, in the order of corner_order.hpp.

namespace tagcal::internal {

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
