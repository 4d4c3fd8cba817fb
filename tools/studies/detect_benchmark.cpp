// Measures the time of detect() beside AprilTag's own detector (quad_decimate 1, one thread, one
// pass, with its own refine_edges) and OpenCV's aruco (its default settings, one thread), where
// that is installed, on the same rendered pictures of a board of 36 tags, plain or Kalibr's, of
// 1280x800 pixels and of 12 megapixels, with the board inside and partly outside of the picture;
// and the time of reading them as PNG. `tagcal chart corners` has files to corners in random views,
// with their errors.
//   detect_benchmark [runs, default 5 [pictures of a 6x6 board, tags 0 to 35 ..]]
// Times are medians over the runs, wall clock and processor.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "study/peers/apriltag_peer.hpp"
#include "study/peers/aruco_peer.hpp"
#include "study/study_threads.hpp"
#include "study/tasks/board_view.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/io/image_file.hpp"

namespace {

using namespace tagcal;
using namespace tagcal::study;

struct Picture {
  std::string name;
  bool is_plain = false;  // a board of plain tags, not Kalibr's
  Image8 image;
  int expected = -1;  // tags wholly in the picture; -1: unknown
};

struct Seconds {
  double wall = 0;
  double processor = 0;
};

Seconds timed(int runs, const std::function<void()>& work) {
  std::vector<double> wall, processor;
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t clock = std::clock();
    work();
    processor.push_back(static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC);
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return {median(wall), median(processor)};
}

// The board is `aside` metres off the optical axis.
Picture rendered(const std::string& name, const ImageSize& size, double aside, bool is_plain) {
  const BoardScene board(size, is_plain);
  const Pose pose = board_pose({0.5, 1, 0.2}, aside);
  return {name, is_plain,
          expose(render_light(board.scene, board.families, pose), board.scene.sensor, 5),
          static_cast<int>(board.whole_tags(pose).size())};
}

struct Line {
  std::string name;
  Seconds seconds;
  std::size_t tags = 0;
};

int border_bits(const Picture& picture) { return picture.is_plain ? 1 : 2; }

Line apriltag_alone(const Picture& picture, int runs) {
  const AprilTagPeer detector("tag36h11", border_bits(picture));
  Line line{"AprilTag alone", {}, 0};
  line.seconds = timed(runs, [&] { line.tags = detector.find(picture.image, true).size(); });
  return line;
}

Line aruco_alone(const Picture& picture, int runs) {
  const OneOpenCvThread one_thread;
  Line line{"OpenCV aruco", {}, 0};
  line.seconds =
      timed(runs, [&] { line.tags = aruco_tags(picture.image, border_bits(picture)).size(); });
  return line;
}

// Reading of the picture as PNG.
Line reading(const Image8& image, int runs) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("detect_benchmark_" + std::to_string(std::clock()) + ".png");
  write_png(file, image);
  const Line line{"reading", timed(runs, [&] { read_image(file); }), 0};
  std::filesystem::remove(file);
  return line;
}

Line detected(const Picture& picture, int runs, const std::string& name,
              const DetectOptions& options) {
  const Image8& image = picture.image;
  const std::vector<PlacedBoard> boards = BoardScene(image.size(), picture.is_plain).scene.boards;
  Line line{name, {}, 0};
  line.seconds =
      timed(runs, [&] { line.tags = detect(image, boards, options).view.observations.size() / 4; });
  return line;
}

void run(const Picture& picture, int runs) {
  std::printf("%s, %dx%d", picture.name.c_str(), picture.image.width(), picture.image.height());
  if (picture.expected >= 0) std::printf(", %d tags whole", picture.expected);
  std::printf("\n");
  const Line alone = apriltag_alone(picture, runs);
  std::vector<Line> lines = {reading(picture.image, runs), alone};
  if (has_aruco()) lines.push_back(aruco_alone(picture, runs));
  for (const int threads : {1, 2}) {
    for (const auto& [name, refinement] : {std::pair{"corners as found", Refinement::stock},
                                           {"by edges", Refinement::edges},
                                           {"by fit", Refinement::fit}}) {
      const std::string text = std::string(name) + (threads == 1 ? ", 1 thread" : ", 2 threads");
      lines.push_back(detected(picture, runs, text, {threads, 1, refinement}));
    }
  }
  std::printf("  %-28s %5s %9s %14s %18s\n", "", "tags", "wall s", "processor s",
              "of AprilTag alone");
  for (const Line& line : lines)
    std::printf("  %-28s %5zu %9.4f %14.4f %18.2f\n", line.name.c_str(), line.tags,
                line.seconds.wall, line.seconds.processor,
                line.seconds.processor / alone.seconds.processor);
}

// Eight equal pictures in one call, on one and on two threads.
void run_many(const Image8& image, int runs) {
  const std::vector<ImageSource> images(8, {"", [&image] { return image; }});
  const std::vector<PlacedBoard> boards = BoardScene(image.size(), false).scene.boards;
  for (const int threads : {1, 2}) {
    const Seconds s = timed(runs, [&] { detect_all(images, boards, {threads}); });
    std::printf("8 pictures of %dx%d, %d thread(s): wall %.3f s, processor %.3f s\n", image.width(),
                image.height(), threads, s.wall, s.processor);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::max(1, std::atoi(argv[1])) : 5;
  for (const bool is_plain : {true, false})
    for (const ImageSize& size : {ImageSize{1280, 800}, ImageSize{4000, 3000}}) {
      const std::string name = is_plain ? "plain tags" : "Kalibr's tags";
      run(rendered(name, size, 0, is_plain), runs);
      run(rendered(name + ", leaving the picture", size, 0.35, is_plain), runs);
    }
  for (int i = 2; i < argc; ++i) run({argv[i], false, read_image(argv[i])}, runs);
  run_many(rendered("", {1280, 800}, 0, false).image, runs);
}
