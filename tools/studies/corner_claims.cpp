// Compares the errors of detected corners with their covariances, on rendered data sets
// (docs/trust/corners.md).
//   corner_claims [--worst N] [--edges] [--camera] DATASET...
// Each DATASET is a folder that `tagcal render` made, with its truth; `--camera` fits the tags
// under the true lens, `--edges` fits their sides only, `--worst` lists the N worst corners. Per
// data set: tags reported, tags rejected because they could not be fitted, corners, corners without
// covariance and their largest error. For the others: median claimed standard deviation, RMS error,
// NEES/2 (1 where the covariances are right), how many have a Mahalanobis distance beyond 3 and 5,
// and the largest distance.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "tagcal/detect/detector.hpp"
#include "tagcal/error.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/io/image_file.hpp"

namespace tagcal {
namespace {

struct Corner {
  std::string image;
  CornerId id;
  Eigen::Vector2d error = Eigen::Vector2d::Zero();
  double sigma_px = 0;  // RMS over both coordinates; 0: no covariance
  double distance = 0;  // Mahalanobis distance of the error
};

struct Claims {
  int pictures = 0, tags = 0, unfitted = 0;
  std::vector<Corner> corners, unclaimed;

  void add(const Claims& other) {
    pictures += other.pictures;
    tags += other.tags;
    unfitted += other.unfitted;
    corners.insert(corners.end(), other.corners.begin(), other.corners.end());
    unclaimed.insert(unclaimed.end(), other.unclaimed.begin(), other.unclaimed.end());
  }
};

Claims claims_of(const Dataset& set, const std::vector<View>& views) {
  Claims claims;
  const auto points = points_in_world(set.boards);
  for (const View& view : views) {
    ++claims.pictures;
    const Pose& pose = set.truth->camera_from_world.at(view.image);
    int tag = -1;
    for (const Observation& seen : view.observations) {
      if (seen.id.tag_id != tag) ++claims.tags;
      tag = seen.id.tag_id;
      const auto truth = project(set.truth->camera.lens, pose * points.at(seen.id));
      Corner corner{view.image, seen.id, {1e3, 1e3}, 0, 0};
      if (truth) corner.error = seen.pixel - *truth;
      if (!seen.covariance_px2) {
        claims.unclaimed.push_back(corner);
        continue;
      }
      const Eigen::Matrix2d covariance = *seen.covariance_px2;
      corner.sigma_px = std::sqrt(covariance.trace() / 2);
      corner.distance = std::sqrt(corner.error.dot(covariance.inverse() * corner.error));
      claims.corners.push_back(corner);
    }
  }
  return claims;
}

void print(const std::string& name, Claims& claims) {
  double squares = 0, nees = 0, largest = 0, unclaimed = 0;
  std::vector<double> sigmas;
  int beyond_3 = 0, beyond_5 = 0;
  for (const Corner& corner : claims.corners) {
    squares += corner.error.squaredNorm() / 2;
    nees += corner.distance * corner.distance / 2;
    largest = std::max(largest, corner.distance);
    beyond_3 += corner.distance > 3;
    beyond_5 += corner.distance > 5;
    sigmas.push_back(corner.sigma_px);
  }
  for (const Corner& corner : claims.unclaimed)
    unclaimed = std::max(unclaimed, corner.error.norm());
  std::ranges::sort(sigmas);
  const double n = std::max(1.0, static_cast<double>(claims.corners.size()));
  std::printf("%-28s %4d %6d %5d %7zu | %6zu %7.2f | %7.4f %7.4f %7.2f %8.3f%% %4d %8.1f\n",
              name.c_str(), claims.pictures, claims.tags, claims.unfitted, claims.corners.size(),
              claims.unclaimed.size(), unclaimed, sigmas.empty() ? 0 : sigmas[sigmas.size() / 2],
              std::sqrt(squares / n), nees / n, 100 * beyond_3 / n, beyond_5, largest);
  std::fflush(stdout);
}

void print_worst(Claims& claims, std::size_t count) {
  std::ranges::sort(claims.corners, std::greater(), &Corner::distance);
  for (std::size_t i = 0; i < std::min(count, claims.corners.size()); ++i) {
    const Corner& c = claims.corners[i];
    std::printf("  %s tag %d corner %d: off by %+.4f %+.4f px, sigma %.4f px, %.1f sigmas\n",
                c.image.c_str(), c.id.tag_id, c.id.corner, c.error.x(), c.error.y(), c.sigma_px,
                c.distance);
  }
}

int run(int argc, char** argv) {
  std::size_t worst = 0;
  DetectOptions options;
  bool knows_camera = false;
  std::vector<std::string> folders;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--worst" && i + 1 < argc)
      worst = static_cast<std::size_t>(std::atoi(argv[++i]));
    else if (argument == "--edges")
      options.refinement = Refinement::edges;
    else if (argument == "--camera")
      knows_camera = true;
    else
      folders.push_back(argument);
  }
  if (folders.empty())
    throw Error("usage: corner_claims [--worst N] [--edges] [--camera] DATASET...");
  std::printf("%-28s %4s %6s %5s %7s | %6s %7s | %7s %7s %7s %9s %4s %8s\n", "data set", "pics",
              "tags", "left", "corners", "no cov", "max px", "med sd", "rms px", "NEES/2", "> 3",
              "> 5", "largest");
  Claims all;
  for (const std::string& folder : folders) {
    const DatasetFolder read = read_dataset(folder);
    if (!read.dataset.truth) throw Error(folder + ": needs a truth");
    if (knows_camera) options.camera = &read.dataset.truth->camera;
    std::vector<ImageSource> sources;
    for (const auto& file : read.images)
      sources.push_back({file.filename().string(), [file] { return read_image(file); }});
    const std::vector<DetectedPicture> found = detect_all(sources, read.dataset.boards, options);
    Claims claims = claims_of(read.dataset, views_of(found));
    for (const DetectedPicture& picture : found)
      claims.unfitted += static_cast<int>(picture.unfitted.size());
    print(std::filesystem::path(folder).filename().string(), claims);
    print_worst(claims, worst);
    all.add(claims);
  }
  if (folders.size() > 1) print("all", all);
  return 0;
}

}  // namespace
}  // namespace tagcal

int main(int argc, char** argv) {
  try {
    return tagcal::run(argc, argv);
  } catch (const tagcal::Error& error) {
    std::fprintf(stderr, "corner_claims: %s\n", error.what());
    return 2;
  }
}
