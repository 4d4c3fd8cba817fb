// Each code of a finding, and each status, by data that have this trouble. Other tests judge the
// sentences and the numbers; this one sees that no code is without a witness.

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "calibrations.hpp"
#include "finding_cases.hpp"
#include "rolling_worlds.hpp"
#include "spoiled_worlds.hpp"
#include "tagcal/estimate/calibrate.hpp"
#include "tagcal/estimate/pose.hpp"
#include "tagcal/estimate/view_correspondences.hpp"

namespace tagcal {
namespace {

const Substrate kGlassPlate = {Material::glass, Material::glass};
const Lens kPlain = pinhole(900, 900, 639.5, 399.5);

WorldOptions views(int count, double sigma_px = 0.2) {
  WorldOptions options;
  options.num_views = count;
  options.sigma_px = sigma_px;
  return options;
}

Dataset bent(const Lens& lens, double by_m) {
  const WorldOptions options = views(12, 0.1);
  return seen_otherwise(make_world(lens, 5, options), options, [=](TargetPoint& p) {
    p.position.z() += by_m * (1 - std::pow(p.position.x() / 0.33 - 1, 2));
  });
}

// Only corners that lie in the given part of the image.
Dataset where(Dataset world, const std::function<bool(const Eigen::Vector2d&)>& is_kept) {
  for (View& view : world.views)
    std::erase_if(view.observations, [&](const Observation& o) { return !is_kept(o.pixel); });
  return world;
}

Said calibrated(const Dataset& world, const CalibrateOptions& options) {
  const Calibration c = calibrate(world, options);
  return {c.status, codes_of(c.findings)};
}

// The usual world, changed in its views.
Dataset changed(const std::function<void(std::vector<View>&)>& change) {
  Dataset world = make_world(opencv5_lens(), 3, views(10));
  change(world.views);
  return world;
}

Dataset spoiled(const std::function<void(SpoiledWorld&, Random&)>& spoil) {
  SpoiledWorld world = untouched(make_world(opencv5_lens(), 3, views(10)));
  Random random(4);
  spoil(world, random);
  return world.dataset;
}

Dataset all_mirrored() {
  return spoiled([](SpoiledWorld& world, Random&) {
    for (std::size_t v = 0; v < world.dataset.views.size(); ++v) mirror(world, v);
  });
}

Dataset of_half_the_size() {
  Dataset dataset = make_world(opencv5_lens(), 5, views(12));
  dataset.image_size = {dataset.image_size.width / 2, dataset.image_size.height / 2};
  return dataset;
}

Dataset printed_with_moved_tag() {
  return seen_otherwise(make_world(opencv5_lens(), 5, views(12)), views(12), [](TargetPoint& p) {
    if (p.id.tag_id == 17) p.position.x() += 1.5e-3;
  });
}

// Each tag of the usual board by a hundredth larger about its own centre.
Dataset printed_with_larger_tags() {
  return seen_otherwise(make_world(opencv5_lens(), 5, views(12)), views(12), [](TargetPoint& p) {
    const double pitch = 1.3 * 0.088;
    const Eigen::Vector3d centre(p.id.tag_id % 6 * pitch + 0.044, p.id.tag_id / 6 * pitch + 0.044,
                                 0);
    p.position = centre + 1.01 * (p.position - centre);
  });
}

// A wave over the image, which no lens has.
Dataset waved() {
  return changed([](auto& all) {
    for (View& view : all)
      for (Observation& o : view.observations) o.pixel.x() += 0.3 * std::sin(o.pixel.y() / 40);
  });
}

// Another lens in every second view.
Dataset focused_anew() {
  WorldOptions options = views(16);
  options.sigma_px = 0.02;
  Dataset world = make_world(opencv5_lens(), 3, options);
  auto parameters = std::get<Perspective>(opencv5_lens()).parameters();
  parameters[4] += 0.05;
  const Dataset other = make_world(Perspective(parameters), 3, options);
  for (std::size_t i = 1; i < world.views.size(); i += 2) world.views[i] = other.views[i];
  return world;
}

// Every second view from another source, all of them kept.
CalibrateOptions by_turns(int num_views) {
  CalibrateOptions options;
  options.reject_outliers = false;
  for (int i = 0; i < num_views; ++i) options.sources.emplace_back(i % 2 == 0 ? "left" : "right");
  return options;
}

Dataset printed_longer_in_y(double share) {
  return seen_otherwise(make_world(opencv5_lens(), 5, views(12)), views(12),
                        [&](TargetPoint& p) { p.position.y() *= 1 + share; });
}

// A denominator that vanishes at 711 px from the centre, inside of the image's corners.
Dataset seen_with_a_pole() {
  WorldOptions options = views(12);
  options.sigma_px = 0.01;
  return make_world(Perspective({900, 900, 639.5, 399.5, -1.9, 0, 0, 0, 0, -1.6}), 3, options);
}

// Ten views with the board at one tilt of 30 degrees.
Dataset parallel() {
  WorldOptions options = views(1);
  options.min_tilt_deg = options.max_tilt_deg = 30;
  Dataset world = make_world(kPlain, 2, options);
  const Pose first = world.truth->camera_from_world.at("0.png");
  Random random(7);
  for (int i = 1; i < 10; ++i) {
    const Eigen::Vector3d by(0.05 * random.normal(), 0.05 * random.normal(), 0.1 * random.normal());
    world.views.push_back(observe(world.truth->camera,
                                  Pose(first.rotation(), first.translation() + by),
                                  target_points(world.boards[0].board), options, random));
    world.views.back().image = std::to_string(i) + ".png";
  }
  return world;
}

// Each view with its own shear of the rows, and a bow that no velocity of a camera has.
Dataset sheared() {
  return changed([](auto& all) {
    Random random(8);
    for (View& view : all) {
      const Eigen::Vector2d by = 0.003 * Eigen::Vector2d(random.normal(), random.normal());
      const double bow = 0.003 / 640 * random.normal();
      for (Observation& o : view.observations)
        o.pixel += by * (o.pixel.y() - 400) +
                   bow * std::pow(o.pixel.x() - 640, 2) * Eigen::Vector2d::Ones();
    }
  });
}

Dataset rolled() {
  const Dataset still = make_world(opencv5_lens(), 3, views(10));
  Random random(8);
  return with_noise(rolling_world(still, random_velocities(10, 0.2, 0.2, random), 0.02), 0.2, 3);
}

CalibrateOptions a_second_apart(int num_views) {
  CalibrateOptions options;
  for (int i = 0; i < num_views; ++i) options.times_s.push_back(i);
  return options;
}

Dataset tilted_by(double max_deg, const Lens& lens, int count) {
  WorldOptions options = views(count);
  options.max_tilt_deg = max_deg;
  return make_world(lens, 2, options);
}

bool in_the_middle(const Eigen::Vector2d& p) {
  return (p - Eigen::Vector2d(640, 400)).norm() < 150;
}

std::vector<Case> cases_of_data() {
  const CalibrateOptions automatic;
  CalibrateOptions quiet = with_model("opencv5");
  quiet.sigma_px = 0.05;
  const auto with_covariances = [](std::vector<View>& all) {
    for (View& view : all)
      for (Observation& o : view.observations)
        if (o.id.tag_id != 0) o.covariance_px2 = 0.04 * Eigen::Matrix2d::Identity();
  };
  const Pose off(Eigen::Quaterniond::Identity(), {0.05, 0.02, 0});
  return {
      {"view_unusable",
       calibrated(changed([](auto& all) { all[3].observations.resize(3); }), automatic)},
      {"view_repeated", calibrated(changed([](auto& all) {
                                     all.push_back(all[3]);
                                     all.back().image = "again.png";
                                   }),
                                   automatic)},
      {"view_mirrored", calibrated(all_mirrored(), automatic)},
      {"no_consensus", calibrated(all_mirrored(), automatic)},
      {"corners_outside", calibrated(of_half_the_size(), automatic)},
      {"view_rejected",
       calibrated(spoiled([](auto& w, Random& random) { spoil_view(w, 2, random); }), automatic)},
      {"board_moved", calibrated(moved_board(opencv5_lens(), 3, 15, 0, 4, off).dataset, automatic)},
      {"corners_rejected",
       calibrated(spoiled([](auto& w, Random& random) { spoil_corners(w, 0.2, 0, random); }),
                  automatic)},
      {"covariance_missing", calibrated(changed(with_covariances), automatic)},
      {"noise_assumed", calibrated(where(make_world(kPlain, 2, views(1)),
                                         [](const auto& p) { return p.x() > 600 && p.x() < 700; }),
                                   with_model("opencv5"))},
      {"noise_understated", calibrated(make_world(opencv5_lens(), 3, views(10)), quiet)},
  };
}

std::vector<Case> cases_of_target_and_model() {
  const CalibrateOptions automatic;
  CalibrateOptions keep_all;
  keep_all.reject_outliers = false;
  const Dataset barrel =
      make_world(Perspective({744, 744, 655, 398, -0.267, -0.0067}), 2, views(8));
  return {
      {"tags_misplaced", calibrated(printed_with_moved_tag(), automatic)},
      {"tag_scale", calibrated(printed_with_larger_tags(), automatic)},
      {"board_bent", calibrated(bent(opencv5_lens(), 1e-3), automatic)},
      {"flatness_exceeded",
       calibrated(made_of(bent(opencv5_lens(), 1e-3), kGlassPlate), automatic)},
      {"board_bend_impossible", calibrated(bent(opencv5_lens(), 20e-3), automatic)},
      {"residuals_biased", calibrated(waved(), automatic)},
      {"halves_disagree", calibrated(focused_anew(), keep_all)},
      {"sources_disagree", calibrated(focused_anew(), by_turns(16))},
      {"print_aspect", calibrated(printed_longer_in_y(0.004), automatic)},
      {"print_exceeded", calibrated(printed_longer_in_y(0.02), automatic)},
      {"rows_displaced", calibrated(sheared(), automatic)},
      {"rolling_shutter", calibrated(rolled(), automatic)},
      {"readout_not_observable", calibrated(rolled(), a_second_apart(10))},
      {"model_too_small", calibrated(make_world(opencv5_lens(), 3, views(10)), with_model("f+c"))},
      {"other_lens", calibrated(make_world(opencv5_lens(), 3, views(10)), with_model("fisheye4"))},
      {"perspective_seen",
       calibrated(make_world(opencv5_lens(), 3, views(10)), with_model("weak"))},
      {"pole_in_image", calibrated(seen_with_a_pole(), with_model("opencv8"))},
      {"fold_in_image", calibrated(barrel, automatic)},
  };
}

std::vector<Case> cases_of_limits() {
  const CalibrateOptions automatic;
  const Dataset middle = where(make_world(opencv5_lens(), 2, views(8)), in_the_middle);
  return {
      {"focal_not_observable", calibrated(tilted_by(0, kPlain, 3), automatic)},
      {"not_observable", calibrated(tilted_by(2, kPlain, 15), with_model("f"))},
      {"direction_weak", calibrated(make_world(opencv5_lens(), 3, views(10)), with_model("f"))},
      {"coefficients_correlated", calibrated(middle, with_model("opencv8"))},
      {"extrapolated", calibrated(middle, automatic)},
      {"principal_point_untested", calibrated(parallel(), with_model("f"))},
      {"few_views", calibrated(make_world(kPlain, 2, views(2)), with_model("f"))},
      {"tilt_unknown", calibrated(tilted_by(0, kPlain, 3), with_model("weak"))},
  };
}

Said pose_of(const std::vector<Correspondence>& seen, const Lens& lens,
             const PoseOptions& options) {
  const PoseEstimate e = estimate_pose(seen, Camera{lens, {1280, 800}}, options);
  return {e.status, codes_of(e.findings)};
}

// Of the first view.
Said pose_in(const Dataset& dataset, const Lens& lens) {
  const PoseEstimate e = estimate_pose(view_correspondences(dataset.views[0], dataset.boards),
                                       Camera{lens, dataset.image_size});
  return {e.status, codes_of(e.findings)};
}

Said pose_and_focal_in(const Dataset& dataset) {
  const PoseAndFocalEstimate e = estimate_pose_and_focal(
      view_correspondences(dataset.views[0], dataset.boards), dataset.image_size);
  return {e.status, codes_of(e.findings)};
}

std::vector<Correspondence> seen_in(const Lens& lens, const std::vector<Eigen::Vector3d>& points,
                                    double tilt_rad, double distance_m) {
  Random random(7);
  const Pose pose = looking_at_board(points.front(), tilt_rad, distance_m, random);
  return seen_by(lens, points, pose, 0.2, random);
}

std::vector<Case> cases_of_poses() {
  std::vector<Eigen::Vector3d> line;
  for (int i = 0; i < 5; ++i) line.emplace_back(0.1 * i, 0, 0);
  return {
      {"view_mirrored", pose_in(all_mirrored(), opencv5_lens())},
      {"corners_outside", pose_in(of_half_the_size(), opencv5_lens())},
      {"corners_outside", pose_and_focal_in(of_half_the_size())},
      {"degenerate", pose_of(seen_in(kPlain, line, 0.5, 1), kPlain, {.sigma_px = 0.2})},
      {"not_converged", pose_of(seen_in(opencv5_lens(), board_points(), 1, 0.8), opencv5_lens(),
                                {.sigma_px = 0.2, .max_iterations = 0})},
      {"residuals_correlated",
       pose_of(seen_in(opencv5_lens(), board_points(), 0.5, 0.8),
               Perspective({900, 898, 651, 392, -0.145, 0.05, 5e-4, -3e-4}), {.sigma_px = 0.2})},
  };
}

// The pictures of two cameras with other focal lengths, as one.
Said of_two_cameras() {
  Dataset set = make_world(opencv5_lens(), 5, views(20, 0.1));
  auto parameters = std::get<Perspective>(opencv5_lens()).parameters();
  parameters[0] += 10;
  parameters[1] += 10;
  const Dataset other = make_world(Perspective(parameters), 5, views(20, 0.1));
  CalibrateOptions options = with_model("opencv5");
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    options.sources.emplace_back(v < 10 ? "left" : "right");
    if (v >= 10) set.views[v] = other.views[v];
  }
  options.reject_outliers = false;
  const Calibration c = calibrate(set, options);
  return {c.status, codes_of(c.findings)};
}

std::vector<Case> made_cases() {
  std::vector<Case> cases;
  for (const auto& some : {cases_of_data(),
                           cases_of_target_and_model(),
                           cases_of_limits(),
                           cases_of_poses(),
                           cases_of_fleets(),
                           cases_of_checks(),
                           {{"sources_disagree", of_two_cameras()}}})
    cases.insert(cases.end(), some.begin(), some.end());
  return cases;
}

const std::vector<Case>& all_cases() {
  static const std::vector<Case> cases = made_cases();
  return cases;
}

// As the header lists them.
std::set<std::string> listed_codes() {
  std::ifstream header(TAGCAL_SOURCE_DIR "/lib/tagcal/estimate/findings.hpp");
  const std::regex definition(R"re(inline constexpr FindingCode ([a-z_]+)\{)re");
  std::set<std::string> codes;
  std::smatch name;
  for (std::string line; std::getline(header, line);)
    if (std::regex_search(line, name, definition)) codes.insert(name[1]);
  return codes;
}

TEST(EveryFinding, HasDataThatCauseIt) {
  // What the commands add themselves: cli_pose_test, cli_calibration_test.
  // Of a wheel: calibrate_rig_test.
  std::set<std::string> reached = {"input", "target_unseen", "extrinsic_not_observable"};
  // Of robots: handeye_test, handeye_claims_test.
  reached.insert({"rotation_axes_parallel", "no_rotation", "wrong_direction", "board_scale"});
  reached.insert("held_contradicted");  // overrule_test
  reached.insert("scale_untested");     // check_camera_test
  reached.insert("lens_without_covariance");
  for (const RigFindingCase& c : cases_of_rigs()) reached.insert(c.code);  // rig_findings_test
  for (const Case& c : all_cases()) {
    EXPECT_TRUE(c.said.codes.contains(c.code)) << c.code << testing::PrintToString(c.said.codes);
    reached.insert(c.code);
  }
  EXPECT_EQ(reached, listed_codes());
}

TEST(EveryStatus, HasDataThatCauseIt) {
  std::map<Status, int> count;
  for (const Case& c : all_cases()) {
    ++count[c.said.status];
    // A refusal says why by the code of its status.
    EXPECT_TRUE(is_answer(c.said.status) || c.code == "few_units" ||
                c.said.codes.contains(std::string(status_name(c.said.status))))
        << c.code;
  }
  // A small tag far away, nearly frontal.
  ++count[pose_of(seen_in(kPlain, tag_points(0.1), 0.3, 2), kPlain, {.sigma_px = 0.5}).status];
  for (const Status status :
       {Status::ok, Status::ambiguous, Status::focal_not_observable, Status::not_observable,
        Status::degenerate, Status::no_consensus, Status::not_converged})
    EXPECT_GT(count[status], 0) << status_name(status);
}

}  // namespace
}  // namespace tagcal
