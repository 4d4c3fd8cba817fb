#include "tagcal/scene/rig_pairing.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "file_fixture.hpp"

namespace tagcal {
namespace {

using Views = std::vector<std::optional<std::size_t>>;  // of an instant, by camera

RigCamera camera(const std::string& name, const std::vector<std::string>& images,
                 std::vector<double> times_s = {}) {
  RigCamera result{name, {}, std::move(times_s)};
  for (const std::string& image : images) result.data.views.push_back({image, {}});
  return result;
}

RigCamera timed(const std::string& name, std::vector<double> times_s) {
  std::vector<std::string> images;
  for (std::size_t i = 0; i < times_s.size(); ++i) images.push_back(std::to_string(i) + ".png");
  return camera(name, images, std::move(times_s));
}

std::vector<Views> by_name(const std::vector<RigCamera>& cameras) {
  std::vector<Views> result;
  for (Instant& instant : pair_by_name(cameras)) result.push_back(std::move(instant.view));
  return result;
}

std::vector<Views> by_time(const std::vector<RigCamera>& cameras, double tolerance_s) {
  std::vector<Views> result;
  for (Instant& instant : pair_by_time(cameras, tolerance_s))
    result.push_back(std::move(instant.view));
  return result;
}

constexpr std::nullopt_t kNone = std::nullopt;

TEST(RigPairing, EqualNamesInAnyFolderAndFormat) {
  EXPECT_EQ(by_name({camera("a", {"a/002.png", "a/000.png"}),
                     camera("b", {"000.jpg", "001.png", "002.png"})}),
            (std::vector<Views>{{1, 0}, {kNone, 1}, {0, 2}}));
  EXPECT_EQ(by_name({camera("a", {"x.png", "w.png"})}), (std::vector<Views>{{1}, {0}}));
}

TEST(RigPairing, NumbersInNamesCountByTheirValue) {
  EXPECT_EQ(by_name({camera("a", {"f10.png", "f9.png", "f100.png"}),
                     camera("b", {"f9.png", "f10.png", "f100.png"})}),
            (std::vector<Views>{{1, 0}, {0, 1}, {2, 2}}));
}

TEST(RigPairing, TheCamerasOwnNumberOrWordIsLeftOut) {
  EXPECT_EQ(by_name({camera("a", {"frame003-camera0.png", "frame004-camera0.png"}),
                     camera("b", {"frame004-camera1.png", "frame003-camera1.png"})}),
            (std::vector<Views>{{0, 1}, {1, 0}}));
  EXPECT_EQ(by_name({camera("a", {"left01.jpg", "left02.jpg"}), camera("b", {"right02.jpg"})}),
            (std::vector<Views>{{0, kNone}, {1, 0}}));
  // One picture each: the camera's name says which of the numbers is its own.
  EXPECT_EQ(by_name({camera("left", {"left01.jpg"}), camera("right", {"right01.jpg"})}),
            (std::vector<Views>{{0, 0}}));
  EXPECT_EQ(by_name({camera("camera0", {"0_7.png"}), camera("camera1", {"1_7.png"})}),
            (std::vector<Views>{{0, 0}}));
}

TEST(RigPairing, NamesThatDoNotPair) {
  const auto error = [](const std::vector<RigCamera>& cameras) {
    return error_of([&] { pair_by_name(cameras); });
  };
  EXPECT_EQ(error({}), "rig: has no cameras");
  EXPECT_EQ(error({camera("a", {"x1.png", "x2.png"}), camera("b", {"y7z.png", "y8z.png"})}),
            "rig: no two cameras have a name in common in the names of pictures, such as x1.png of "
            "camera a and y7z.png of camera b; pair them by index, time or a file");
  // Two pictures, of different instants perhaps.
  EXPECT_HAS(error({camera("a", {"1.png"}), camera("b", {"2.png"})}), "not clear which part");
  EXPECT_HAS(error({camera("a", {"u0k1.png", "u0k1.png"}), camera("b", {"u1k2.png"})}),
             "not clear which part");
  EXPECT_EQ(error({camera("a", {"1.png", "1.jpg"}), camera("b", {"1.png"})}),
            "camera a: the pictures 1.png and 1.jpg have one name, which pairs them with one "
            "instant: rename one");
  EXPECT_HAS(error({camera("a", {}), camera("b", {"2.png"})}), "no two cameras");
}

TEST(RigPairing, ByIndex) {
  const auto instants = pair_by_index({camera("a", {"x", "y"}), camera("b", {"k", "j"})});
  ASSERT_EQ(instants.size(), 2U);
  EXPECT_EQ(instants[1].view, (Views{1, 1}));
  EXPECT_ERROR(pair_by_index({camera("a", {"x", "y"}), camera("b", {"k"})}),
               "camera b: has 1 pictures, but camera a has 2: pairing by index needs equally many");
}

TEST(RigPairing, ByTimeTheNearestOneToOne) {
  EXPECT_EQ(by_time({timed("a", {0, 0.1, 0.2}), timed("b", {0.004, 0.097, 0.15, 0.3})}, 0.005),
            (std::vector<Views>{{0, 0}, {1, 1}, {kNone, 2}, {2, kNone}, {kNone, 3}}));
  // Two views near one: the nearer one is taken, the other one is alone.
  EXPECT_EQ(by_time({timed("a", {1}), timed("b", {0.9, 1.02})}, 0.2),
            (std::vector<Views>{{kNone, 0}, {0, 1}}));
  // The third camera meets an instant that the first one has missed.
  EXPECT_EQ(by_time({timed("a", {0}), timed("b", {0, 1}), timed("c", {1.001})}, 0.01),
            (std::vector<Views>{{0, 0, kNone}, {kNone, 1, 0}}));
}

TEST(RigPairing, TimesThatDoNotPair) {
  const auto error = [](const RigCamera& second, double tolerance_s) {
    return error_of([&] { pair_by_time({timed("a", {0, 1}), second}, tolerance_s); });
  };
  EXPECT_EQ(error(timed("b", {0, 2, 2}), 0.1),
            "camera b: time of 2.png: must be after that of the picture before it, 2 s, got 2 s");
  EXPECT_EQ(error(timed("b", {0, std::numeric_limits<double>::quiet_NaN()}), 0.1),
            "camera b: time of 1.png: must be finite");
  EXPECT_EQ(error(camera("b", {"x", "y"}, {1}), 0.1),
            "camera b: has no times of its pictures, which pairing by time needs");
  EXPECT_EQ(error(timed("b", {0, 1}), -1), "rig: the tolerance of times must be >= 0, got -1 s");
}

}  // namespace
}  // namespace tagcal
