#include "tagcal/detect/opencv/marker_dictionary.hpp"

#include <algorithm>
#include <array>
#if __has_include(<opencv2/objdetect/aruco_dictionary.hpp>)
#include <opencv2/objdetect/aruco_dictionary.hpp>
#else  // before OpenCV 4.7
#include <opencv2/aruco/dictionary.hpp>
#endif

namespace tagcal::internal {
namespace {

struct Predefined {
  std::string_view name;
  int id;
  int min_distance;  // numeric: as OpenCV's header states it
};

using namespace cv::aruco;

// OpenCV's header gives two distances for the markers of ArUco's original library, 0 and 3; 1
// allows no correction.
constexpr std::array kPredefined = {
    Predefined{"DICT_4X4_50", DICT_4X4_50, 4},
    Predefined{"DICT_4X4_100", DICT_4X4_100, 3},
    Predefined{"DICT_4X4_250", DICT_4X4_250, 3},
    Predefined{"DICT_4X4_1000", DICT_4X4_1000, 2},
    Predefined{"DICT_5X5_50", DICT_5X5_50, 8},
    Predefined{"DICT_5X5_100", DICT_5X5_100, 7},
    Predefined{"DICT_5X5_250", DICT_5X5_250, 6},
    Predefined{"DICT_5X5_1000", DICT_5X5_1000, 5},
    Predefined{"DICT_6X6_50", DICT_6X6_50, 13},
    Predefined{"DICT_6X6_100", DICT_6X6_100, 12},
    Predefined{"DICT_6X6_250", DICT_6X6_250, 11},
    Predefined{"DICT_6X6_1000", DICT_6X6_1000, 9},
    Predefined{"DICT_7X7_50", DICT_7X7_50, 19},
    Predefined{"DICT_7X7_100", DICT_7X7_100, 18},
    Predefined{"DICT_7X7_250", DICT_7X7_250, 17},
    Predefined{"DICT_7X7_1000", DICT_7X7_1000, 14},
    Predefined{"DICT_ARUCO_ORIGINAL", DICT_ARUCO_ORIGINAL, 1},
    Predefined{"DICT_APRILTAG_16h5", DICT_APRILTAG_16h5, 5},
    Predefined{"DICT_APRILTAG_25h9", DICT_APRILTAG_25h9, 9},
    Predefined{"DICT_APRILTAG_36h10", DICT_APRILTAG_36h10, 10},
    Predefined{"DICT_APRILTAG_36h11", DICT_APRILTAG_36h11, 11},
};

}  // namespace

std::vector<std::string> marker_dictionary_names() {
  std::vector<std::string> names;
  for (const Predefined& predefined : kPredefined) names.emplace_back(predefined.name);
  return names;
}

std::optional<MarkerDictionary> marker_dictionary(std::string_view name) {
  const auto* const found = std::ranges::find(kPredefined, name, &Predefined::name);
  if (found == kPredefined.end()) return std::nullopt;
  const Dictionary theirs(getPredefinedDictionary(found->id));
  MarkerDictionary dictionary{theirs.markerSize, found->min_distance, {}};
  for (int id = 0; id < theirs.bytesList.rows; ++id) {
    const cv::Mat bits = Dictionary::getBitsFromByteList(theirs.bytesList.row(id), dictionary.side);
    std::uint64_t code = 0;
    for (int y = 0; y < dictionary.side; ++y)
      for (int x = 0; x < dictionary.side; ++x)
        code = code << 1 | (bits.at<unsigned char>(y, x) != 0 ? 1U : 0U);
    dictionary.codes.push_back(code);
  }
  return dictionary;
}

}  // namespace tagcal::internal
