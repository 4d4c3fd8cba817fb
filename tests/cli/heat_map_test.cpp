// Drawings of values over an image.
#include "draw/heat_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "calibrations.hpp"
#include "worlds.hpp"

namespace tagcal::tools {
namespace {

using study::Drawing, study::Path;

template <typename Test>
std::ptrdiff_t num_paths(const Drawing& drawing, const Test& test) {
  return std::ranges::count_if(drawing.items, [&](const auto& item) {
    const auto* path = std::get_if<Path>(&item);
    return path && test(*path);
  });
}

std::ptrdiff_t num_hulls(const Drawing& drawing) {
  return num_paths(drawing, [](const Path& path) {
    return path.dash > 0 && path.points.front() == path.points.back();
  });
}

std::ptrdiff_t num_red(const Drawing& drawing) {
  return num_paths(drawing, [](const Path& path) { return path.colour == "#c9412e"; });
}

TEST(HeatMap, OfAnUncertaintyHasAPanelForEachDistance) {
  CalibrateOptions options = with_model("opencv5");
  const Dataset world = make_world(opencv5_lens(), 1);
  const Drawing two = uncertainty_drawing(calibrate(world, options));
  options.distances_m = {3};
  const Drawing three = uncertainty_drawing(calibrate(world, options));
  EXPECT_EQ(2 * three.height, 3 * two.height);
  EXPECT_EQ(num_hulls(two), 2);
  EXPECT_EQ(num_hulls(three), 3);
  EXPECT_TRUE(two.has_text("sd of the projection at infinity, pixels per coordinate"));
  EXPECT_FALSE(two.has_text("at 3 m"));
  EXPECT_TRUE(three.has_text("at 3 m"));
  EXPECT_TRUE(two.has_text("0.001 px"));  // of the scale
}

TEST(HeatMap, OfAFitIsRedWhereTheLensesDiffer) {
  const Camera camera{Perspective({900, 900, 639.5, 399.5, -0.2, 0.05}), {1280, 800}};
  const std::vector<Eigen::Vector2d> pixels = {{600, 350}, {700, 350}, {650, 450}};
  const SeenRegion seen(camera.image_size, pixels);
  LensFitOptions any;
  any.max_difference_px = 1000;
  const LensFit small = fit_lens({camera, {}, {}, seen}, Model::named("pinhole"), any);
  const Drawing of_small = lens_fit_drawing(small, seen);
  EXPECT_TRUE(of_small.has_text("difference of model pinhole from the lens, pixels; dashed"));
  EXPECT_EQ(num_hulls(of_small), 1);
  EXPECT_GT(num_red(of_small), 20);
  const LensFit same = fit_lens({camera, {}, {}, {}}, Model::named("opencv5"), any);
  const Drawing of_same = lens_fit_drawing(same, {});
  EXPECT_TRUE(of_same.has_text("difference of model opencv5 from the lens, pixels"));
  EXPECT_FALSE(of_same.has_text("dashed"));
  EXPECT_TRUE(of_same.has_text("0.01 px"));  // of the scale
  EXPECT_EQ(num_hulls(of_same), 0);
  EXPECT_LT(num_red(of_same), 5);
}

}  // namespace
}  // namespace tagcal::tools
