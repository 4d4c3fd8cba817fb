// Measures the time of detect() beside AprilTag's own detector (quad_decimate 1, one thread, one
// pass, with its own refine_edges) and OpenCV's aruco (its default settings, one thread), where
// that is installed, on the same rendered pictures of a board of 36 tags, plain or Kalibr's, of
// 1280x800 pixels and of 12 megapixels, with the board inside and partly outside of the picture;
// and the time of reading them as PNG.
//   detect_benchmark [runs, default 5 [pictures of a 6x6 board, tags 0 to 35 ..]]
// Times are medians over the runs, wall clock and processor.

#ifdef TAGCAL_HAS_ARUCO
#include <opencv2/aruco.hpp>
#include <opencv2/imgcodecs.hpp>
#endif

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/families.hpp"
#include "tagcal/io/image_file.hpp"
#include "tagcal/scene/render.hpp"

namespace {

using namespace tagcal::internal;

using namespace tagcal;

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

Board board_of(bool is_plain) {
  const Board kalibr = grid_board({6, 6, 0.088, 0.3, 0});
  return is_plain ? grid_board({6, 6, 0.088, 0.3, 0}, "tag36h11", 1, false) : kalibr;
}

int whole_tags(const Board& board, const Camera& camera, const Pose& camera_from_board) {
  int count = 0;
  for (const Tag& tag : board.tags) {
    const auto corners = tag_corners(tag);
    count += std::ranges::all_of(corners, [&](const Eigen::Vector3d& corner) {
      const auto pixel = project(camera.lens, camera_from_board * corner);
      return pixel && pixel->minCoeff() > 1 && pixel->x() < camera.image_size.width - 2 &&
             pixel->y() < camera.image_size.height - 2;
    });
  }
  return count;
}

// The board is tilted by half a radian, `aside` metres off the optical axis.
Picture rendered(const std::string& name, const ImageSize& size, double aside, bool is_plain) {
  Scene scene;
  const double f = 0.8 * size.width;
  scene.camera = {Perspective({f, f, 0.5 * size.width - 0.5, 0.5 * size.height - 0.5, -0.2, 0.05}),
                  size};
  scene.boards = {{board_of(is_plain), Pose()}};
  scene.sensor = {1, 0.8, 3};
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.5, 1, 0.2).normalized()));
  const Eigen::Quaterniond turn = tilt * facing;
  const Pose pose(turn, Eigen::Vector3d(aside, 0, 0.95) - turn * Eigen::Vector3d(0.33, 0.33, 0));
  const TagFamilies families = {{"tag36h11", tag_family("tag36h11", is_plain ? 1 : 2)}};
  return {name, is_plain, expose(render_light(scene, families, pose), scene.sensor, 5),
          whole_tags(scene.boards[0].board, scene.camera, pose)};
}

struct Line {
  std::string name;
  Seconds seconds;
  std::size_t tags = 0;
};

Line apriltag_alone(const Picture& picture, int runs) {
  const Image8& image = picture.image;
  const FamilyHandle family = create_family("tag36h11", picture.is_plain ? 1 : 2);
  const DetectorHandle detector(apriltag_detector_create());
  apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
  detector->nthreads = 1;
  detector->quad_decimate = 1;
  detector->refine_edges = true;
  image_u8_t view = {image.width(), image.height(), image.width(),
                     const_cast<std::uint8_t*>(image.row(0))};
  Line line{"AprilTag alone", {}, 0};
  line.seconds = timed(runs, [&] {
    const DetectionsHandle found(apriltag_detector_detect(detector.get(), &view));
    line.tags = static_cast<std::size_t>(zarray_size(found.get()));
  });
  return line;
}

#ifdef TAGCAL_HAS_ARUCO
Line aruco_alone(const Picture& picture, int runs) {
  cv::setNumThreads(1);
  const auto codes = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  const auto options = cv::aruco::DetectorParameters::create();
  options->markerBorderBits = picture.is_plain ? 1 : 2;
  const Image8& image = picture.image;
  const cv::Mat view(image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0)));
  Line line{"OpenCV aruco", {}, 0};
  line.seconds = timed(runs, [&] {
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(view, codes, corners, ids, options);
    line.tags = ids.size();
  });
  return line;
}
#endif

// Reading of the picture as PNG.
std::vector<Line> readings(const Image8& image, int runs) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("detect_benchmark_" + std::to_string(std::clock()) + ".png");
  write_png(file, image);
  std::vector<Line> lines = {{"reading", timed(runs, [&] { read_image(file); }), 0}};
#ifdef TAGCAL_HAS_ARUCO
  lines.push_back({"reading, OpenCV",
                   timed(runs, [&] { cv::imread(file.string(), cv::IMREAD_GRAYSCALE); }), 0});
#endif
  std::filesystem::remove(file);
  return lines;
}

Line detected(const Picture& picture, int runs, const std::string& name,
              const DetectOptions& options) {
  const Image8& image = picture.image;
  const std::vector<PlacedBoard> boards = {{board_of(picture.is_plain), Pose()}};
  Line line{name, {}, 0};
  line.seconds = timed(runs, [&] {
    line.tags = detect(image, "", boards, options, nullptr).observations.size() / 4;
  });
  return line;
}

void run(const Picture& picture, int runs) {
  std::printf("%s, %dx%d", picture.name.c_str(), picture.image.width(), picture.image.height());
  if (picture.expected >= 0) std::printf(", %d tags whole", picture.expected);
  std::printf("\n");
  const Line alone = apriltag_alone(picture, runs);
  std::vector<Line> lines = readings(picture.image, runs);
  lines.push_back(alone);
#ifdef TAGCAL_HAS_ARUCO
  lines.push_back(aruco_alone(picture, runs));
#endif
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
  const std::vector<PlacedBoard> boards = {{board_of(false), Pose()}};
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
