// Measures the speed of undistortion beside OpenCV's, in one thread: 12 megapixels through
// `reproject` (map and picture in one pass), and through cv::initUndistortRectifyMap (or its
// fisheye twin) and cv::remap together. The two alternate (docs/tasks/reproject.md).

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "studies/studies.hpp"
#include "study/processor_time.hpp"
#include "tagcal/random.hpp"
#include "tagcal/reproject/rectify.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace tagcal {
using namespace study;
namespace {

constexpr ImageSize kSize = {4000, 3000};

struct NamedLens {
  const char* name;
  Lens lens;
  std::vector<double> coefficients;  // OpenCV's
  double zoom = 1;                   // focal length of the new camera by that of the old one
};

const std::vector<NamedLens> kLenses = {
    {"all px",  // the new camera of --undistort all, which shrinks the middle: pixels are averaged
     Perspective({2400, 2400, 2010, 1490, -0.25, 0.06, 0, 0, 0, 0, 0, 0}),
     {-0.25, 0.06, 0, 0, 0},
     0.74},
    {"opencv5",
     Perspective({3000, 3000, 2010, 1490, -0.25, 0.08, 5e-4, -3e-4, 0.01, 0, 0, 0}),
     {-0.25, 0.08, 5e-4, -3e-4, 0.01}},
    {"opencv8",
     Perspective({3000, 3000, 2010, 1490, 0.1, 0.08, 5e-4, -3e-4, 0.01, 0.3, 0.02, 0.001}),
     {0.1, 0.08, 5e-4, -3e-4, 0.01, 0.3, 0.02, 0.001}},
    {"fisheye4",
     Fisheye({1900, 1900, 2010, 1490, 0.02, -0.01, 0.003, -0.0005}),
     {0.02, -0.01, 0.003, -0.0005}}};

template <typename Work>
double time_ms(const Work& work) {
  const double begin = thread_processor_us();
  work();
  return 1e-3 * (thread_processor_us() - begin);
}

template <typename T>
Image<T> noise() {
  Image<T> image(kSize);
  Random random(1, 0);
  for (int y = 0; y < kSize.height; ++y) {
    auto* const bytes = reinterpret_cast<unsigned char*>(image.row(y));
    for (std::size_t i = 0; i < sizeof(T) * kSize.width; ++i)
      bytes[i] = static_cast<unsigned char>(random.next());
  }
  return image;
}

void opencv_undistort(const cv::Mat& mat, const NamedLens& lens, const cv::Matx33d& k,
                      const cv::Matx33d& new_k, int flag) {
  cv::Mat x, y, out;
  const cv::Size size(kSize.width, kSize.height);
  if (lens.coefficients.size() == 4)
    cv::fisheye::initUndistortRectifyMap(k, lens.coefficients, cv::Matx33d::eye(), new_k, size,
                                         CV_32FC1, x, y);
  else
    cv::initUndistortRectifyMap(k, lens.coefficients, cv::Matx33d::eye(), new_k, size, CV_32FC1, x,
                                y);
  cv::remap(mat, out, x, y, flag, cv::BORDER_CONSTANT);
}

template <typename T>
Task task_of(const char* kind, int type, const NamedLens& lens, Interpolation interpolation) {
  const bool is_linear = interpolation == Interpolation::bilinear;
  const int flag = is_linear ? cv::INTER_LINEAR : cv::INTER_LANCZOS4;
  const auto measure = [=, &lens](std::uint64_t) -> std::vector<Values> {
    const Image<T> picture = noise<T>();
    const cv::Mat mat(kSize.height, kSize.width, type, const_cast<T*>(picture.row(0)));
    const auto p = parameters(lens.lens);
    const double f[] = {lens.zoom * p[0], lens.zoom * p[1]};
    const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    const cv::Matx33d new_k(f[0], 0, p[2], 0, f[1], p[3], 0, 0, 1);
    const Reprojection chain = {
        {lens.lens, kSize}, Camera{pinhole(f[0], f[1], p[2], p[3]), kSize}, {}};
    ResampleOptions options;
    options.interpolation = interpolation;
    const double ours = time_ms([&] { reproject(picture, chain, options); });
    const double theirs = time_ms([&] { opencv_undistort(mat, lens, k, new_k, flag); });
    return {{ours, theirs, ours / theirs}};
  };
  return {fmt::format("{}, {}, {}", lens.name, kind, is_linear ? "bilinear" : "lanczos4"), measure};
}

// Both pictures of a stereo pair, rectified.
template <typename T>
Task pair_task(const char* kind, int type) {
  const auto measure = [=](std::uint64_t) -> std::vector<Values> {
    const NamedLens& lens = kLenses[1];
    const auto member = [&](const Pose& place) {
      return KnownRig::Member{"", {nullptr, {lens.lens, kSize}, {}}, place, {}};
    };
    const KnownRig rig = {
        {member({}), member({exp_rotation({0.01, -0.02, 0.01}), {-0.1, 0.001, 0.002}})}, {}};
    const RectifiedPair pair = rectify(rig, 0, 1);
    const Image<T> picture = noise<T>();
    const cv::Mat mat(kSize.height, kSize.width, type, const_cast<T*>(picture.row(0)));
    const auto p = parameters(lens.lens);
    const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    double ours = 0, theirs = 0;
    for (std::size_t c = 0; c < 2; ++c) {
      ours += time_ms([&] { reproject(picture, rectification(rig, pair, c)); });
      const ProjectionMatrix q = projection_matrix(pair, c);
      const Eigen::Matrix3d r = pair.camera_from_rectified[c].rotation_matrix().transpose();
      const cv::Matx33d turn(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                             r(2, 2));
      const cv::Matx33d new_k(q(0, 0), 0, q(0, 2), 0, q(1, 1), q(1, 2), 0, 0, 1);
      theirs += time_ms([&] {
        cv::Mat x, y, out;
        cv::initUndistortRectifyMap(k, lens.coefficients, turn, new_k, mat.size(), CV_32FC1, x, y);
        cv::remap(mat, out, x, y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
      });
    }
    return {{ours, theirs, ours / theirs}};
  };
  return {fmt::format("rectified pair, {}, bilinear", kind), measure};
}

std::vector<Task> reproject_speed_tasks(const StudyOptions&) {
  const auto bilinear = Interpolation::bilinear, lanczos = Interpolation::lanczos4;
  std::vector<Task> tasks;
  for (const NamedLens& lens : kLenses) {
    tasks.push_back(task_of<std::uint8_t>("grey 8", CV_8UC1, lens, bilinear));
    tasks.push_back(task_of<Rgb>("colour 8", CV_8UC3, lens, bilinear));
    tasks.push_back(task_of<std::uint16_t>("grey 16", CV_16UC1, lens, bilinear));
    tasks.push_back(task_of<Rgb16>("colour 16", CV_16UC3, lens, bilinear));
  }
  tasks.push_back(pair_task<std::uint8_t>("grey 8", CV_8UC1));
  tasks.push_back(pair_task<Rgb>("colour 8", CV_8UC3));
  tasks.push_back(task_of<std::uint8_t>("grey 8", CV_8UC1, kLenses[1], lanczos));
  tasks.push_back(task_of<Rgb>("colour 8", CV_8UC3, kLenses[1], lanczos));
  return tasks;
}

}  // namespace

Study reproject_speed_study() {
  return {.name = "reproject_speed",
          .summary = "processor time of undistorting 12 megapixels, beside OpenCV's",
          .count = 15,
          .columns = {"tagcal_ms", "opencv_ms", "ratio"},
          .tasks = reproject_speed_tasks,
          .tables = {{{"task"},
                      {quantile_of("tagcal, ms", "tagcal_ms", 0.5, 1),
                       quantile_of("OpenCV, ms", "opencv_ms", 0.5, 1),
                       quantile_of("ratio", "ratio", 0.5, 2)}}}};
}

}  // namespace tagcal
