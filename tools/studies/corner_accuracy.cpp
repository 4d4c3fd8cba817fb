// Measures the errors of the corners of single tags (docs/trust/corners.md), on the same rendered
// pixels: the fit of the whole tag (refine_tag), without and with bends, the fit of the sides, and
// AprilTag's own corners, beside the Cramer-Rao bound of each fitted model.
//   corner_accuracy [tags per row, default 200 [row]]
// The same for tags of all sizes anywhere in the picture, with the lens unknown and known to the
// fit:
//   corner_accuracy lens [tags per row, default 200 [side, px [number of the lens]]]
// Processor time of a tag's fit, beside cv::cornerSubPix of its corners and AprilTag's detector:
//   corner_accuracy speed [tags per row, default 20]

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "rendered_tag.hpp"
#include "tagcal/detect/apriltag/apriltag_handles.hpp"
#include "tagcal/detect/detector.hpp"
#include "tagcal/detect/refine.hpp"

namespace {

using namespace tagcal::internal;

using namespace tagcal;
using Corners = std::array<Eigen::Vector2d, 4>;

struct Row {
  TagViewSpec spec;
  double edge_bound_px;  // Cramer-Rao bound from step edges along the border alone
};

const Row kRows[] = {{{20, 30, .8, 2}, .0122}, {{30, 30, .8, 2}, .0081},  {{40, 30, .8, 2}, .0066},
                     {{80, 30, .8, 2}, .0045}, {{160, 30, .8, 2}, .0032}, {{40, 0, .8, 2}, .0062},
                     {{40, 60, .8, 2}, .0098}, {{40, 30, .3, 2}, .0044},  {{40, 30, 1.5, 2}, .0107},
                     {{40, 30, .8, 0}, .0009}, {{40, 30, .8, 8}, .026}};

class Errors {
 public:
  void add(const Corners& found, const Corners& truth) {
    const Eigen::Vector2d centre = 0.25 * (truth[0] + truth[1] + truth[2] + truth[3]);
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d e = found[i] - truth[i];
      mean_ += e;
      outwards_ += e.dot((truth[i] - centre).normalized());
      squares_ += e.squaredNorm();
      ++corners_;
    }
  }
  int tags() const { return corners_ / 4; }
  double rms() const { return std::sqrt(squares_ / (2 * corners_)); }
  Eigen::Vector2d mean() const { return mean_ / corners_; }
  double outwards() const { return outwards_ / corners_; }

 private:
  int corners_ = 0;
  Eigen::Vector2d mean_ = Eigen::Vector2d::Zero();
  double outwards_ = 0, squares_ = 0;
};

class FitTally {
 public:
  explicit FitTally(const TagFitOptions& options) : options_(options) {}

  void add(const TagView& view, const TagPattern& pattern, const Corners& start, double noise) {
    const std::clock_t begin = std::clock();
    const TagFit fit = refine_tag(view.image, pattern, start, options_);
    seconds_.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    // A fit without noise but that of rounding, with the priors of the bends in proportion, gives
    // the bound up to its scale.
    const double scale = std::sqrt(noise * noise * 12 + 1);
    TagFitOptions in_proportion = options_;
    in_proportion.bend_sd_per_px /= scale;
    in_proportion.twist_sd_per_px2 /= scale;
    const TagFit exact = refine_tag(view.noiseless, pattern, view.corners, in_proportion);
    if (fit.status != TagFitStatus::converged || exact.status != TagFitStatus::converged) return;
    errors_.add(fit.corners, view.corners);
    const double unit = scale / std::sqrt(12.0) / exact.noise_levels;
    bound_ += exact.covariance_px2.trace() * unit * unit;
    predicted_ += fit.covariance_px2.trace();
    iterations_ += fit.iterations;
  }

  void print(const char* name, const Row& row) {
    const double n = 8 * errors_.tags();
    const double bound = std::sqrt(bound_ / n), rms = errors_.rms();
    const auto middle = seconds_.begin() + static_cast<std::ptrdiff_t>(seconds_.size() / 2);
    std::nth_element(seconds_.begin(), middle, seconds_.end());
    std::printf(
        "  %-8s %3d of %3d  rms %.4f  bound %.4f (%.2f)  edges' bound %.4f (%.2f)  mean %+.4f "
        "%+.4f "
        "out %+.4f  predicted/observed %.3f  %.1f steps  %.3f ms\n",
        name, errors_.tags(), static_cast<int>(seconds_.size()), rms, bound, rms / bound,
        row.edge_bound_px, rms / row.edge_bound_px, errors_.mean().x(), errors_.mean().y(),
        errors_.outwards(), std::sqrt(predicted_ / n) / rms, iterations_ / errors_.tags(),
        1e3 * *middle);
  }

 private:
  TagFitOptions options_;
  Errors errors_;
  double bound_ = 0, predicted_ = 0, iterations_ = 0;
  std::vector<double> seconds_;
};

void detect_with(Refinement refinement, const TagView& view, Errors& errors) {
  const PlacedBoard placed{{Tags{.tags = {{view.id, 1.0, Pose()}}}, {}}, Pose()};
  DetectOptions options;
  options.refinement = refinement;
  const View found = detect(view.image, {placed}, options).view;
  if (found.observations.size() != 4) return;
  Corners corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = found.observations[i].pixel;
  errors.add(corners, view.corners);
}

void run(const Row& row, int count) {
  Random random(9090);
  const TagFamily family = tag_family("tag36h11", 1);
  FitTally straight(TagFitOptions{0, 0, 12}), bent{TagFitOptions()};
  Errors edges, stock;
  for (int i = 0; i < count; ++i) {
    const TagView view = rendered_tag(row.spec, random);
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    Corners start = view.corners;
    for (Eigen::Vector2d& corner : start)
      corner += Eigen::Vector2d(random.uniform(-.2, .2), random.uniform(-.2, .2));
    straight.add(view, pattern, start, row.spec.noise_levels);
    bent.add(view, pattern, start, row.spec.noise_levels);
    detect_with(Refinement::edges, view, edges);
    detect_with(Refinement::stock, view, stock);
  }
  std::printf("%.0f px, tilt %.0f deg, blur %.1f px, noise %.0f\n", row.spec.side_px,
              row.spec.tilt_deg, row.spec.blur_px, row.spec.noise_levels);
  straight.print("straight", row);
  bent.print("bent", row);
  for (const auto& [name, errors] : {std::pair{"edges", &edges}, {"AprilTag", &stock}})
    std::printf("  %-8s %3d of %3d  rms %.4f  mean %+.4f %+.4f out %+.4f\n", name, errors->tags(),
                count, errors->rms(), errors->mean().x(), errors->mean().y(), errors->outwards());
}

struct NamedCamera {
  const char* name;
  Camera camera;
};

std::vector<NamedCamera> lens_cameras() {
  std::vector<NamedCamera> cameras;
  const ImageSize size{1280, 800};
  for (const auto& [name, k1] :
       {std::pair{"k1 -.40", -.4}, {"k1 -.25", -.25}, {"k1 0", 0.}, {"k1 +.20", .2}})
    cameras.push_back({name, {Perspective({900, 900, 652, 391, k1}), size}});
  cameras.push_back({"k1 -.4 k2 .2", {Perspective({900, 900, 652, 391, -.4, .2}), size}});
  cameras.push_back({"fisheye4", {Fisheye({400, 400, 652, 391, -.02, .004, -.002, 0}), size}});
  return cameras;
}

// Errors of fits of one kind, in pixels and in units of their own covariance.
class LensTally {
 public:
  void add(const TagView& view, const TagPattern& pattern, const Corners& start,
           const TagFitOptions& options) {
    const std::clock_t begin = std::clock();
    const TagFit fit = refine_tag(view.image, pattern, start, options);
    seconds_.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    if (fit.status != TagFitStatus::converged) return;
    errors_.add(fit.corners, view.corners);
    Eigen::Matrix<double, 8, 1> error;
    for (std::size_t k = 0; k < 4; ++k)
      error.segment<2>(2 * static_cast<Eigen::Index>(k)) = fit.corners[k] - view.corners[k];
    const double squares = error.dot(fit.covariance_px2.ldlt().solve(error)) / 8;
    nees_ += squares;
    worst_nees_ = std::max(worst_nees_, squares);
    predicted_ += fit.covariance_px2.trace() / 8;
    worst_px_ = std::max(worst_px_, error.cwiseAbs().maxCoeff());
    noise_ += fit.noise_levels;
    iterations_ += fit.iterations;
  }

  void print(const char* name) {
    const int n = errors_.tags();
    const auto middle = seconds_.begin() + static_cast<std::ptrdiff_t>(seconds_.size() / 2);
    std::nth_element(seconds_.begin(), middle, seconds_.end());
    std::printf(
        "  %-8s %3d of %3d  NEES/dim %6.3f (worst %6.2f)  rms %.4f  predicted/observed %.3f  mean "
        "%+.4f %+.4f out %+.4f  worst %.3f px  noise %.2f  %.1f steps  %.3f ms\n",
        name, n, static_cast<int>(seconds_.size()), nees_ / n, worst_nees_, errors_.rms(),
        std::sqrt(predicted_ / n) / errors_.rms(), errors_.mean().x(), errors_.mean().y(),
        errors_.outwards(), worst_px_, noise_ / n, iterations_ / n, 1e3 * *middle);
  }

 private:
  Errors errors_;
  double nees_ = 0, worst_nees_ = 0, predicted_ = 0, worst_px_ = 0, noise_ = 0, iterations_ = 0;
  std::vector<double> seconds_;
};

void run_lens(const NamedCamera& lens, int count, double only_side) {
  const TagFamily family = tag_family("tag36h11", 1);
  for (const double side : {15., 20., 30., 40., 60., 100., 160., 250.}) {
    if (only_side > 0 && side != only_side) continue;
    Random random(77);
    LensTally unknown, known;
    for (int i = 0; i < count; ++i) {
      const TagViewSpec spec{side, random.uniform(0, 50), random.uniform(.6, 1), 2};
      const TagView view = tag_through_lens(spec, lens.camera, random);
      const TagPattern pattern = tag_pattern(family, view.id, 1);
      Corners start = view.corners;
      for (Eigen::Vector2d& corner : start)
        corner += Eigen::Vector2d(random.uniform(-.3, .3), random.uniform(-.3, .3));
      unknown.add(view, pattern, start, {});
      TagFitOptions options;
      options.camera = &view.camera;
      known.add(view, pattern, start, options);
    }
    std::printf("%s, %.0f px\n", lens.name, side);
    unknown.print("unknown");
    known.print("known");
  }
}

// Processor time of the fastest of nine rounds, which other programs disturb least.
template <typename Work>
double processor_ms(const Work& work) {
  double best = 1e9;
  for (int i = 0; i < 9; ++i) {
    const std::clock_t begin = std::clock();
    for (int k = 0; k < 8; ++k) work();
    best = std::min(best, 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / 8);
  }
  return best;
}

double apriltag_ms(const Image8& image) {
  const FamilyHandle family = create_family("tag36h11", 1);
  const DetectorHandle detector(apriltag_detector_create());
  apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
  detector->nthreads = 1;
  detector->quad_decimate = 1;
  image_u8_t view = {image.width(), image.height(), image.width(),
                     const_cast<std::uint8_t*>(image.row(0))};
  return processor_ms(
      [&] { const DetectionsHandle found(apriltag_detector_detect(detector.get(), &view)); });
}

double corner_sub_pix_ms(const Image8& image, const Corners& start) {
  const cv::Mat view(image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0)));
  std::vector<cv::Point2f> corners;
  return processor_ms([&] {
    corners.clear();
    for (const Eigen::Vector2d& corner : start)
      corners.emplace_back(static_cast<float>(corner.x()), static_cast<float>(corner.y()));
    cv::cornerSubPix(view, corners, {5, 5}, {-1, -1},
                     {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 40, 1e-3});
  });
}

void run_speed(double side, int count) {
  enum { kStraight, kBent, kKnown, kSubPix, kAprilTag, kNum };
  std::array<double, kNum> ms{};
  Random random(9090);
  const TagFamily family = tag_family("tag36h11", 1);
  for (int i = 0; i < count; ++i) {
    const TagView view = rendered_tag({side, 30, .8, 2}, random);
    const TagPattern pattern = tag_pattern(family, view.id, 1);
    Corners start = view.corners;
    for (Eigen::Vector2d& corner : start)
      corner += Eigen::Vector2d(random.uniform(-.2, .2), random.uniform(-.2, .2));
    TagFitOptions known;
    known.camera = &view.camera;
    const auto fit_ms = [&](const TagFitOptions& options) {
      return processor_ms([&] { refine_tag(view.image, pattern, start, options); });
    };
    ms[kStraight] += fit_ms({0, 0, 12}) / count;
    ms[kBent] += fit_ms({}) / count;
    ms[kKnown] += fit_ms(known) / count;
    ms[kSubPix] += corner_sub_pix_ms(view.image, start) / count;
    ms[kAprilTag] += apriltag_ms(view.image) / count;
  }
  std::printf("%.0f px: AprilTag %.3f ms, cornerSubPix %.3f ms\n", side, ms[kAprilTag],
              ms[kSubPix]);
  for (const auto& [name, k] :
       {std::pair{"straight", kStraight}, {"bent", kBent}, {"known lens", kKnown}})
    std::printf("  %-10s %.3f ms  of AprilTag %.2f  of cornerSubPix %.2f\n", name, ms[k],
                ms[k] / ms[kAprilTag], ms[k] / ms[kSubPix]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "speed") {
    for (const double side : {20., 40., 80., 160., 250.})
      run_speed(side, argc > 2 ? std::atoi(argv[2]) : 20);
    return 0;
  }
  if (argc > 1 && std::string(argv[1]) == "lens") {
    const std::vector<NamedCamera> lenses = lens_cameras();
    const int only_lens = argc > 4 ? std::atoi(argv[4]) : -1;
    for (int i = 0; i < static_cast<int>(lenses.size()); ++i)
      if (only_lens < 0 || i == only_lens)
        run_lens(lenses[static_cast<std::size_t>(i)], argc > 2 ? std::atoi(argv[2]) : 200,
                 argc > 3 ? std::atof(argv[3]) : 0);
    return 0;
  }
  const int count = argc > 1 ? std::atoi(argv[1]) : 200;
  const int only = argc > 2 ? std::atoi(argv[2]) : -1;
  for (int i = 0; i < static_cast<int>(std::size(kRows)); ++i)
    if (only < 0 || i == only) run(kRows[i], count);
  return 0;
}
