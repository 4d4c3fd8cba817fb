// Callers in several threads get the answers of one. The preset tsan runs this under the thread
// sanitizer.

#include <gtest/gtest.h>

#include <thread>

#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/io/scene_file.hpp"
#include "tagcal/scene/render.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

// A caller works on its own data; its numbers must be equal to the last bit.
std::vector<double> calibrated(const Dataset& dataset) {
  const Calibration c = calibrate(dataset, {.num_threads = 2});
  std::vector<double> numbers = {c.rms_px, c.sigma_px};
  if (c.camera)
    for (const double p : parameters(c.camera->lens)) numbers.push_back(p);
  return numbers;
}

std::vector<double> posed(const Camera& camera) {
  std::vector<Correspondence> correspondences;
  const Pose truth(exp_rotation({0.3, -0.2, 0.1}), {0.02, -0.03, 0.6});
  for (const double x : {-0.1, 0.0, 0.1})
    for (const double y : {-0.1, 0.0, 0.1})
      correspondences.push_back(
          {{x, y, 0}, *project(camera.lens, truth * Eigen::Vector3d(x, y, 0))});
  correspondences[4].pixel.x() += 40;  // the search takes part
  const PoseEstimate estimate = estimate_pose(correspondences, camera, {.sigma_px = 0.1});
  const Eigen::Vector3d t = estimate.camera_from_target().translation();
  return {t.x(), t.y(), t.z(), estimate.hypotheses.front().rms_px};
}

std::vector<double> detected(const Image8& image, const std::vector<PlacedBoard>& boards) {
  std::vector<double> numbers;
  for (const Observation& o : detect(image, boards, {.threads = 2}, "a.png").view.observations) {
    numbers.push_back(o.pixel.x());
    numbers.push_back(o.pixel.y());
  }
  return numbers;
}

template <typename Work>
void expect_equal_in_threads(const Work& work) {
  constexpr std::size_t kThreads = 2, kRepeats = 2;
  const std::vector<double> alone = work();
  EXPECT_FALSE(alone.empty());
  std::vector<std::vector<double>> answers(kThreads * kRepeats);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < kThreads; ++t)
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < kRepeats; ++i) answers[t * kRepeats + i] = work();
      });
  }
  for (const std::vector<double>& answer : answers) EXPECT_EQ(answer, alone);
}

TEST(Threads, CalibrationsAreThoseOfOne) {
  WorldOptions options;
  options.num_views = 6;
  options.outlier_share = 0.02;
  const Dataset dataset = make_world(opencv5_lens(), 11, options);
  expect_equal_in_threads([&] { return calibrated(dataset); });
}

TEST(Threads, PosesAreThoseOfOne) {
  const Camera camera{opencv5_lens(), {1280, 800}};
  expect_equal_in_threads([&] { return posed(camera); });
}

TEST(Threads, CornersAreThoseOfOne) {
  const Scene scene = read_scene(TAGCAL_SOURCE_DIR "/data-synthetic/scenes/tabletop.yaml", nullptr);
  const ImageF light =
      render_light(scene, tag_families(scene.boards), camera_poses(scene, 1).front());
  const Image8 image = expose(light, scene.sensor, 1);
  expect_equal_in_threads([&] { return detected(image, scene.boards); });
}

}  // namespace
}  // namespace tagcal
