#include "tagcal/io/calibration_file.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <opencv2/core.hpp>

#include "file_fixture.hpp"
#include "tagcal/uncertainty/projection_uncertainty.hpp"

namespace tagcal {
namespace {

const std::string kRos =
    "image_width: 640\nimage_height: 480\ncamera_name: front\n"
    "camera_matrix: {rows: 3, cols: 3, data: [600.0, 0.0, 320.0, 0.0, 601.0, 240.0, 0, 0, 1.0]}\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [-0.2, 0.05, 0.001, 0.002, 0.01]}\n"
    "projection_matrix: {rows: 3, cols: 4, data: [600, 0, 320, 0, 0, 600, 240, 0, 0, 0, 1, 0]}\n";

// The claim is by a model that contains the answer's.
Calibration example(const std::string& model, const Lens& lens) {
  Random random(9);
  const Model& claimed =
      Model::named(model == "opencv8" || model == "fisheye4" ? model : "opencv5");
  const int n = Model::named(model).num_free(), m = claimed.num_free();
  Calibration c;
  c.status = Status::ok;
  c.model = model;
  c.camera = Camera{lens, {1280, 800}};
  const Eigen::MatrixXd half = Eigen::MatrixXd::NullaryExpr(m, m, [&] { return random.normal(); });
  c.claim = UncertainCamera{&claimed, *c.camera, half * half.transpose() / 3};
  c.covariance = covariance_by(Model::named(model), *c.claim);
  c.sigmas.assign(parameters(lens).size(), 0.0);
  const Model& known = Model::named(model);
  for (int i = 0; i < n; ++i)
    for (const int k : known.free()[static_cast<std::size_t>(i)].lens_parameters)
      c.sigmas[static_cast<std::size_t>(k)] = std::sqrt(c.covariance(i, i));
  const std::vector<Eigen::Vector2d> hull = {{10.0 / 3, 20}, {1200, 30.5}, {1000, 700}, {90, 600}};
  c.seen = SeenRegion({1280, 800}, hull);
  ProjectionUncertainty far{kInfinitelyFar, {{1280, 800}, 3, 2}, Eigen::MatrixXd(2, 3), 0.1};
  far.sigma_px << 0.1 / 3, 0.2, 0.3, 0.4, 0.5, std::numeric_limits<double>::quiet_NaN();
  c.projection = {far, far};
  c.projection[1].distance_m = 1.25;
  c.rms_px = 1.0 / 7;
  c.sigma_px = 1.0 / 9;
  c.sigma_from_residuals = true;
  c.num_corners = 144;
  for (int i = 0; i < 3; ++i) {
    c.views.push_back(
        {"0" + std::to_string(i) + ".png", pose_of_many_sizes(random), {}, 48, {}, 0.1 * i});
  }
  c.outliers.push_back({"00.png", {1, 2}, 9});
  c.findings = {{"input", Severity::warning, "says \"this\": [and] {that} # \\ %"},
                {"input", Severity::note, "\xc3\xa9 - two"}};
  return c;
}

const std::vector<std::pair<std::string, Lens>>& examples() {
  static const std::vector<std::pair<std::string, Lens>> all = {
      {"f", pinhole(900.1 / 3, 900.1 / 3, 639.5, 399.5)},
      {"f+c", pinhole(900.1 / 3, 900.1 / 3, 641.0 / 3, 1e-17)},
      {"pinhole", pinhole(900.1 / 3, 901.0 / 7, 641.0 / 3, -3)},
      {"radial1", Perspective({300, 300, 1, 2, -0.1 / 3})},
      {"radial2", Perspective({300, 300, 1, 2, -0.1 / 3, 1e-300})},
      {"opencv4", Perspective({300, 301, 1, 2, -0.1 / 3, 0.02, 5e-4, -3e-4})},
      {"opencv5", Perspective({300, 301, 1, 2, -0.1 / 3, 0.02, 5e-4, -3e-4, 0.001})},
      {"opencv8", Perspective({300, 301, 1, 2, -0.1, 0.02, 5e-4, -3e-4, 0.01, 0.1, 0.2, 0.3})},
      {"fisheye4", Fisheye({300, 301, 1, 2, -0.1 / 3, 0.02, 5e-4, -3e-5})}};
  return all;
}

class CalibrationFileTest : public FileTest {
 protected:
  CalibrationFile read(const std::string& text) const {
    return read_calibration(write("c.yaml", text));
  }
  std::string error(const std::string& text) const {
    return error_about((folder_ / "c.yaml").string(), [&] { read(text); });
  }
  void expect_bad(const std::string& good, const std::vector<BadFile>& table) const {
    EXPECT_NO_THROW(read(good));
    for (const BadFile& bad : table)
      expect_line(error(replaced(good, bad.from, bad.to)), bad.message);
  }
};

TEST_F(CalibrationFileTest, ReadsBackToTheLastBit) {
  for (const auto& [model, lens] : examples()) {
    const Calibration written = example(model, lens);
    const CalibrationFile back = read(calibration_yaml(written));
    EXPECT_EQ(back.model, model);
    EXPECT_EQ(back.camera.image_size, written.camera->image_size);
    ASSERT_EQ(back.camera.lens.index(), lens.index());
    const auto a = parameters(back.camera.lens), b = parameters(lens);
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << model;
    EXPECT_EQ(back.sigmas, written.sigmas);
    EXPECT_EQ(back.covariance, written.covariance);
    EXPECT_EQ(back.claim_model, written.claim->model->name());
    EXPECT_EQ(back.claim_covariance, written.claim->covariance);
    const UncertainCamera claim = uncertain_camera(back);
    EXPECT_EQ(claim.model, written.claim->model);
    EXPECT_EQ(claim.covariance, written.claim->covariance);
    EXPECT_EQ(back.seen.hull(), written.seen.hull());
  }
}

TEST_F(CalibrationFileTest, OpenCVReadsEveryKey) {
  for (const auto& [model, lens] : examples()) {
    const Calibration c = example(model, lens);
    const cv::FileStorage file(write("c.yaml", calibration_yaml(c)).string(),
                               cv::FileStorage::READ);
    ASSERT_TRUE(file.isOpened());
    EXPECT_EQ(static_cast<int>(file["image_width"]), 1280);
    EXPECT_EQ(static_cast<int>(file["image_height"]), 800);
    EXPECT_EQ(static_cast<double>(file["avg_reprojection_error"]), 1.0 / 7);
    EXPECT_EQ(static_cast<std::string>(file["model"]), model);
    EXPECT_EQ(static_cast<std::string>(file["status"]), "ok");
    EXPECT_EQ(static_cast<double>(file["sigma_px"]), 1.0 / 9);
    EXPECT_EQ(static_cast<int>(file["num_outliers"]), 1);
    cv::Mat k, distortion, covariance, claim;
    file["camera_matrix"] >> k;
    file["distortion_coefficients"] >> distortion;
    file["covariance"] >> covariance;
    file["claim_covariance"] >> claim;
    const auto p = parameters(lens);
    const cv::Matx33d expected(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    ASSERT_EQ(k.size(), cv::Size(3, 3));
    ASSERT_EQ(k.type(), CV_64F);
    EXPECT_EQ(cv::norm(k, expected, cv::NORM_INF), 0);
    ASSERT_EQ(distortion.cols, model == "fisheye4" ? 4 : model == "opencv8" ? 8 : 5);
    for (int i = 0; i < distortion.cols; ++i) {
      EXPECT_EQ(distortion.at<double>(0, i), p[4 + static_cast<std::size_t>(i)]);
    }
    ASSERT_EQ(covariance.rows, c.covariance.rows());
    EXPECT_EQ(covariance.at<double>(covariance.rows - 1, 0), c.covariance(covariance.rows - 1, 0));
    const Eigen::MatrixXd& claimed = c.claim->covariance;
    EXPECT_EQ(static_cast<std::string>(file["claim_model"]), c.claim->model->name());
    ASSERT_EQ(claim.rows, claimed.rows());
    EXPECT_EQ(claim.at<double>(claim.rows - 1, 0), claimed(claimed.rows() - 1, 0));
    ASSERT_EQ(static_cast<int>(file["claim_names"].size()), claimed.rows());
    ASSERT_EQ(file["projection_uncertainty"].size(), 2U);
    EXPECT_TRUE(std::isinf(static_cast<double>(file["projection_uncertainty"][0]["distance_m"])));
    EXPECT_EQ(static_cast<double>(file["projection_uncertainty"][1]["distance_m"]), 1.25);
    cv::Mat sigma, region;
    file["projection_uncertainty"][1]["sigma_px"] >> sigma;
    file["seen_region"] >> region;
    ASSERT_EQ(sigma.size(), cv::Size(3, 2));
    EXPECT_EQ(sigma.at<double>(0, 0), 0.1 / 3);
    EXPECT_EQ(sigma.at<double>(1, 1), 0.5);
    EXPECT_TRUE(std::isnan(sigma.at<double>(1, 2)));
    ASSERT_EQ(region.size(), cv::Size(2, 4));
    ASSERT_EQ(file["views"].size(), 3U);
    const cv::FileNode view = file["views"][1];
    EXPECT_EQ(static_cast<std::string>(view["image"]), "01.png");
    EXPECT_EQ(static_cast<double>(view["rotation"][0]),
              c.views[1].camera_from_world.rotation().w());
    EXPECT_EQ(static_cast<double>(view["translation_m"][2]),
              c.views[1].camera_from_world.translation().z());
    ASSERT_EQ(file["warnings"].size(), 2U);
    EXPECT_EQ(static_cast<std::string>(file["warnings"][0]), c.findings[0].sentence);
    EXPECT_EQ(static_cast<std::string>(file["warnings"][1]), c.findings[1].sentence);
    const std::vector<Finding> found = read(calibration_yaml(c)).findings;
    ASSERT_EQ(found.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(found[i].code, c.findings[i].code);
      EXPECT_EQ(found[i].severity, c.findings[i].severity);
      EXPECT_EQ(found[i].sentence, c.findings[i].sentence);
    }
    ASSERT_EQ(static_cast<int>(file["covariance_names"].size()), Model::named(model).num_free());
    EXPECT_EQ(static_cast<std::string>(file["covariance_names"][0]),
              Model::named(model).free()[0].name);
  }
}

TEST_F(CalibrationFileTest, WithoutUncertaintyViewsOrWarnings) {
  Calibration c = example("opencv5", examples()[5].second);
  c.sigmas.clear();
  c.covariance.resize(0, 0);
  c.claim.reset();
  c.seen = SeenRegion();
  c.projection.clear();
  c.views.clear();
  c.findings.clear();
  const CalibrationFile back = read(calibration_yaml(c));
  EXPECT_TRUE(back.sigmas.empty());
  EXPECT_EQ(back.covariance.size(), 0);
  EXPECT_EQ(uncertain_camera(back).model, nullptr);
  const cv::FileStorage file((folder_ / "c.yaml").string(), cv::FileStorage::READ);
  EXPECT_EQ(file["views"].size(), 0U);
}

TEST_F(CalibrationFileTest, ReadsWhatOpenCVWrites) {
  const cv::Mat k = (cv::Mat_<double>(3, 3) << 600.1 / 3, 0, 320, 0, 601, 240, 0, 0, 1);
  for (const int n : {4, 5, 8, 12, 14}) {
    for (const std::string name : {"o.yaml", "o.json"}) {
      cv::Mat distortion = cv::Mat::zeros(n % 2 == 0 ? 1 : n, n % 2 == 0 ? n : 1, CV_64F);
      for (int i = 0; i < std::min(n, 8); ++i) distortion.at<double>(i) = 0.001 / (3 + i);
      {
        cv::FileStorage file((folder_ / name).string(), cv::FileStorage::WRITE);
        file << "calibration_time"
             << "today"
             << "image_width" << 640 << "image_height" << 480;
        file << "camera_matrix" << k << "distortion_coefficients" << distortion;
        file << "fisheye_model" << 0 << "avg_reprojection_error" << 0.2;
      }
      const CalibrationFile read = read_calibration(folder_ / name);
      EXPECT_EQ(read.model, "");
      ASSERT_TRUE(std::holds_alternative<Perspective>(read.camera.lens));
      const auto p = parameters(read.camera.lens);
      EXPECT_EQ(p[0], 600.1 / 3);
      EXPECT_EQ(p[3], 240);
      for (int i = 0; i < std::min(n, 8); ++i)
        EXPECT_EQ(p[4 + static_cast<std::size_t>(i)], distortion.at<double>(i));
    }
  }
}

TEST_F(CalibrationFileTest, OthersMarkAFisheyeTheirWay) {
  const std::string four = replaced(kRos, "cols: 5, data: [-0.2, 0.05, 0.001, 0.002, 0.01]",
                                    "cols: 4, data: [-0.02, 0.005, 0.001, 0.002]");
  EXPECT_TRUE(std::holds_alternative<Perspective>(read(kRos).camera.lens));
  EXPECT_TRUE(std::holds_alternative<Perspective>(read(four).camera.lens));
  EXPECT_TRUE(std::holds_alternative<Fisheye>(
      read(replaced(four, "plumb_bob", "equidistant")).camera.lens));
  EXPECT_TRUE(std::holds_alternative<Fisheye>(read(four + "fisheye_model: 1\n").camera.lens));
  EXPECT_EQ(error(kRos + "fisheye_model: 1\n"),
            ": distortion_coefficients: must have the 4 coefficients of a fisheye lens, got 5");
}

TEST_F(CalibrationFileTest, BadFilesOfOthers) {
  expect_bad(
      kRos,
      {{"image_width: 640\n", "", ": image_width: the key is missing"},
       {"image_width: 640", "image_width: 0", ": image_width: must be a whole number from 1 to"},
       {"image_width: 640", "image_width: 640.5",
        ": image_width: must be a whole number from 1 to"},
       {"camera_matrix", "K", ": camera_matrix: the key is missing"},
       {"distortion_coefficients", "D", ": distortion_coefficients: the key is missing"},
       {"rows: 3, cols: 3", "rows: 3, cols: 2", ": camera_matrix.data: must be a list of 6, got a"},
       {"rows: 3, cols: 3", "rows: 1, cols: 9", ": camera_matrix: must be 3 x 3, got 1 x 9"},
       {"rows: 3, cols: 3", "cols: 3", ": camera_matrix.rows: the key is missing"},
       {"rows: 3, cols: 3", "rows: -3, cols: 3", ": camera_matrix.rows: must be a whole number"},
       {"[600.0", "[.Nan", ": camera_matrix.data[0]: must be a finite number, got .Nan"},
       {"[600.0", "[-.Inf", ": camera_matrix.data[0]: must be a finite number, got -.Inf"},
       {"[600.0", "[0", ": camera_matrix: fx: must be > 0, got 0"},
       {"601.0", "-601.0", ": camera_matrix: fy: must be > 0, got -601"},
       {"[600.0, 0.0", "[600.0, 0.1", ": camera_matrix: the skew must be 0, got 0.1"},
       {"0, 0, 1.0]", "0, 0, 2.0]", ": camera_matrix: must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]"},
       {"rows: 3, cols: 3, data", "rows: 3, cols: 3, dat", ": camera_matrix.data: the key is miss"},
       {"cols: 5, data: [-0.2,", "cols: 6, data: [-0.2, 1,",
        ": distortion_coefficients: must have"},
       {"rows: 1, cols: 5", "rows: 5, cols: 0", ": distortion_coefficients.cols: must be a whole"},
       {"-0.2, 0.05", "-0.2, x",
        ": distortion_coefficients.data[1]: must be a finite number, got x"},
       {"cols: 5, data: [-0.2", "cols: 12, data: [1, 2, 3, 4, 5, 6, 7, 8",
        ": distortion_coefficients: coefficient 9 (thin prism, tilt) must be 0"},
       {"plumb_bob", "fov", ": distortion_model: must be plumb_bob, rational_polynomial or equid"},
       {"camera_name: front", "image_width: 640",
        ": line 3: image_width: the key is given twice"}});
  EXPECT_EQ(error("[1, 2]"), ": must be a map of keys, got a list of 2");
  EXPECT_EQ(error("%YAML:1.0\n---\n"), ": must be a map of keys, got nothing");
}

TEST_F(CalibrationFileTest, BadFilesOfOurs) {
  const std::string good = calibration_yaml(example("radial1", examples()[3].second));
  expect_bad(
      good,
      {{"model: \"radial1\"", "model: \"radial\"",
        ": model: must be one of f, f+c, pinhole, radial"},
       {"model: \"radial1\"", "model: weak",
        ": model: must be one of f, f+c, pinhole, radial1, ra"},
       {"model: \"radial1\"", "model: f", ": cx must be 639.5 with model f, got 1"},
       {"model: \"radial1\"", "model: f+c", ": k1 must be 0 with model f+c, got -0.0333"},
       {"model: \"radial1\"", "model: radial2",
        ": covariance: must be 5 x 5 with model radial2, g"},
       {"model: \"radial1\"", "mode: 1", ": covariance: needs the key model, which is missing"},
       {"model: \"radial1\"", "model: fisheye4",
        ": distortion_coefficients: must have the 4 coeff"},
       {"data: [ 300", "data: [ 301",
        ": fx and fy must be equal with model radial1, got 301 and 3"},
       {"cols: 12", "cols: 11", ": sigmas.data: must be a list of 11, got a list of 12"},
       {"rows: 1\n   cols: 12", "rows: 2\n   cols: 6",
        ": sigmas: must have one row or one column, "},
       {"rows: 4\n   cols: 4", "rows: 1\n   cols: 16",
        ": covariance: must be 4 x 4 with model rad"}});
  EXPECT_EQ(error(replaced(good, "seen_region: !!opencv-matrix\n   rows: 4\n   cols: 2",
                           "seen_region: !!opencv-matrix\n   rows: 2\n   cols: 4")),
            ": seen_region: must be 3 or more x 2, got 2 x 4");
  std::string negative = good.substr(0, good.find("sigmas:"));
  negative += replaced(good.substr(good.find("sigmas:")), "data: [ ", "data: [ -");
  EXPECT_EQ(error(negative).substr(0, 27), ": sigmas: must be >= 0, got");
}

RC_GTEST_FIXTURE_PROP(CalibrationFileTest, ManglesEndInAnErrorOrAValidCamera,
                      (std::uint64_t seed)) {
  Random random(seed);
  const std::string ours = calibration_yaml(example("opencv5", examples()[5].second));
  for (const std::string& good : {kRos, ours, ours}) {
    try {
      const CalibrationFile file = read(mutated(good, random));
      for (const double p : parameters(file.camera.lens)) RC_ASSERT(std::isfinite(p));
      RC_ASSERT(parameters(file.camera.lens)[0] > 0 && file.camera.image_size.width > 0);
      RC_ASSERT(file.covariance.allFinite() && file.claim_covariance.allFinite());
      RC_ASSERT((uncertain_camera(file).model != nullptr) == (file.covariance.size() > 0));
    } catch (const Error& error) {
      RC_ASSERT(std::string(error.what()).find("c.yaml: ") != std::string::npos);
    }
  }
}

}  // namespace
}  // namespace tagcal
