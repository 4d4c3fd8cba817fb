// What a user states instead of having it found: fixed parameters, a start, no rejection.
#include "tagcal/error.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "worlds.hpp"

namespace tagcal {
namespace {

CalibrateOptions options_of(const std::string& model,
                            const std::map<std::string, double>& fixed = {}) {
  CalibrateOptions options;
  options.model = model;
  options.fixed = fixed;
  return options;
}

std::string error_of(const CalibrateOptions& options) {
  try {
    check_options(options);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

void expect_near_truth(const Calibration& c, const Lens& truth) {
  ASSERT_TRUE(is_answer(c.status)) << status_name(c.status);
  for (std::size_t i = 0; i < parameters(truth).size(); ++i)
    EXPECT_LE(std::abs(parameters(c.camera->lens)[i] - parameters(truth)[i]),
              5 * c.sigmas[i] + 1e-12)
        << c.model << " " << parameter_names(truth)[i];
}

TEST(Overrule, WhatIsFixedIsHeldAndCountsAsExact) {
  const Dataset world = make_world(opencv5_lens(), 11);
  const Calibration open = calibrate(world, options_of("opencv5"));
  const std::map<std::string, double> fixed = {{"cx", 651}, {"cy", 392}, {"k3", 0}};
  const Calibration held = calibrate(world, options_of("opencv5", fixed));
  expect_near_truth(held, opencv5_lens());
  EXPECT_EQ(held.model, "opencv5");
  EXPECT_EQ(held.fixed, fixed);
  EXPECT_EQ(held.covariance.rows(), 6);
  const Lens truth = opencv5_lens();
  for (const std::size_t i : {2U, 3U, 8U}) {
    EXPECT_EQ(held.sigmas[i], 0);
    EXPECT_EQ(parameters(held.camera->lens)[i], parameters(truth)[i]);
  }
  // It is correlated with what is held. The spread between the views, which is in both, is itself
  // known to some per cent only.
  EXPECT_LT(held.sigmas[4], open.sigmas[4]);
  EXPECT_LT(held.sigmas[0], 1.05 * open.sigmas[0]);
  EXPECT_LT(held.projection[0].region_px, 1.05 * open.projection[0].region_px);
}

TEST(Overrule, AutoChoosesAmongTheModelsThatHoldIt) {
  const Dataset world = make_world(opencv5_lens(), 12);
  const Calibration centre = calibrate(world, options_of("", {{"cx", 651}, {"cy", 392}}));
  expect_near_truth(centre, opencv5_lens());
  EXPECT_EQ(parameters(centre.camera->lens)[2], 651);
  EXPECT_EQ(centre.sigmas[2], 0);
  for (const ModelStep& step : centre.steps) EXPECT_NE(step.model, "f+c");  // it is f
  const Calibration focal = calibrate(world, options_of("auto", {{"fx", 900}, {"fy", 898}}));
  expect_near_truth(focal, opencv5_lens());
  EXPECT_EQ(focal.fixed, (std::map<std::string, double>{{"fx", 900}, {"fy", 898}}));
  for (const ModelStep& step : focal.steps) EXPECT_NE(step.model, "f");  // nothing open in it
}

TEST(Overrule, TheFocalLengthOfAFisheyeToo) {
  const Dataset world = make_world(fisheye_lens(), 13);
  const Calibration c = calibrate(world, options_of("fisheye4", {{"fy", 419}, {"k4", -0.0005}}));
  expect_near_truth(c, fisheye_lens());
  EXPECT_EQ(c.sigmas[1], 0);
  EXPECT_EQ(c.covariance.rows(), 6);
}

bool says_contradicted(const Calibration& c) {
  return std::ranges::count(c.findings, "held_contradicted", &Finding::code) > 0;
}

// A value that is wrong is the user's: it is held all the same, and the answer says so.
TEST(Overrule, AWrongValueIsHeldAndContradicted) {
  const Dataset world = make_world(opencv5_lens(), 14);
  for (const std::string model : {"opencv5", "auto"}) {
    const Calibration wrong = calibrate(world, options_of(model, {{"f", 950}}));
    ASSERT_TRUE(wrong.camera.has_value());
    EXPECT_EQ(parameters(wrong.camera->lens)[0], 950);
    EXPECT_EQ(parameters(wrong.camera->lens)[1], 950);
    ASSERT_TRUE(says_contradicted(wrong)) << model;
    EXPECT_NE(wrong.findings.front().sentence.find("fx 950 (without it "), std::string::npos);
    EXPECT_FALSE(
        says_contradicted(calibrate(world, options_of(model, {{"fx", 900}, {"fy", 898}}))));
  }
}

// Model f holds the principal point itself, and its value there says nothing about another one.
TEST(Overrule, WhatTheModelHoldsContradictsNothing) {
  const Dataset world = make_world(Perspective({900, 900, 700, 380}), 17);
  EXPECT_FALSE(says_contradicted(calibrate(world, options_of("f", {{"cx", 700}, {"cy", 380}}))));
}

// The rows of exact pictures are where they are, whatever lens is asked for.
TEST(Overrule, ALensThatIsTooSmallDisplacesNoRows) {
  const Dataset world = make_world(opencv5_lens(), 16, {.num_views = 12, .sigma_px = 0.01});
  for (const CalibrateOptions& options :
       {options_of("f"), options_of("pinhole"), options_of("radial1"), options_of("fisheye4"),
        options_of("auto", {{"f", 897}}), options_of("auto", {{"cx", 300}})}) {
    const Calibration c = calibrate(world, options);
    EXPECT_EQ(c.row_sigma, 0) << c.model;
    EXPECT_EQ(std::ranges::count(c.findings, "rows_displaced", &Finding::code), 0) << c.model;
  }
}

TEST(Overrule, WhatCannotBeHeldIsAnError) {
  using Fixed = std::map<std::string, double>;
  EXPECT_EQ(error_of(options_of("opencv5", {{"k9", 1}})).substr(0, 37),
            "fixed: must be one of f, fx, fy, cx, ");
  EXPECT_NE(error_of(options_of("opencv5", {{"fx", -3}})).find("fx must be > 0"),
            std::string::npos);
  EXPECT_NE(error_of(options_of("opencv5", {{"cx", std::nan("")}})), "");
  EXPECT_NE(error_of(options_of("opencv5", {{"f", 900}, {"fx", 900}})).find("twice"),
            std::string::npos);
  EXPECT_NE(error_of(options_of("auto", {{"k3", 0}})).find("needs a model by its name"),
            std::string::npos);
  EXPECT_NE(error_of(options_of("fisheye4", {{"p1", 0}})), "");
  EXPECT_NE(error_of(options_of("opencv5", {{"k4", 0}})), "");
  EXPECT_NE(error_of(options_of("f", {{"f", 900}})).find("left to estimate"), std::string::npos);
  EXPECT_NE(error_of(options_of("weak", {{"cx", 900}})), "");
  for (const Fixed& good : {Fixed{{"f", 900}}, Fixed{{"k1", 0.1}, {"cx", 1}}})
    EXPECT_EQ(error_of(options_of("opencv8", good)), "");
}

TEST(Overrule, AStartLeadsToTheSameMinimum) {
  const Dataset world = make_world(opencv5_lens(), 15);
  const Calibration own = calibrate(world, options_of("opencv5"));
  CalibrateOptions options = options_of("opencv5");
  options.start = Camera{Perspective({850, 850, 640, 400, -0.1}), {1280, 800}};
  const Calibration from_camera = calibrate(world, options);
  options.start.reset();
  options.start_focal_px = 1000;
  const Calibration from_focal = calibrate(world, options);
  for (const Calibration* c : {&from_camera, &from_focal}) {
    ASSERT_EQ(c->status, Status::ok);
    EXPECT_NEAR(parameters(c->camera->lens)[0], parameters(own.camera->lens)[0],
                0.01 * own.sigmas[0]);
  }
}

TEST(Overrule, AStartMustFit) {
  CalibrateOptions options = options_of("opencv5");
  options.start = Camera{fisheye_lens(), {1280, 800}};
  EXPECT_NE(error_of(options).find("start: is a fisheye lens, model opencv5"), std::string::npos);
  options.start->lens = opencv5_lens();
  EXPECT_EQ(error_of(options), "");
  options.start->image_size = {640, 480};
  EXPECT_THROW(calibrate(make_world(opencv5_lens(), 1), options), Error);
  options.start_focal_px = 800;
  EXPECT_NE(error_of(options).find("not both"), std::string::npos);
  options.start.reset();
  EXPECT_EQ(error_of(options), "");
  options.start_focal_px = -800;
  EXPECT_NE(error_of(options), "");
}

// Wrong corners and a view that moved stay where nothing is to be rejected; repeats do not.
TEST(Overrule, KeepAllKeepsAllButRepeats) {
  Dataset world = make_world(opencv5_lens(), 16, {.num_views = 8});
  std::size_t num_corners = 0;
  for (const View& view : world.views) num_corners += view.observations.size();
  world.views[2].observations[5].pixel.x() += 30;
  for (Observation& o : world.views[4].observations)
    if (o.id.tag_id < 18) o.pixel += Eigen::Vector2d(6, 3);
  world.views.push_back(world.views[0]);
  world.views.back().image = "again.png";
  CalibrateOptions options = options_of("opencv5");
  EXPECT_FALSE(calibrate(world, options).outliers.empty());
  options.reject_outliers = false;
  const Calibration all = calibrate(world, options);
  EXPECT_TRUE(all.outliers.empty());
  EXPECT_EQ(all.views.size(), 8u);
  EXPECT_EQ(static_cast<std::size_t>(all.num_corners), num_corners);
}

// A view whose corners have no common map from the board: least median of squares finds none.
TEST(Overrule, KeepAllDoesWithoutTheConsensusOfAView) {
  Dataset world = make_world(opencv5_lens(), 17, {.num_views = 8});
  std::vector<Observation>& spoiled = world.views[4].observations;
  const std::vector<Observation> before = spoiled;
  for (std::size_t i = 0; i < spoiled.size(); ++i)
    spoiled[i].pixel = before[(7 * i + i * i) % spoiled.size()].pixel;
  CalibrateOptions options = options_of("opencv5");
  expect_near_truth(calibrate(world, options), opencv5_lens());
  options.reject_outliers = false;
  for (const Outlier& o : calibrate(world, options).outliers) EXPECT_EQ(o.view, 4u);  // no pose
}

}  // namespace
}  // namespace tagcal
