// Measures the speed of undistortion beside OpenCV's, in one thread: 12 megapixels through
// `reproject` (map and picture in one pass), and through cv::initUndistortRectifyMap (or its
// fisheye twin) and cv::remap together.
//
//   reproject_benchmark [rounds, default 15]
//
// The two alternate; the table has medians of processor time, and the median of the rounds' ratios.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tagcal/random.hpp"
#include "tagcal/reproject/resampling.hpp"

namespace {

using tagcal::Interpolation;

constexpr tagcal::ImageSize kSize = {4000, 3000};

struct Lens {
  const char* name;
  tagcal::Lens lens;
  std::vector<double> coefficients;  // OpenCV's
  double zoom = 1;                   // focal length of the new camera by that of the old one
};

const std::vector<Lens> kLenses = {
    {"all px",  // the new camera of --undistort all, which shrinks the middle: pixels are averaged
     tagcal::Perspective({2400, 2400, 2010, 1490, -0.25, 0.06, 0, 0, 0, 0, 0, 0}),
     {-0.25, 0.06, 0, 0, 0},
     0.74},
    {"opencv5",
     tagcal::Perspective({3000, 3000, 2010, 1490, -0.25, 0.08, 5e-4, -3e-4, 0.01, 0, 0, 0}),
     {-0.25, 0.08, 5e-4, -3e-4, 0.01}},
    {"opencv8",
     tagcal::Perspective({3000, 3000, 2010, 1490, 0.1, 0.08, 5e-4, -3e-4, 0.01, 0.3, 0.02, 0.001}),
     {0.1, 0.08, 5e-4, -3e-4, 0.01, 0.3, 0.02, 0.001}},
    {"fisheye4",
     tagcal::Fisheye({1900, 1900, 2010, 1490, 0.02, -0.01, 0.003, -0.0005}),
     {0.02, -0.01, 0.003, -0.0005}}};

double processor_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <typename Work>
double time_ms(const Work& work) {
  const double begin = processor_ms();
  work();
  return processor_ms() - begin;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

template <typename T>
tagcal::Image<T> noise() {
  tagcal::Image<T> image(kSize);
  tagcal::Random random(1, 0);
  for (int y = 0; y < kSize.height; ++y) {
    auto* const bytes = reinterpret_cast<unsigned char*>(image.row(y));
    for (std::size_t i = 0; i < sizeof(T) * kSize.width; ++i)
      bytes[i] = static_cast<unsigned char>(random.next());
  }
  return image;
}

template <typename T>
void compare(const char* kind, int type, const Lens& lens, Interpolation interpolation, int flag,
             int rounds) {
  const tagcal::Image<T> picture = noise<T>();
  const cv::Mat mat(kSize.height, kSize.width, type, const_cast<T*>(picture.row(0)));
  const auto p = tagcal::parameters(lens.lens);
  const double f[] = {lens.zoom * p[0], lens.zoom * p[1]};
  const cv::Matx33d k(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
  const cv::Matx33d new_k(f[0], 0, p[2], 0, f[1], p[3], 0, 0, 1);
  const tagcal::Reprojection chain = {
      {lens.lens, kSize}, tagcal::Camera{tagcal::pinhole(f[0], f[1], p[2], p[3]), kSize}, {}};
  std::vector<double> ours, theirs, ratios;
  for (int i = 0; i < rounds; ++i) {
    ours.push_back(time_ms([&] {
      tagcal::ResampleOptions options;
      options.interpolation = interpolation;
      tagcal::reproject(picture, chain, options);
    }));
    theirs.push_back(time_ms([&] {
      cv::Mat x, y, out;
      const cv::Size size(kSize.width, kSize.height);
      if (lens.coefficients.size() == 4)
        cv::fisheye::initUndistortRectifyMap(k, lens.coefficients, cv::Matx33d::eye(), new_k, size,
                                             CV_32FC1, x, y);
      else
        cv::initUndistortRectifyMap(k, lens.coefficients, cv::Matx33d::eye(), new_k, size, CV_32FC1,
                                    x, y);
      cv::remap(mat, out, x, y, flag, cv::BORDER_CONSTANT);
    }));
    ratios.push_back(ours.back() / theirs.back());
  }
  std::printf("%-9s %-10s %-9s %8.1f %8.1f %7.2f\n", lens.name, kind,
              flag == cv::INTER_LINEAR ? "bilinear" : "lanczos4", median(ours), median(theirs),
              median(ratios));
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  cv::setNumThreads(1);
  std::printf("%dx%d pixels, processor time in ms, %d rounds\n", kSize.width, kSize.height, rounds);
  std::printf("%-9s %-10s %-9s %8s %8s %7s\n", "lens", "picture", "kernel", "tagcal", "OpenCV",
              "ratio");
  const auto bilinear = Interpolation::bilinear, lanczos = Interpolation::lanczos4;
  for (const Lens& lens : kLenses) {
    compare<std::uint8_t>("grey 8", CV_8UC1, lens, bilinear, cv::INTER_LINEAR, rounds);
    compare<tagcal::Rgb>("colour 8", CV_8UC3, lens, bilinear, cv::INTER_LINEAR, rounds);
    compare<std::uint16_t>("grey 16", CV_16UC1, lens, bilinear, cv::INTER_LINEAR, rounds);
    compare<tagcal::Rgb16>("colour 16", CV_16UC3, lens, bilinear, cv::INTER_LINEAR, rounds);
  }
  const int few = std::max(1, rounds / 5);
  compare<std::uint8_t>("grey 8", CV_8UC1, kLenses[1], lanczos, cv::INTER_LANCZOS4, few);
  compare<tagcal::Rgb>("colour 8", CV_8UC3, kLenses[1], lanczos, cv::INTER_LANCZOS4, few);
}
