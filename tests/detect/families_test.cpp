#include "tagcal/detect/families.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/common/image_types.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <set>
#include <tuple>

#include "expect.hpp"
#include "markers_of_opencv.hpp"
#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/detector.hpp"

namespace tagcal {
using namespace internal;
namespace {

// A tag drawn from the plain data, one pixel a cell, as the comments of TagFamily describe it.
std::vector<std::uint8_t> drawn(const TagFamily& family, std::size_t id) {
  const int width = family.total_width;
  const int start = (width - family.width_at_border) / 2;
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(width * width), 0);
  const int ring_width = family.width_at_border + (family.reversed_border ? 0 : 2);
  const int first = (width - ring_width) / 2;
  const int last = first + ring_width - 1;
  for (int y = first; y <= last; ++y) {
    for (int x = first; x <= last; ++x) {
      if (x == first || x == last || y == first || y == last) {
        cells[static_cast<std::size_t>(y * width + x)] = 255;
      }
    }
  }
  for (std::size_t i = 0; i < family.bits.size(); ++i) {
    if ((family.codes[id] >> (family.bits.size() - 1 - i) & 1U) == 0) continue;
    const int x = family.bits[i].x + start;
    const int y = family.bits[i].y + start;
    cells[static_cast<std::size_t>(y * width + x)] = 255;
  }
  return cells;
}

TEST(Families, AreTheLibrarysOwnPictures) {
  for (const std::string& name : tag_family_names()) {
    const TagFamily family = tag_family(name, 1);
    const FamilyHandle handle = create_family(name, 1);
    for (const std::size_t id : {std::size_t{0}, std::size_t{7}, family.codes.size() - 1}) {
      image_u8_t* image = apriltag_to_image(handle.get(), static_cast<int>(id));
      const std::vector<std::uint8_t> cells = drawn(family, id);
      ASSERT_EQ(image->width, family.total_width) << name;
      for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
          EXPECT_EQ(cells[static_cast<std::size_t>(y * family.total_width + x)],
                    image->buf[y * image->stride + x])
              << name << " id " << id << " at " << x << "," << y;
        }
      }
      std::free(image->buf);
      std::free(image);
    }
  }
}

// OpenCV's own drawings are the witness.
TEST(Families, DictionariesAreOpenCvsPictures) {
  ASSERT_EQ(tag_dictionary_names().size(), 21u);
  for (int i = 0; i < 21; ++i) {
    const std::string name = tag_dictionary_names()[static_cast<std::size_t>(i)];
    const cv::aruco::Dictionary dictionary(cv::aruco::getPredefinedDictionary(i));
    const TagFamily family = tag_family(name, 1);
    const int width = dictionary.markerSize + 2;
    ASSERT_EQ(family.width_at_border, width) << name;
    ASSERT_EQ(family.codes.size(), static_cast<std::size_t>(dictionary.bytesList.rows)) << name;
    for (const std::size_t id : {std::size_t{0}, std::size_t{7}, family.codes.size() - 1}) {
      const cv::Mat theirs = marker_of_opencv(i, static_cast<int>(id), width);
      const std::vector<std::uint8_t> ours = drawn(family, id);
      for (int y = 0; y < width; ++y)
        for (int x = 0; x < width; ++x)
          EXPECT_EQ(ours[static_cast<std::size_t>((y + 1) * family.total_width + x + 1)],
                    theirs.at<unsigned char>(y, x))
              << name << " id " << id << " at " << x << "," << y;
    }
  }
}

// AprilTag turns codes by quarters of their bits; it must read a turned marker.
TEST(Families, DictionariesAreReadByAprilTag) {
  for (const std::string name : {"DICT_4X4_50", "DICT_5X5_100", "DICT_7X7_250"}) {
    const TagFamily family = tag_family(name, 1);
    constexpr int kCell = 8;
    const int cells = family.total_width, side = cells * kCell;
    const std::vector<std::uint8_t> tag = drawn(family, 11);
    for (int turn = 0; turn < 4; ++turn) {
      Image8 image({side + 40, side + 40}, 255);
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          int u = x / kCell, v = y / kCell;
          for (int k = 0; k < turn; ++k) std::tie(u, v) = std::pair(v, cells - 1 - u);
          image(20 + x, 20 + y) = tag[static_cast<std::size_t>(v * cells + u)];
        }
      }
      const PlacedBoard placed{make_board(Tags{name, 1, {{11, 1.0, Pose()}}}), Pose()};
      DetectOptions options;
      options.refinement = Refinement::stock;
      const View view = detect(image, {placed}, options).view;
      ASSERT_EQ(view.observations.size(), 4u) << name << " " << turn;
      const double near = 20 + kCell - 0.5, far = near + (cells - 2) * kCell;
      const std::array<Eigen::Vector2d, 4> corners = {
          Eigen::Vector2d(near, far), {far, far}, {far, near}, {near, near}};
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_LT(
            (view.observations[k].pixel - corners[(k + 3 * static_cast<std::size_t>(turn)) % 4])
                .norm(),
            0.5)
            << name << " " << turn << " " << view.observations[k].pixel.transpose();
    }
  }
}

using Cells = std::vector<std::uint8_t>;

// The least number of cells in which a tag of the family differs from another one or from itself
// turned.
int least_difference(const TagFamily& family) {
  const int n = family.total_width;
  std::vector<Cells> tags;
  for (std::size_t id = 0; id < family.codes.size(); ++id) tags.push_back(drawn(family, id));
  int least = n * n;
  for (std::size_t a = 0; a < tags.size(); ++a) {
    Cells turned = tags[a];
    for (int turn = 0; turn < 4; ++turn) {
      for (std::size_t b = a; b < tags.size(); ++b)
        if (b != a || turn > 0)
          least = std::min(least, static_cast<int>(std::inner_product(
                                      turned.begin(), turned.end(), tags[b].begin(), 0,
                                      std::plus<>(), std::not_equal_to<>())));
      const Cells before = turned;
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          turned[static_cast<std::size_t>(y * n + x)] =
              before[static_cast<std::size_t>(x * n + n - 1 - y)];
    }
  }
  return least;
}

// Tag 11 of the family, some of its bits wrong, as a picture.
Image8 with_wrong_bits(const TagFamily& family, int num_wrong) {
  constexpr int kCell = 8;
  const int n = family.total_width, side = n * kCell;
  Cells tag = drawn(family, 11);
  for (int k = 0; k < num_wrong; ++k) {
    std::uint8_t& level = tag[static_cast<std::size_t>((2 + k) * n + 2 + k)];
    level = static_cast<std::uint8_t>(255 - level);
  }
  Image8 image({side + 40, side + 40}, 255);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      image(20 + x, 20 + y) = tag[static_cast<std::size_t>(y / kCell * n + x / kCell)];
  return image;
}

// A code with more wrong bits may be as near to another tag.
TEST(Families, WrongBitsAreReadBelowHalfOfTheDistanceOfCodes) {
  for (const std::string name : {"DICT_4X4_50", "DICT_5X5_50", "DICT_7X7_50"}) {
    const TagFamily family = tag_family(name, 1);
    const int allowed = std::min(2, (least_difference(family) - 1) / 2);
    std::printf("%s differ in %d bits\n", name.c_str(), least_difference(family));
    DetectOptions options;
    options.refinement = Refinement::stock;
    options.max_hamming = 2;
    for (int wrong = 0; wrong < 4; ++wrong) {
      const auto tags = detect_tags(with_wrong_bits(family, wrong), {.family = name}, options);
      EXPECT_EQ(tags.size(), wrong <= allowed ? 1u : 0u) << name << " " << wrong;
    }
  }
}

TEST(Families, KnownFacts) {
  const TagFamily family = tag_family("tag36h11", 1);
  EXPECT_EQ(family.codes.size(), 587u);
  EXPECT_EQ(family.codes.front(), 0x0000000d7e00984bULL);
  EXPECT_EQ(family.bits.size(), 36u);
  EXPECT_EQ(family.width_at_border, 8);
  EXPECT_EQ(family.total_width, 10);
  EXPECT_FALSE(family.reversed_border);
  EXPECT_TRUE(tag_family("tagStandard41h12", 1).reversed_border);
  EXPECT_EQ(tag_family("tag25h9", 1).codes.size(), 35u);
}

TEST(Families, WideBorderLiesAroundTheSameBits) {
  for (const std::string& name : tag_family_names()) {
    const TagFamily plain = tag_family(name, 1);
    if (plain.reversed_border) {
      EXPECT_THROW(tag_family(name, 2), Error);
      continue;
    }
    const TagFamily wide = tag_family(name, 2);
    EXPECT_EQ(wide.width_at_border, plain.width_at_border + 2);
    EXPECT_EQ(wide.total_width, plain.total_width + 2);
    EXPECT_EQ(wide.codes, plain.codes);
    for (std::size_t i = 0; i < plain.bits.size(); ++i) {
      EXPECT_EQ(wide.bits[i].x, plain.bits[i].x + 1);
      EXPECT_EQ(wide.bits[i].y, plain.bits[i].y + 1);
      EXPECT_GE(wide.bits[i].x, 2);
      EXPECT_LT(wide.bits[i].x, wide.width_at_border - 2);
    }
  }
}

TEST(Families, CodesOfTheSameTagStandApart) {
  const TagFamily family = tag_family("tag36h11", 1);
  for (std::size_t i = 1; i < family.codes.size(); ++i) {
    EXPECT_GE(std::popcount(family.codes[i] ^ family.codes[0]), 11);
  }
}

TEST(Families, OfBoardsAreThoseOfTheirTags) {
  const PlacedBoard squares{make_board(Checkerboard{3, 3, 0.1, 0.1}), Pose()};
  const PlacedBoard plain{make_board(AprilGrid{2, 1, 0.1, 0.3, 0, "tag25h9", 1, false}), Pose()};
  const PlacedBoard kalibr{make_board(AprilGrid{2, 1, 0.1, 0.3}), Pose()};
  const TagFamilies families = tag_families({squares, plain, kalibr});
  ASSERT_EQ(families.size(), 2u);
  EXPECT_EQ(families.at("tag25h9").codes, tag_family("tag25h9", 1).codes);
  EXPECT_EQ(families.at("tag36h11").name, "tag36h11");
  EXPECT_THROW(tag_families({{make_board(AprilGrid{2, 1, 0.1, 0.3, 0, "tag9"}), Pose()}}), Error);
}

TEST(Families, UnknownNamesAndBordersAreErrors) {
  EXPECT_THROW(tag_family("", 1), Error);
  EXPECT_THROW(tag_family("tag36h11", 0), Error);
  EXPECT_THROW(tag_family("tag36h11", 3), Error);
  EXPECT_ERROR(tag_family("tag36h12", 1),
               "family: must be one of tag36h11, tag36h10, tag25h9, tag16h5, tagStandard41h12, "
               "tagStandard52h13, tagCircle21h7, tagCircle49h12, tagCustom48h12, "
               "or a dictionary of OpenCV (DICT_4X4_50, ..), got tag36h12");
}

// The key of a ChArUco board's file is `dictionary`.
TEST(Families, OfCharucoBoardsAreDictionaries) {
  const auto error = [](int rows, const std::string& dictionary) {
    const Charuco board{7, rows, 0.02, 0.015, dictionary};
    return error_of([&] { check_tags(make_board(board)); });
  };
  EXPECT_EQ(error(14, "DICT_4X4_50"), "no error");  // 49 markers
  EXPECT_EQ(
      error(90, "DICT_4X4_50"),
      "dictionary: DICT_4X4_50 has 50 markers, but those of the board are numbered up to 314; "
      "choose a larger dictionary, or fewer squares");
  const std::string unknown = error(6, "4x4_50");
  EXPECT_TRUE(unknown.starts_with("dictionary: must be one of DICT_4X4_50, ")) << unknown;
  EXPECT_TRUE(unknown.ends_with(", got 4x4_50")) << unknown;
}

}  // namespace
}  // namespace tagcal
