// Repeated calibrations of one camera: false alarms, and what is found.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <map>

#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/fleet.hpp"
#include "tagcal/uncertainty/lens_difference.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

constexpr ImageSize kHistorySize{1280, 800};

const std::vector<Eigen::Vector2d>& samples() {
  static const std::vector<Eigen::Vector2d> pixels = ImageGrid{kHistorySize, 33, 21}.pixels();
  return pixels;
}

const MatrixX& covariance_of(const std::string& model) {
  static std::map<std::string, MatrixX> all;
  const auto found = all.find(model);
  if (found != all.end()) return found->second;
  CalibrateOptions options;
  options.model = model;
  const Lens lens = model == "f" ? centred_pinhole(900) : opencv5_lens();
  return all[model] =
             covariance_by(Model::named(model), *calibrate(make_world(lens, 1), options).claim);
}

struct HistoryWorld {
  std::string model = "opencv5";
  int count = 10;
  double scatter = 1;  // over the covariances, as sd
  std::function<void(double key, std::vector<double>& values)> change = nullptr;  // of the lens
};

// Calibrations of one camera at the keys 0, 1, .., each with an error of its own covariance.
std::vector<UncertainCamera> calibrations_of(const HistoryWorld& world, Random& random) {
  const Model& model = Model::named(world.model);
  const MatrixX& usual = covariance_of(world.model);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen{Eigen::MatrixXd(usual)};
  std::vector<UncertainCamera> all;
  for (int k = 0; k < world.count; ++k) {
    const double share = random.uniform(0.5, 2);  // of its variance
    std::vector<double> values =
        model.free_values(world.model == "f" ? centred_pinhole(900) : opencv5_lens());
    if (world.change) world.change(k, values);
    Eigen::VectorXd error(model.num_free());
    for (Eigen::Index i = 0; i < error.size(); ++i)
      error[i] = world.scatter * std::sqrt(share * std::max(0.0, eigen.eigenvalues()[i])) *
                 random.normal();
    error = eigen.eigenvectors() * error;
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] += error[static_cast<Eigen::Index>(i)];
    all.push_back(
        {&model, {*model.lens(values, kHistorySize), kHistorySize}, MatrixX(share * usual)});
  }
  return all;
}

std::vector<double> keys_of(std::size_t count) {
  std::vector<double> keys;
  for (std::size_t k = 0; k < count; ++k) keys.push_back(static_cast<double>(k));
  return keys;
}

CameraHistory history_of(const HistoryWorld& world, std::uint64_t seed) {
  Random random(seed);
  const auto all = calibrations_of(world, random);
  return estimate_history(all, keys_of(all.size()), samples());
}

const HistoryChange& named(const HistoryFit& fit, const std::string& name) {
  for (const HistoryChange& change : fit.parameters)
    if (change.name == name) return change;
  throw Error(name + ": is no parameter");
}

TEST(History, RaisesNoMoreFalseAlarmsThanItStates) {
  const int num_worlds = 2000;
  for (const auto& [model, count, scatter] :
       std::vector<std::tuple<std::string, int, double>>{{"opencv5", 3, 1},
                                                         {"opencv5", 5, 1},
                                                         {"opencv5", 12, 1},
                                                         {"opencv5", 3, 3},
                                                         {"opencv5", 12, 3},
                                                         {"f", 6, 1},
                                                         {"f", 6, 3},
                                                         {"f", 12, 1},
                                                         {"f", 12, 3}}) {
    int trends = 0, changes = 0, scattered = 0;
    double squares = 0;
    for (int i = 0; i < num_worlds; ++i) {
      const CameraHistory history =
          history_of({model, count, scatter}, static_cast<std::uint64_t>(i));
      trends += history.verdict == HistoryVerdict::trend;
      changes += history.verdict == HistoryVerdict::change;
      squares += history.trend.scatter * history.trend.scatter;
      scattered += history.trend.p_scatter < 0.05;
    }
    std::printf("%s, %d calibrations, scatter %g: %d trends, %d changes of %d, estimated %.2f\n",
                model.c_str(), count, scatter, trends, changes, num_worlds,
                std::sqrt(squares / num_worlds));
    EXPECT_LE(trends + changes, 0.013 * num_worlds) << model << count << " " << scatter;
    EXPECT_NEAR(std::sqrt(squares / num_worlds), scatter, 0.1 * scatter);
    if (scatter > 1)
      EXPECT_GT(scattered, 0.9 * num_worlds);
    else
      EXPECT_NEAR(scattered, 0.05 * num_worlds, 0.02 * num_worlds);
  }
}

// The focal length of a lens that gets longer by temperature, and a distortion with it.
TEST(History, RecoversATrendWithinItsStandardDeviation) {
  const int num_worlds = 300;
  const auto warm = [](double key, std::vector<double>& values) {
    values[0] += 0.3 * key;
    values[1] += 0.3 * key;
  };
  for (const double scatter : {1.0, 2.0}) {
    int found = 0;
    double squares = 0, mean = 0;
    for (int i = 0; i < num_worlds; ++i) {
      const CameraHistory history =
          history_of({"opencv5", 10, scatter, warm}, static_cast<std::uint64_t>(i));
      found += history.verdict == HistoryVerdict::trend;
      const HistoryChange& fx = named(history.trend, "fx");
      squares += std::pow((fx.px - 0.3) / fx.sigma_px, 2) / num_worlds;
      mean += fx.px / num_worlds;
      EXPECT_NEAR(named(history.trend, "distortion").px, 0,
                  5 * named(history.trend, "distortion").sigma_px);
    }
    std::printf("scatter %g: %d trends found of %d, fx %.4f, errors %.2f sd\n", scatter, found,
                num_worlds, mean, std::sqrt(squares));
    EXPECT_GE(found, (scatter > 1 ? 0.7 : 0.99) * num_worlds);
    // A scatter that is estimated from ten calibrations: Student's t of 8 degrees of freedom.
    EXPECT_NEAR(std::sqrt(squares), scatter > 1 ? std::sqrt(8.0 / 6) : 1, 0.12);
    EXPECT_NEAR(mean, 0.3, 0.02);
  }
}

TEST(History, FindsWhereTheCameraChanged) {
  const int num_worlds = 300;
  const auto blow = [](double key, std::vector<double>& values) {
    if (key > 3.5) values[2] += 3;
  };
  int found = 0, right = 0;
  double squares = 0, pixels = 0;
  for (int i = 0; i < num_worlds; ++i) {
    const CameraHistory history =
        history_of({"opencv5", 10, 1, blow}, static_cast<std::uint64_t>(i));
    found += history.verdict == HistoryVerdict::change;
    if (history.verdict != HistoryVerdict::change) continue;
    right += history.step.after == 3 && history.step.before == 4;
    const HistoryChange& cx = named(history.step, "cx");
    squares += std::pow((cx.px - 3) / cx.sigma_px, 2);
    pixels += history.step.image.px / num_worlds;
  }
  std::printf("%d changes found of %d, %d at the right place, cx off by %.2f sd, %.3f px\n", found,
              num_worlds, right, std::sqrt(squares / found), pixels);
  EXPECT_GE(found, 0.95 * num_worlds);
  EXPECT_GE(right, 0.9 * found);
  EXPECT_NEAR(std::sqrt(squares / found), 1, 0.15);
}

// The pixels are those of a comparison of two cameras.
TEST(History, MeasuresPixelsAsADifferenceOfTwoCameras) {
  const auto zoom = [](double key, std::vector<double>& values) {
    values[0] += 20 * key;
    values[1] += 20 * key;
    values[4] += 0.01 * key;
  };
  Random random(1);
  const auto all = calibrations_of({"opencv5", 4, 1e-4, zoom}, random);
  const CameraHistory history = estimate_history(all, keys_of(4), samples());
  EXPECT_EQ(history.verdict, HistoryVerdict::trend);
  const auto difference =
      lens_difference(all.front().camera, all.back().camera, samples(), kInfinitelyFar);
  EXPECT_NEAR(history.trend.image.px, difference->max_px, 0.05 * difference->max_px);
}

TEST(History, TooFewAndTheOrderOfTheKeys) {
  const auto zoom = [](double key, std::vector<double>& values) { values[0] += 20 * key; };
  Random random(2);
  const auto all = calibrations_of({"opencv5", 6, 1, zoom}, random);
  const std::span<const UncertainCamera> some(all);
  EXPECT_EQ(estimate_history(some.first(2), keys_of(2), samples()).verdict,
            HistoryVerdict::too_few);
  const std::vector<double> equal{1, 1, 2, 2, 2, 1};
  EXPECT_EQ(history_of({"f", 5}, 1).verdict, HistoryVerdict::too_few);
  EXPECT_EQ(estimate_history(some, equal, samples()).verdict, HistoryVerdict::too_few);
  std::vector<UncertainCamera> turned(all.rbegin(), all.rend());
  std::vector<double> keys = keys_of(6);
  const double slope = named(estimate_history(some, keys, samples()).trend, "fx").px;
  std::ranges::reverse(keys);
  EXPECT_NEAR(named(estimate_history(turned, keys, samples()).trend, "fx").px, slope, 1e-9);
}

TEST(History, RefusesWhatDoesNotFit) {
  Random random(3);
  const auto right = calibrations_of({"opencv5", 4}, random);
  const auto throws = [&](const std::function<void(std::vector<UncertainCamera>&)>& change,
                          const std::vector<double>& keys = keys_of(4)) {
    std::vector<UncertainCamera> all = right;
    change(all);
    EXPECT_THROW(estimate_history(all, keys, samples()), Error);
  };
  throws([](auto& all) { all.resize(1); }, {0});
  throws([](auto&) {}, {0, 1, 2});
  throws([](auto&) {}, {0, 1, 2, std::nan("")});
  throws([](auto& all) { all[2].camera.image_size.width = 640; });
  throws([](auto& all) { all[1].covariance = MatrixX(); });
  throws([](auto& all) { all[1].model = nullptr; });
  throws([](auto& all) { all[3].camera.lens = fisheye_lens(); });
  throws([](auto& all) {
    all[3].model = &Model::named("radial1");
    all[3].covariance = MatrixX::Identity(5, 5);
  });
}

}  // namespace
}  // namespace tagcal
