#include "tagcal/estimate/lens_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tagcal/error.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

const ImageSize kFittedSize{1280, 800};

LensFitSource source_of(const Lens& lens, const ImageSize& size = kFittedSize) {
  return {{lens, size}, {}, {}, {}};
}

LensFit fitted(const Lens& lens, const char* model) {
  return fit_lens(source_of(lens), Model::named(model));
}

SeenRegion disc(const ImageSize& size, double radius) {
  std::vector<Vector2d> pixels;
  for (int i = 0; i < 72; ++i)
    pixels.emplace_back(image_centre(size) +
                        radius * Vector2d(std::cos(i * std::numbers::pi / 36),
                                          std::sin(i * std::numbers::pi / 36)));
  return SeenRegion(size, pixels);
}

// Camera 0 of TUM-VI at 512 x 512: as Basalt gives it, and as the data set's page does, from
// another calibration of the same camera (Schubert et al., The TUM VI Benchmark, IROS 2018).
const DoubleSphere kTumSphere({158.28600034966977, 158.2743455478755, 254.96116578191653,
                               256.8894394501779, -0.17213086034353243, 0.5931177593944744});
const Fisheye kTumFisheye({190.97847715128717, 190.9733070521226, 254.93170605935475,
                           256.8974428996504, 0.0034823894022493434, 0.0007150348452162257,
                           -0.0020532361418706202, 0.00020293673591811182});

// A rational lens of 70 degrees.
const Perspective kRational({900, 901, 651, 392, 0.05, 0.02, 0, 0, 0.001, 0.2, 0.03, 0});

TEST(LensFit, NestedModelsAreExact) {
  const std::vector<std::tuple<const char*, Lens, const char*>> cases = {
      {"f", pinhole(900, 900, 639.5, 399.5), "opencv8"},
      {"f+c", pinhole(900, 900, 651, 392), "opencv5"},
      {"pinhole", pinhole(900, 898, 651, 392), "opencv4"},
      {"radial1", Perspective({900, 900, 651, 392, -0.2}), "radial2"},
      {"radial2", Perspective({900, 900, 651, 392, -0.2, 0.05}), "opencv4"},
      {"opencv4", opencv5_lens(), "opencv5"},
      {"opencv4", opencv5_lens(), "opencv8"},
      {"opencv8", kRational, "opencv8"},
      {"fisheye4", fisheye_lens(), "fisheye4"}};
  for (const auto& [name, lens, larger] : cases) {
    const LensFit fit = fitted(lens, larger);
    EXPECT_FALSE(fit.refusal) << name;
    EXPECT_LT(fit.image.max_px, 1e-9) << name << " " << larger;
    EXPECT_EQ(fit.image.share_without, 0);
    for (std::size_t i = 0; i < parameters(lens).size(); ++i)
      EXPECT_NEAR(parameters(fit.camera.lens)[i], parameters(lens)[i], 1e-9) << name << " " << i;
    EXPECT_EQ(fit.camera.image_size, kFittedSize);
    EXPECT_EQ(fit.covariance.size(), 0);
    EXPECT_TRUE(fit.sigmas.empty());
  }
}

// Unified lenses with alpha = 0 are pinholes: no start is at the answer.
TEST(LensFit, FindsALensFromAnotherType) {
  const LensFit pin = fitted(ExtendedUnified({900, 898, 651, 392, 0, 1}), "opencv5");
  EXPECT_LT(pin.image.max_px, 1e-6);
  EXPECT_NEAR(parameters(pin.camera.lens)[0], 900, 1e-6);
  EXPECT_NEAR(parameters(pin.camera.lens)[1], 898, 1e-6);

  const LensFit sphere = fit_lens(source_of(kTumSphere, {512, 512}), Model::named("fisheye4"));
  EXPECT_FALSE(sphere.refusal);
  EXPECT_LT(sphere.image.max_px, 0.02);
  EXPECT_LT(sphere.image.rms_px, 0.001);

  LensFitSource part = source_of(ExtendedUnified({600, 600, 640, 392, 0.57, 1.1}));
  for (const char* model : {"fisheye4", "opencv8"}) {
    const LensFit fit = fit_lens(part, Model::named(model));
    EXPECT_FALSE(fit.refusal) << fit.refusal.value_or("");
    EXPECT_LT(fit.seen.max_px, 0.02) << model;
  }

  const LensFit rational = fitted(kRational, "fisheye4");
  EXPECT_FALSE(rational.refusal) << rational.refusal.value_or("");
  EXPECT_LT(rational.image.max_px, 0.1);
  EXPECT_GT(rational.image.max_px, 1e-6);
}

// The published lenses of one camera differ in scale by 0.1 %; the fit keeps to its source.
TEST(LensFit, DoubleSphereOfTumViIsItsPublishedFisheye) {
  LensFitSource source = source_of(kTumSphere, {512, 512});
  source.seen = disc(source.camera.image_size, 250);
  const LensFit fit = fit_lens(source, Model::named("fisheye4"));
  EXPECT_LT(fit.seen.max_px, 0.001);
  const auto p = parameters(fit.camera.lens);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(p[i] / kTumFisheye.parameters()[i], 1, 2e-3);
  for (int i = 2; i < 4; ++i) EXPECT_NEAR(p[i], kTumFisheye.parameters()[i], 0.05);
  for (const double radius : {0.0, 60.0, 120.0, 180.0, 240.0}) {
    const Vector2d pixel(254.96 + radius, 256.89);
    const Vector3d ray = kTumFisheye.ray_in_camera(pixel)->direction;
    EXPECT_LT((*project(fit.camera.lens, ray) - *kTumSphere.project(ray)).norm(), 1e-3);
    EXPECT_LT((*project(fit.camera.lens, ray) - pixel).norm(), 0.1 + 0.0025 * radius);
  }
}

TEST(LensFit, RefusesALensThatTheModelDoesNotDescribe) {
  const LensFit wide = fitted(fisheye_lens(), "opencv5");
  ASSERT_TRUE(wide.refusal);
  EXPECT_NE(wide.refusal->find("model opencv5 has no projection for "), std::string::npos);
  EXPECT_GT(wide.image.share_without, 0.01);
  EXPECT_TRUE(std::isinf(wide.difference_px(0, 0)));

  const LensFit small = fitted(opencv5_lens(), "f+c");
  ASSERT_TRUE(small.refusal);
  EXPECT_NE(small.refusal->find("model f+c differs from the lens by up to "), std::string::npos);
  EXPECT_NE(small.refusal->find("over the image, more than 0.1 px"), std::string::npos);
  EXPECT_GT(small.image.max_px, 5);
  EXPECT_LE(small.image.rms_px, small.image.max_px);
  EXPECT_NEAR(small.difference_px.maxCoeff(), small.image.max_px, 0.05 * small.image.max_px);
  LensFitOptions generous;
  generous.max_difference_px = 100;
  EXPECT_FALSE(fit_lens(source_of(opencv5_lens()), Model::named("f+c"), generous).refusal);

  // In the middle of the image the same model is good enough, and the whole image tells.
  LensFitSource middle = source_of(Perspective({900, 900, 651, 392, -0.15, 0.05}));
  middle.seen = disc(kFittedSize, 150);
  const LensFit part = fit_lens(middle, Model::named("radial1"));
  EXPECT_FALSE(part.refusal) << part.refusal.value_or("");
  EXPECT_LT(part.seen.max_px, 0.1);
  EXPECT_GT(part.image.max_px, 1);
}

TEST(LensFit, PixelsWithoutARayDoNotCount) {
  const LensFit fit = fitted(DoubleSphere({158, 158, 639.5, 399.5, -0.17, 0.6}), "fisheye4");
  EXPECT_TRUE(std::isnan(fit.difference_px(0, 0)));
  EXPECT_LT(fit.image.max_px, 1000);
  EXPECT_EQ(fit.difference_px.rows(), fit.grid.rows);
  EXPECT_EQ(fit.difference_px.cols(), fit.grid.columns);
}

std::string error_of(const LensFitSource& source, const char* model,
                     const LensFitOptions& options = {}) {
  try {
    fit_lens(source, Model::named(model), options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(LensFit, BadInput) {
  EXPECT_NE(error_of(source_of(opencv5_lens()), "weak").find("parallel"), std::string::npos);
  EXPECT_NE(error_of(source_of(Parallel({1, 1, 0, 0, 0, 0})), "f").find("parallel"),
            std::string::npos);
  EXPECT_NE(error_of(source_of(opencv5_lens()), "f", {-1}).find("max_diff"), std::string::npos);
  EXPECT_NE(error_of(source_of(opencv5_lens(), {0, 0}), "f").find("image_size"), std::string::npos);
  LensFitSource source = source_of(opencv5_lens());
  source.covariance = MatrixXd::Identity(8, 8);
  EXPECT_NE(error_of(source, "f").find("covariance"), std::string::npos);
}

// opencv4 with a covariance, seen in the middle of its image.
LensFitSource uncertain_source() {
  LensFitSource source = source_of(Perspective({900, 898, 651, 392, -0.1, 0.03}));
  source.seen = disc(kFittedSize, 380);
  source.free = free_parameters("opencv4", {});
  const VectorXd sd = (VectorXd(8) << 0.8, 0.8, 0.5, 0.5, 1e-3, 4e-3, 1e-4, 1e-4).finished();
  MatrixXd correlation = MatrixXd::Identity(8, 8);
  correlation(0, 1) = correlation(1, 0) = 0.9;
  correlation(4, 5) = correlation(5, 4) = -0.8;
  source.covariance = sd.asDiagonal() * correlation * sd.asDiagonal();
  return source;
}

TEST(LensFit, CovarianceOfALargerModelIsThatOfTheSource) {
  const LensFitSource source = uncertain_source();
  const LensFit fit = fit_lens(source, Model::named("opencv5"));
  ASSERT_EQ(fit.covariance.rows(), 9);
  const VectorXd sd = source.covariance.diagonal().cwiseSqrt();
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      EXPECT_NEAR(fit.covariance(i, j), source.covariance(i, j), 1e-7 * sd[i] * sd[j]);
  EXPECT_EQ(fit.sigmas[8], 0);  // k3 is zero in every lens of the source
  // k1 and k4 of a rational lens without distortion project alike.
  const LensFit rational = fit_lens(source, Model::named("opencv8"));
  EXPECT_NEAR(rational.sigmas[4], 1e-3, 1e-9);
  EXPECT_EQ(rational.sigmas[9], 0);
  EXPECT_NEAR(fit.sigmas[0], 0.8, 1e-6);

  // What the source holds is held.
  LensFitSource held = source;
  held.free = free_parameters("opencv4", {{"cx", 651}, {"cy", 392}});
  held.covariance = MatrixXd::Identity(6, 6) * 1e-6;
  const LensFit of_held = fit_lens(held, Model::named("opencv4"));
  EXPECT_LT(of_held.sigmas[2], 1e-6);
  EXPECT_NEAR(of_held.sigmas[4], 1e-3, 1e-8);
}

// Lenses drawn from the source's distribution, each fitted, scatter as the carried covariance says.
TEST(LensFit, CovarianceAgreesWithMonteCarlo) {
  const LensFitSource source = uncertain_source();
  const Model& model = Model::named("fisheye4");
  const LensFit fit = fit_lens(source, model);
  ASSERT_FALSE(fit.refusal) << *fit.refusal;
  const MatrixXd root = MatrixXd(source.covariance).llt().matrixL();
  const auto mean = model.free_values(fit.camera.lens);
  Random random(7);
  constexpr int kDraws = 120;
  MatrixXd sum = MatrixXd::Zero(8, 8);
  for (int i = 0; i < kDraws; ++i) {
    VectorXd z(8);
    for (double& value : z) value = random.normal();
    const VectorXd step = root * z;
    Perspective::Parameters p = std::get<Perspective>(source.camera.lens).parameters();
    for (int k = 0; k < 8; ++k) p[k] += step[k];
    LensFitSource drawn = source_of(Perspective(p));
    drawn.seen = source.seen;
    const auto values = model.free_values(fit_lens(drawn, model).camera.lens);
    VectorXd d(8);
    for (int k = 0; k < 8; ++k) d[k] = values[k] - mean[k];
    sum += d * d.transpose() / kDraws;
  }
  for (int k = 0; k < 8; ++k)
    EXPECT_NEAR(std::sqrt(sum(k, k) / fit.covariance(k, k)), 1, 0.25) << k;
  // The focal lengths are as correlated as those of the source.
  const double correlation = sum(0, 1) / std::sqrt(sum(0, 0) * sum(1, 1));
  EXPECT_NEAR(correlation,
              fit.covariance(0, 1) / std::sqrt(fit.covariance(0, 0) * fit.covariance(1, 1)), 0.1);
}

}  // namespace
}  // namespace tagcal
