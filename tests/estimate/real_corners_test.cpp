// Corners of real cameras, collected by others (tests/data/real_corners,
// docs/trust/real_corners.md), against the answers that others published and against mrcal's on the
// same corners.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/core/persistence.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calibrations.hpp"
#include "tagcal/estimate/advice.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/io/calibration_file.hpp"
#include "tagcal/io/dataset_file.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"

namespace tagcal {
namespace {

std::filesystem::path folder(const std::string& set) {
  return std::filesystem::path(TAGCAL_SOURCE_DIR) / "tests/data/real_corners" / set;
}

Calibration calibrated(const std::string& set, const CalibrateOptions& options) {
  return calibrate(read_dataset(folder(set)).dataset, options);
}

// The same by a model's name, made once.
const Calibration& calibrated(const std::string& set, const std::string& model) {
  static std::map<std::pair<std::string, std::string>, Calibration> made;
  const auto [at, is_new] = made.try_emplace({set, model});
  if (is_new) {
    CalibrateOptions options;
    options.model = model;
    at->second = calibrated(set, options);
  }
  return at->second;
}

Camera answer(const std::string& set, const std::string& file) {
  return read_calibration(folder(set) / file).camera;
}

// RMS over the region that the corners of `ours` cover; a huge number where there is none.
double difference_px(const Camera& theirs, const Calibration& ours, double distance_m) {
  const auto d = lens_difference(theirs, *ours.camera, ours.seen.samples(), distance_m);
  return d ? d->rms_px : 1e9;
}

// Of the length of a difference, where `projection` gives it per coordinate.
double predicted_px(const Calibration& c) {
  return std::sqrt(2.0) * c.projection.front().region_px;
}

const std::vector<std::string>& real_sets() {
  static const std::vector<std::string> names = {"bouguet_left", "bouguet_right", "opencv_left",
                                                 "euroc_cam0", "visp_circles"};
  return names;
}

// mrcal's own standard deviation of the projection at infinity (`rms-stdev`, per coordinate, RMS
// over the corners), beside its answer.
double mrcal_sigma_px(const std::string& set) {
  const std::string file = folder(set) / "mrcal.yaml";
  return cv::FileStorage(file, cv::FileStorage::READ)["projection_sd_px"].real();
}

TEST(RealCorners, SameCornersGiveTheAnswerOfMrcal) {
  for (const std::string& set : real_sets()) {
    const Calibration& c = calibrated(set, "opencv5");
    ASSERT_EQ(c.status, Status::ok) << set;
    // mrcal's answers here are of flat boards, ours has the board's shape and row terms.
    EXPECT_LT(difference_px(answer(set, "mrcal.yaml"), c, kInfinitelyFar), 2 * predicted_px(c))
        << set;
    // Ours counts what the views share and what the board may be; mrcal's does not.
    EXPECT_GT(mrcal_sigma_px(set), 0) << set;
    EXPECT_GT(c.projection.front().region_px, 0.9 * mrcal_sigma_px(set)) << set;
  }
}

// Where neither drops a corner, f and c too: half a pixel in the convention would show.
TEST(RealCorners, SameCornersGiveTheParametersOfMrcal) {
  for (const std::string set : {"bouguet_left", "bouguet_right"}) {
    const Calibration& c = calibrated(set, "opencv5");
    EXPECT_TRUE(c.outliers.empty()) << set;
    const Camera camera = answer(set, "mrcal.yaml");
    const auto mrcal = parameters(camera.lens);
    const auto ours = parameters(c.camera->lens);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT(std::abs(ours[i] - mrcal[i]), c.sigmas[i]) << set << " " << i;
  }
}

// Bouguet's toolbox and ViSP found their own corners in the same pictures: two deviations of ours.
TEST(RealCorners, PublishedAnswersAreMetWithinTwoDeviations) {
  for (const std::string set : {"bouguet_left", "bouguet_right", "visp_circles"}) {
    const Calibration& c = calibrated(set, "opencv5");
    ASSERT_EQ(c.status, Status::ok) << set;
    EXPECT_LT(difference_px(answer(set, "published.yaml"), c, kInfinitelyFar), 2 * predicted_px(c))
        << set;
  }
}

TEST(RealCorners, BouguetsFocalLengthAndCentreAreMetWithinThreeSigma) {
  for (const std::string set : {"bouguet_left", "bouguet_right"}) {
    const Calibration& c = calibrated(set, "opencv5");
    const Camera camera = answer(set, "published.yaml");
    const auto published = parameters(camera.lens);
    const auto ours = parameters(c.camera->lens);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT(std::abs(ours[i] - published[i]), 3 * c.sigmas[i]) << set << " " << i;
  }
}

// OpenCV's sample refines corners in a window that at left02 reaches the next ones: some are wrong
// by up to 6 px, and its published answer stands on them.
TEST(RealCorners, WrongCornersAreFoundAndWithThemOpencvsAnswer) {
  CalibrateOptions keep = with_model("opencv5");
  keep.reject_outliers = false;
  const Calibration all = calibrated("opencv_left", keep);
  EXPECT_LT(difference_px(answer("opencv_left", "published.yaml"), all, kInfinitelyFar),
            2 * predicted_px(all));

  const Calibration& robust = calibrated("opencv_left", "opencv5");
  EXPECT_LT(difference_px(answer("bouguet_left", "published.yaml"), robust, kInfinitelyFar),
            2 * predicted_px(robust));
  EXPECT_GT(difference_px(answer("bouguet_left", "published.yaml"), all, kInfinitelyFar),
            5 * difference_px(answer("bouguet_left", "published.yaml"), robust, kInfinitelyFar));
  EXPECT_LE(robust.outliers.size(), 25u);
  for (const int id : {0, 9, 18, 27, 45})
    EXPECT_TRUE(std::any_of(robust.outliers.begin(), robust.outliers.end(), [&](const Outlier& o) {
      return o.image == "left02.jpg" && o.id.tag_id == id && o.residual_px > 3;
    })) << id;
}

// The published answer stands on other views, ours on nine of a board that is not flat: the same
// corners bring mrcal as far from it.
TEST(RealCorners, EurocIsAsNearToThePublishedAnswerAsMrcal) {
  const Calibration& c = calibrated("euroc_cam0", "opencv5");
  const Camera published = answer("euroc_cam0", "published.yaml");
  Calibration mrcal = c;
  mrcal.camera = answer("euroc_cam0", "mrcal.yaml");
  for (const double distance_m : {kInfinitelyFar, 1.0})
    EXPECT_LT(difference_px(published, c, distance_m),
              difference_px(published, mrcal, distance_m) + 0.05)
        << distance_m;
  for (const Outlier& o : c.outliers) EXPECT_LT(o.residual_px, 1) << o.image << " " << o.id.tag_id;
}

TEST(RealCorners, EurocsBoardIsBentAsMrcalFindsIt) {
  const Calibration& c = calibrated("euroc_cam0", "opencv5");
  ASSERT_TRUE(c.board_warp.has_value());
  const Eigen::Vector2d mrcal_mm(0.89042, 0.19494);  // calobject_warp
  for (int i = 0; i < 2; ++i)
    EXPECT_LT(std::abs(c.board_warp->bend_mm[i] - mrcal_mm[i]), 2 * c.board_warp->sigma_mm[i]) << i;
}

// A rational lens explains some of these corners a little better, and has a pole in the image.
TEST(RealCorners, AutoTakesNoLensWithAPoleInTheImage) {
  for (const std::string& set : real_sets()) {
    const Calibration& c = calibrated(set, "auto");
    ASSERT_EQ(c.status, Status::ok) << set;
    EXPECT_FALSE(has_pole(*c.camera)) << set;
    // The answer by name is within what is claimed.
    const Calibration& named = calibrated(set, "opencv5");
    const double difference =
        std::abs(parameters(c.camera->lens)[0] - parameters(named.camera->lens)[0]);
    EXPECT_LT(difference, 3 * std::hypot(c.sigmas[0], named.sigmas[0])) << set;
  }
}

bool warns(const Calibration& c, const std::string& text) {
  return std::any_of(c.findings.begin(), c.findings.end(), [&](const Finding& finding) {
    const std::string& warning = finding.sentence;
    return warning.find(text) != std::string::npos;
  });
}

// A lens without distortion is said to be too small, unless its focal length is refused.
TEST(RealCorners, AModelThatIsTooSmallIsSaid) {
  for (const std::string& set : real_sets()) {
    for (const std::string model : {"f", "pinhole"}) {
      const Calibration& c = calibrated(set, model);
      EXPECT_TRUE(!is_answer(c.status) || warns(c, "the model underfits: opencv5")) << set;
    }
    EXPECT_FALSE(warns(calibrated(set, "opencv5"), "too small: opencv5")) << set;
  }
}

// Printed on paper: tenths of a millimetre, a tenth of a pixel.
TEST(RealCorners, TheTargetsAreAsTheirFilesSay) {
  for (const std::string& set : real_sets())
    for (const std::string model : {"opencv5", "auto"})
      EXPECT_FALSE(warns(calibrated(set, model), "target is not as its file says")) << set << model;
  // The corners of Kalibr's detector make all tags of EuRoC's board look a little too small.
  EXPECT_TRUE(warns(calibrated("euroc_cam0", "opencv5"), "all tags look"));
}

TEST(RealCorners, GapsAreOneWarning) {
  const Calibration& c = calibrated("euroc_cam0", "opencv5");
  EXPECT_TRUE(warns(c, "no corners in the lower left, upper right and lower right corners of"));
  EXPECT_EQ(std::count_if(c.findings.begin(), c.findings.end(),
                          [](const Finding& f) { return f.sentence.find("no corners in") == 0; }),
            1);
}

TEST(RealCorners, TheAdvisedViewFillsTheGaps) {
  for (const std::string& set : real_sets()) {
    const Calibration& c = calibrated(set, "opencv5");
    const auto view = advise(read_dataset(folder(set)).dataset, c);
    ASSERT_TRUE(view.has_value()) << set;
    EXPECT_EQ(view->fills, c.seen.missing_parts()) << set;
    EXPECT_NE(view->sentence.find("which covers the " + view->fills.at(0)), std::string::npos)
        << view->sentence;
  }
}

// Paper is not flat: with its shape the answer is nearer to the published one than that of a flat
// board. (Not so where the noise decides: docs/trust/real_corners.md.)
TEST(RealCorners, TheShapeBringsTheAnswerNearer) {
  for (const std::string set : {"bouguet_left", "euroc_cam0"}) {
    const Camera published = answer(set, "published.yaml");
    const Calibration& c = calibrated(set, "opencv5");
    Calibration flat = c;
    flat.camera = answer(set, "mrcal.yaml");
    EXPECT_LT(difference_px(published, c, kInfinitelyFar),
              0.9 * difference_px(published, flat, kInfinitelyFar))
        << set;
  }
}

// The bend belongs to the model that was chosen, not to the largest one that was tried on the way.
TEST(RealCorners, AutoBendsTheBoardAsTheModelThatItChooses) {
  for (const std::string& set : real_sets()) {
    const Calibration& chosen = calibrated(set, "auto");
    const Calibration& asked = calibrated(set, chosen.model);
    ASSERT_TRUE(chosen.board_warp && asked.board_warp) << set;
    EXPECT_FALSE(chosen.steps.empty()) << set;
    // The row terms' prior and the noise that weighs the priors are those of the posterior's model,
    // which may be a larger one.
    const Eigen::Vector2d sigma_mm = asked.board_warp->sigma_mm;
    EXPECT_LT((chosen.board_warp->bend_mm - asked.board_warp->bend_mm).norm(),
              5e-2 * sigma_mm.minCoeff())
        << set;
    EXPECT_LT(difference_px(*asked.camera, chosen, kInfinitelyFar),
              5e-2 * asked.projection.front().region_px)
        << set;
  }
}

// Over the whole image a turn takes some points at its corners out of what the other lens sees.
TEST(RealCorners, AnswersOfOthersCompareInBothOrders) {
  const Camera published = answer("euroc_cam0", "published.yaml");
  const Camera mrcal = answer("euroc_cam0", "mrcal.yaml");
  const auto samples = ImageGrid{published.image_size, 33, 21}.pixels();
  for (const double distance_m : {kInfinitelyFar, 1.0}) {
    const auto there = lens_difference(published, mrcal, samples, distance_m);
    const auto back = lens_difference(mrcal, published, samples, distance_m);
    ASSERT_TRUE(there && back) << distance_m;
    EXPECT_TRUE(std::isfinite(there->rms_px) && std::isfinite(back->rms_px)) << distance_m;
    // Where the lenses are of use, the one turn undoes the other.
    EXPECT_LT(log_rotation((there->b_from_a * back->b_from_a).rotation()).norm(), 0.002);
  }
}

// Whatever model is chosen: at the board's distance it projects as mrcal's answer does, and a real
// lens gets its distortion.
TEST(RealCorners, AutoChoosesALensThatProjectsAlike) {
  for (const std::string& set : real_sets()) {
    const Calibration& c = calibrated(set, "auto");
    ASSERT_EQ(c.status, Status::ok) << set;
    const double distance_m = c.projection.back().distance_m;
    EXPECT_LT(difference_px(answer(set, "mrcal.yaml"), c, distance_m),
              std::max(0.1, 2 * std::sqrt(2.0) * c.projection.back().region_px))
        << set << " " << c.model;
    for (const std::string poor : {"f", "f+c", "pinhole"}) EXPECT_NE(c.model, poor) << set;
  }
}

}  // namespace
}  // namespace tagcal
